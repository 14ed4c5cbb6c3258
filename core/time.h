// Typed time. No clock is read here: times come from drivers and travel with samples.
//
// HostTime    nanoseconds of CLOCK_MONOTONIC on the acquisition host: the common axis of a session.
// DeviceTime  nanoseconds of one device's own counter, unwrapped; only comparable within that device.
// The two cannot be mixed by accident; a clock model (sync/clock_model.h) maps one to the other.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace roseau {

using Duration = std::chrono::nanoseconds;

struct HostClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
  using time_point = std::chrono::time_point<HostClock, Duration>;
};

struct DeviceClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
  using time_point = std::chrono::time_point<DeviceClock, Duration>;
};

using HostTime = HostClock::time_point;
using DeviceTime = DeviceClock::time_point;

constexpr HostTime host_time_from_ns(std::int64_t time_ns) { return HostTime{Duration{time_ns}}; }
constexpr DeviceTime device_time_from_ns(std::int64_t time_ns) { return DeviceTime{Duration{time_ns}}; }

template <class Clock>
constexpr std::int64_t to_ns(std::chrono::time_point<Clock, Duration> time) {
  return time.time_since_epoch().count();
}

constexpr double to_seconds(Duration duration) { return static_cast<double>(duration.count()) * 1e-9; }

/// Rounds to the nearest nanosecond, so that 1/30 s and the like do not always fall short.
inline Duration from_seconds(double seconds) { return Duration{std::llround(seconds * 1e9)}; }

}  // namespace roseau
