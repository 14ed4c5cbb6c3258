// NearestTruth: errors of the sample times that a device's samples were given, each against the nearest true time.
#pragma once

#include <deque>
#include <vector>

#include "core/time.h"

namespace roseau::daemon {

/// Both kinds arrive in order of time; either may come first. With `reach` half the interval between truths, the nearest one
/// is the right one as long as errors stay below `reach`. A sample that is further from any truth is not counted.
class NearestTruth {
 public:
  explicit NearestTruth(Duration reach) : reach_(reach) {}

  void truth(HostTime time) {
    truths_.push_back(time);
    while (!waiting_.empty() && waiting_.front() + reach_ <= time) {
      match(waiting_.front());
      waiting_.pop_front();
    }
    // Without samples to compare with, only the last of them can ever matter.
    while (waiting_.empty() && truths_.size() > kKeep) truths_.pop_front();
  }

  void sample(HostTime time) {
    if (!truths_.empty() && time + reach_ <= truths_.back()) {
      match(time);
    } else {
      waiting_.push_back(time);
      if (waiting_.size() > kKeep) waiting_.pop_front();  // truth that does not come
    }
  }

  const std::vector<double>& errors_s() const { return errors_s_; }

 private:
  static constexpr std::size_t kKeep = 1000;

  void match(HostTime time) {
    while (truths_.size() > 1 && std::chrono::abs(truths_[1] - time) <= std::chrono::abs(truths_[0] - time))
      truths_.pop_front();
    if (const Duration error = time - truths_.front(); std::chrono::abs(error) <= reach_)
      errors_s_.push_back(to_seconds(error));
  }

  Duration reach_;
  std::deque<HostTime> truths_;
  std::deque<HostTime> waiting_;
  std::vector<double> errors_s_;
};

}  // namespace roseau::daemon
