#include "sync/intake.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

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
  intake.run({}, {.take = [&](const Sample& sample) { taken.push_back(to_ns(sample.header.arrival_time)); }, .idle = [] {}});
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
  intake.run({}, {.take = [&](const Sample& sample) { in_order = in_order && to_ns(sample.header.arrival_time) == expected++; },
                  .idle = [] {}});
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

/// What an intake hands over, as text.
struct Log {
  std::vector<std::string> lines;
  Intake::Callbacks callbacks() {
    return {.take = [this](const Sample& sample) { lines.push_back(std::to_string(to_ns(sample.header.arrival_time))); },
            .idle = [] {},
            .flush = [this] { lines.emplace_back("flush"); },
            .restart = [this](bool discard) { lines.emplace_back(discard ? "discard" : "restart"); }};
  }
};

TEST(Intake, FlushesAndRestartsBehindWhatWasReceivedBefore) {
  CounterTable counters;
  Intake intake(counters);
  Inlet& inlet = intake.add_inlet(false, 4);
  std::jthread producer([&inlet] {
    for (int i = 0; i < 9; ++i) inlet.receive(stamped(0, i));
    inlet.flush();
    inlet.restart(/*discard=*/false);
    inlet.receive(stamped(0, 3));
    inlet.finish();
  });
  Log log;
  intake.run({}, log.callbacks());
  EXPECT_EQ(log.lines, (std::vector<std::string>{"0", "1", "2", "3", "4", "5", "6", "7", "8", "flush", "restart", "3"}));
  EXPECT_EQ(counters.of(0).dropped.load(), 0U);
}

TEST(Intake, ARestartThrowsAwayWhatIsNotWantedAnyMore) {
  CounterTable counters;
  Intake intake(counters);
  Inlet& inlet = intake.add_inlet(false, 64);
  for (int i = 0; i < 9; ++i) inlet.receive(stamped(0, i));
  std::jthread producer([&inlet] {
    inlet.restart(/*discard=*/true);
    inlet.receive(stamped(0, 5));
    inlet.finish();
  });
  // The request stands before anything is taken.
  while (!inlet.is_asking()) std::this_thread::yield();
  Log log;
  intake.run({}, log.callbacks());
  EXPECT_EQ(log.lines, (std::vector<std::string>{"discard", "5"}));
}

TEST(Intake, CloseFreesASourceThatWaitsForARestart) {
  CounterTable counters;
  Intake intake(counters);
  Inlet& inlet = intake.add_inlet(false, 4);
  std::jthread producer([&inlet] { inlet.restart(/*discard=*/false); });
  while (!inlet.is_asking()) std::this_thread::yield();
  intake.close();
  producer.join();
  SUCCEED() << "nobody runs the intake, and nobody hangs";
}

}  // namespace
}  // namespace roseau::sync
