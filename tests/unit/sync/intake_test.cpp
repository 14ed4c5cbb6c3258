#include "sync/intake.h"

#include <gtest/gtest.h>

#include <thread>

namespace roseau::sync {
namespace {

Sample stamped(StreamId stream, std::int64_t arrival_ns) {
  Sample sample;
  sample.header.stream = stream;
  sample.header.arrival_time = host_time_from_ns(arrival_ns);
  sample.payload = WindSample{};
  return sample;
}

TEST(Intake, LiveSourceDropsTheNewestAndCounts) {
  CounterTable counters;
  Intake intake(counters);
  Inlet& inlet = intake.add_inlet(true, 4);
  int accepted = 0;
  for (int i = 0; i < 10; ++i) accepted += inlet.receive(stamped(3, i)) ? 1 : 0;
  inlet.finish();
  std::vector<std::int64_t> taken;
  intake.run(
      {}, [&](const Sample& sample) { taken.push_back(to_ns(sample.header.arrival_time)); }, [] {});
  EXPECT_EQ(accepted, 4);
  EXPECT_EQ(taken, (std::vector<std::int64_t>{0, 1, 2, 3}));
  EXPECT_EQ(counters.of(3).dropped.load(), 6U);
}

TEST(Intake, MergesByArrivalAndLosesNothingFromSourcesThatCanWait) {
  CounterTable counters;
  Intake intake(counters);
  constexpr int kCount = 20000;
  Inlet& even = intake.add_inlet(false, 8);
  Inlet& odd = intake.add_inlet(false, 8);
  std::jthread first([&even] {
    for (int i = 0; i < kCount; i += 2) even.receive(stamped(0, i));
    even.finish();
  });
  std::jthread second([&odd] {
    for (int i = 1; i < kCount; i += 2) odd.receive(stamped(1, i));
    odd.finish();
  });
  std::int64_t expected = 0;
  bool in_order = true;
  intake.run(
      {}, [&](const Sample& sample) { in_order = in_order && to_ns(sample.header.arrival_time) == expected++; }, [] {});
  EXPECT_TRUE(in_order);
  EXPECT_EQ(expected, kCount);
  EXPECT_EQ(counters.of(0).dropped.load() + counters.of(1).dropped.load(), 0U);
}

TEST(Intake, CloseFreesAWaitingSource) {
  CounterTable counters;
  Intake intake(counters);
  Inlet& inlet = intake.add_inlet(false, 2);
  std::jthread producer([&inlet] {
    while (inlet.receive(stamped(0, 0))) {
    }
  });
  intake.close();
  producer.join();
  EXPECT_GE(counters.of(0).dropped.load(), 1U);
}

}  // namespace
}  // namespace roseau::sync
