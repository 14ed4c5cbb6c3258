#include "synthesis/instruments/device_timing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace roseau::synthesis {
namespace {

constexpr DeviceTiming kPlain;
DeviceTiming wandering() {
  DeviceTiming timing;
  timing.frequency_offset_ppm = -40;
  timing.start_offset_s = 0.25;
  timing.counter_offset_s = 1000;
  timing.wander_ppm = 2;
  timing.wander_time_s = 100;
  return timing;
}

TEST(SimulatedClock, WithoutWanderItIsALine) {
  DeviceTiming timing;
  timing.frequency_offset_ppm = 100;
  timing.start_offset_s = 2;
  timing.counter_offset_s = 50;
  const SimulatedClock clock(timing, 1, 1);
  EXPECT_DOUBLE_EQ(clock.device_time_s(2), 50);
  EXPECT_DOUBLE_EQ(clock.device_time_s(1002), 50 + 1000.1);
  EXPECT_NEAR(clock.frequency_offset_ppm(5), 100, 1e-9);
  EXPECT_EQ(clock.wander_s(500), 0);
  EXPECT_EQ(clock.allan_deviation(10), 0);
}

TEST(SimulatedClock, TimesGoBothWays) {
  const SimulatedClock clock(wandering(), 7, 2000);
  EXPECT_NEAR(clock.device_time_s(0.25), 1000, 1e-12);
  for (double time_s = 0; time_s < 5000; time_s += 13.7) {
    EXPECT_NEAR(clock.time_of_s(clock.device_time_s(time_s)), time_s, 2e-12 * (1000 + time_s)) << time_s;
  }
}

TEST(SimulatedClock, FrequencyIsTheSlopeOfTime) {
  const SimulatedClock clock(wandering(), 7, 2000);
  for (double time_s = 0; time_s < 300; time_s += 7) {
    const double slope = clock.device_time_s(time_s + 0.5) - clock.device_time_s(time_s - 0.5);
    EXPECT_NEAR((slope - 1) * 1e6, clock.frequency_offset_ppm(time_s), 0.02) << time_s;
  }
}

TEST(SimulatedClock, WanderHasItsStatedSizeAndStaysBounded) {
  const SimulatedClock clock(wandering(), 3, 5);
  double sum = 0;
  double largest_s = 0;
  constexpr int kSeconds = 20000;
  for (int i = 0; i < kSeconds; ++i) {
    sum += std::pow(clock.frequency_offset_ppm(i) + 40, 2);
    largest_s = std::max(largest_s, std::abs(clock.wander_s(i)));
  }
  EXPECT_NEAR(std::sqrt(sum / kSeconds), 2, 0.1);
  // 2 ppm over a period of 100 s: 2e-6 * 100 / 2 pi, in a few waves.
  EXPECT_GT(largest_s, 10e-6);
  EXPECT_LT(largest_s, 200e-6);
}

TEST(SimulatedClock, AllanDeviationIsThatOfItsTimes) {
  const SimulatedClock clock(wandering(), 3, 5);
  for (const double averaging_s : {1.0, 5.0, 20.0}) {
    double sum = 0;
    int count = 0;
    for (double time_s = 0; time_s < 20000; time_s += averaging_s / 2, ++count) {
      const double second_difference =
          clock.wander_s(time_s + 2 * averaging_s) - 2 * clock.wander_s(time_s + averaging_s) + clock.wander_s(time_s);
      sum += std::pow(second_difference / averaging_s, 2) / 2;
    }
    const double measured = std::sqrt(sum / count);
    EXPECT_NEAR(measured / clock.allan_deviation(averaging_s), 1, 0.05) << averaging_s;
  }
}

TEST(SimulatedClock, TheStateIsWhatMapsDeviceTimeToTheHosts) {
  const SimulatedClock clock(wandering(), 7, 2000);
  const HostTime start = host_time_from_ns(5'000'000'000);
  const ClockState state = clock.state("board", start, 123.5);
  EXPECT_EQ(state.device, "board");
  EXPECT_NEAR(clock.device_time_s(123.5) + state.offset_s, 5 + 123.5, 1e-9);
  EXPECT_NEAR(state.frequency_offset_ppm, -40, 8);
}

TEST(SampleTimes, ADeviceCountsOnItsOwnClock) {
  DeviceTiming timing = wandering();
  const SampleTimes times(20, timing, 7, 2000);
  for (const std::uint64_t number : {0, 1, 1000, 100000}) {
    const double device_s = times.clock().device_time_s(times.sample_time_s(number));
    EXPECT_NEAR(device_s, 1000 + static_cast<double>(number) / 20, 1e-9);
    EXPECT_EQ(times.first_from(times.sample_time_s(number)), number);
    EXPECT_EQ(times.first_from(times.sample_time_s(number) + 1e-6), number + 1);
  }
}

TEST(SampleTimes, SpikesComeOnTopOfLatencyAndJitter) {
  DeviceTiming timing;
  timing.latency_s = 0.01;
  timing.jitter_s = 0.001;
  const SampleTimes calm(20, timing, 1, 1);
  timing.spike_probability = 0.02;
  timing.spike_s = 0.2;
  const SampleTimes spiky(20, timing, 1, 1);
  int spikes = 0;
  double extra_s = 0;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    ASSERT_GE(calm.delay_s(i), 0.01);
    const double further_s = spiky.delay_s(i) - calm.delay_s(i);
    if (further_s == 0) continue;
    ++spikes;
    extra_s += further_s;
  }
  EXPECT_NEAR(spikes, 400, 60);
  EXPECT_NEAR(extra_s / spikes, 0.2, 0.03);
}

class Drops : public ::testing::TestWithParam<double> {};

TEST_P(Drops, HaveTheirShareAndLength) {
  DeviceTiming timing;
  timing.drop_probability = 0.05;
  timing.drop_burst = GetParam();
  const SampleTimes times(30, timing, 9, 1000);
  int lost = 0;
  int bursts = 0;
  bool before = false;
  constexpr int kCount = 100000;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const bool now = times.is_dropped(i);
    lost += now ? 1 : 0;
    bursts += now && !before ? 1 : 0;
    before = now;
  }
  EXPECT_NEAR(static_cast<double>(lost) / kCount, 0.05, 3 * std::sqrt(0.05 * 2 * GetParam() / kCount));
  // Bursts that touch count as one here, so they look a little longer.
  EXPECT_NEAR(static_cast<double>(lost) / bursts / GetParam(), 1.05, 0.12);
}
INSTANTIATE_TEST_SUITE_P(Bursts, Drops, ::testing::Values(1.0, 3.0, 20.0));

TEST(SampleTimes, NothingIsLostUnlessAsked) {
  const SampleTimes times(30, kPlain, 9, 1000);
  for (std::uint64_t i = 0; i < 1000; ++i) EXPECT_FALSE(times.is_dropped(i));
  EXPECT_FALSE(times.is_pulled(5));
}

TEST(SampleTimes, ACableIsOutFromToAndFromTo) {
  DeviceTiming timing;
  timing.cable_pulls_s = {10, 12, 20, 20.5};
  const SampleTimes times(30, timing, 9, 1000);
  EXPECT_FALSE(times.is_pulled(9.999));
  EXPECT_TRUE(times.is_pulled(10));
  EXPECT_EQ(times.pulled_until_s(11), 12);
  EXPECT_FALSE(times.is_pulled(12));
  EXPECT_TRUE(times.is_pulled(20.25));
  EXPECT_FALSE(times.is_pulled(30));
}

}  // namespace
}  // namespace roseau::synthesis
