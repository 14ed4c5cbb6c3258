#include "sync/clock_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace roseau::sync {
namespace {

using std::chrono::milliseconds;

/// Exponential latency made from raw bits: the standard distributions differ between libraries.
double exponential(std::mt19937_64& bits, double mean) {
  const double uniform = (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53;
  return -mean * std::log(uniform);
}

struct SimulatedDevice {
  double offset_s = 1000;  // host = device + offset at device time 0
  double fast_ppm = 40;
  double least_latency_s = 0.003;
  double mean_jitter_s = 0.002;

  DeviceTime device_at(double host_s) const {
    return device_time_from_ns(std::llround((host_s - offset_s) * (1 + fast_ppm * 1e-6) * 1e9));
  }
};

struct RunResult {
  double worst_error_s = 0;
  ClockState state;
};

RunResult run(const SimulatedDevice& device, int seconds, std::uint64_t seed, LowerHullClock& clock) {
  std::mt19937_64 bits(seed);
  RunResult result;
  for (int i = 0; i < seconds * 30; ++i) {
    const double host_s = device.offset_s + i / 30.0;
    const DeviceTime stamp = device.device_at(host_s);
    const double latency_s = device.least_latency_s + exponential(bits, device.mean_jitter_s);
    clock.observe(stamp, HostTime{from_seconds(host_s + latency_s)});
    if (i < 30 * 20) continue;
    // The constant part of the latency cannot be known from one-way arrivals: it belongs to the mapping.
    const double error_s = to_seconds(clock.to_host(stamp) - HostTime{from_seconds(host_s + device.least_latency_s)});
    result.worst_error_s = std::max(result.worst_error_s, std::abs(error_s));
  }
  result.state = clock.state();
  return result;
}

TEST(LowerHullClock, FindsOffsetAndFrequencyUnderJitter) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    LowerHullClock clock;
    const auto result = run({}, 120, seed, clock);
    EXPECT_LT(result.worst_error_s, 0.0006) << "seed " << seed;
    EXPECT_NEAR(result.state.frequency_offset_ppm, 40, 15) << "seed " << seed;
    EXPECT_NEAR(result.state.jitter_s, 0.002, 0.0004);
  }
}

TEST(LowerHullClock, MeanOfArrivalsWouldBeWorse) {
  // What the hull is for: the bias of an average is the mean jitter itself.
  LowerHullClock clock;
  EXPECT_LT(run({.mean_jitter_s = 0.010}, 120, 5, clock).worst_error_s, 0.003);
}

TEST(LowerHullClock, CounterResetStartsAnewAndIsCounted) {
  LowerHullClock clock;
  run({}, 30, 1, clock);
  run({.offset_s = 2000}, 30, 2, clock);
  EXPECT_EQ(clock.state().resets, 1U);
  const auto mapped = clock.to_host(device_time_from_ns(0));
  EXPECT_NEAR(to_seconds(mapped.time_since_epoch()), 2000.003, 0.01);
}

TEST(LowerHullClock, OneWildStampChangesNothing) {
  LowerHullClock clock;
  run({}, 30, 1, clock);
  const auto probe = device_time_from_ns(30'000'000'000);
  const auto before = clock.to_host(probe);
  clock.observe(device_time_from_ns(-5), HostTime{from_seconds(1031)});
  clock.observe(device_time_from_ns(900'000'000'000'000), HostTime{from_seconds(1031.1)});
  EXPECT_EQ(clock.to_host(probe), before);
  EXPECT_EQ(clock.state().resets, 0U);
}

TEST(LowerHullClock, FollowsADriftingOscillator) {
  // 0.1 ppm/s for 5 min: the device wanders by 30 ppm; memory 60 s must follow.
  LowerHullClock clock;
  std::mt19937_64 bits(3);
  double device_s = 0;
  double worst_s = 0;
  for (int i = 0; i < 300 * 30; ++i) {
    const double host_s = i / 30.0;
    device_s += (1 + 1e-7 * host_s) / 30.0;
    const auto stamp = DeviceTime{from_seconds(device_s)};
    clock.observe(stamp, HostTime{from_seconds(host_s + 1 / 30.0 + 0.001 + exponential(bits, 0.0005))});
    if (host_s > 60) {
      worst_s =
          std::max(worst_s, std::abs(to_seconds(clock.to_host(stamp) - HostTime{from_seconds(host_s + 1 / 30.0 + 0.001)})));
    }
  }
  EXPECT_LT(worst_s, 0.0008);
}

TEST(HostStampedClock, ReportsArrivalJitter) {
  HostStampedClock clock;
  std::mt19937_64 bits(7);
  for (int i = 0; i < 5000; ++i) {
    const double uniform = static_cast<double>(bits() >> 11) * 0x1p-53 - 0.5;
    clock.observe(std::nullopt, HostTime{from_seconds(i * 0.05 + uniform * 0.002)});
  }
  EXPECT_NEAR(clock.state().jitter_s, 0.002 / std::sqrt(12.0), 0.0001);
  EXPECT_EQ(clock.state().samples, 5000U);
}

}  // namespace
}  // namespace roseau::sync
