// Clock models: from pairs (device time, arrival at the host) to a mapping from device time to host time.
//
// Pure objects: no clock is read, the same pairs give the same mapping. Sign convention: host = device + offset; a positive
// frequency offset means that the device's clock runs fast.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/time.h"

namespace roseau::sync {

class ClockModel {
 public:
  virtual ~ClockModel() = default;
  /// One pair. `device` may be absent for devices without a counter: then only the arrival is used.
  virtual void observe(std::optional<DeviceTime> device, HostTime arrival) = 0;
  /// When, on the host's axis, the device's counter showed `device`. Before the first pair: the same number of nanoseconds.
  virtual HostTime to_host(DeviceTime device) const = 0;
  /// As of the last pair. `device` (the name) is left for the caller to fill in.
  virtual ClockState state() const = 0;
};

/// For devices stamped by the host on arrival: nothing to map. Its state tells the arrival jitter: the spread of the
/// intervals between arrivals about their mean, per arrival (interval spread / sqrt 2).
class HostStampedClock : public ClockModel {
 public:
  void observe(std::optional<DeviceTime> device, HostTime arrival) override;
  HostTime to_host(DeviceTime device) const override;
  ClockState state() const override;

 private:
  std::uint64_t count_ = 0;
  HostTime last_arrival_;
  double mean_interval_s_ = 0;
  double interval_variance_s2_ = 0;
};

/// Lower convex hull of (device time, arrival - device time) over the last `memory`: latency only ever adds, so the fastest
/// arrivals carry the clock (reference: the convex-hull filters of Zhang, Liu and Xia 2002 and the ETHZ cuckoo translator).
/// The hull edge below the middle of the window gives offset and frequency offset. The constant part of the latency cannot
/// be seen from arrivals and stays in the offset. A jump of the device's counter (reset, reboot) starts the hull anew.
class LowerHullClock : public ClockModel {
 public:
  struct Options {
    Duration memory = std::chrono::seconds(60);
    /// A pair this far from the mapping (earlier or later) cannot be jitter: after `outliers_for_reset` of them in a row
    /// the counter is taken to have jumped.
    Duration step_threshold = std::chrono::seconds(1);
    int outliers_for_reset = 3;
  };
  LowerHullClock() : LowerHullClock(Options{}) {}
  explicit LowerHullClock(Options options) : options_(options) {}

  void observe(std::optional<DeviceTime> device, HostTime arrival) override;
  HostTime to_host(DeviceTime device) const override;
  ClockState state() const override;

 private:
  struct Point {
    std::int64_t device_ns;
    std::int64_t delay_ns;  // arrival - device: offset plus latency
  };
  void restart();
  bool is_step(const Point& point) const;
  void fit();
  double predicted_delay_ns(std::int64_t device_ns) const;

  Options options_;
  std::deque<Point> points_;  // the last `memory` of pairs, by device time
  std::vector<Point> hull_;   // scratch of fit()
  std::int64_t last_fit_device_ns_ = 0;
  std::int64_t anchor_device_ns_ = 0;  // the mapping is a line through (anchor, delay) with this slope
  double delay_at_anchor_ns_ = 0;
  double slope_ = 0;  // d delay / d device: -frequency offset
  bool fitted_ = false;
  int outliers_in_a_row_ = 0;
  std::uint64_t count_ = 0;
  std::uint32_t resets_ = 0;
};

}  // namespace roseau::sync
