// One wind from all targets: at each sample time of the first target (by name) the mean of every target's accepted and
// calibrated estimate near that time, weighted by inverse variance. Targets differ in lag and in their cameras' phase, so an
// estimate waits until the others have come as far; one that has been silent for a second is not waited for.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/time.h"

namespace roseau::estimation {

class WindFusion {
 public:
  struct Fused {
    HostTime sample_time;
    WindEstimate wind;  // force per mass is not measured: the targets' units differ
  };

  /// `direction_deg`: what the target's calibration is about. Only targets whose directions agree with the first one's within
  /// 20 degrees are joined. `period_s`: the target's sample period. Estimates that are not accepted or have no scale are
  /// ignored. Returns what has become complete, in order of time.
  std::vector<Fused> add(const std::string& target, HostTime sample_time, const WindEstimate& wind, double direction_deg,
                         double period_s);

  /// The target is no more.
  void remove(const std::string& target) { queues_.erase(target); }

  template <class Archive>
  void archive(Archive& a);

 private:
  struct Entry {
    std::int64_t time_ns = 0;
    double wind_mps = 0;
    double sd_mps = 0;
    double lag_s = 0;
    double direction_deg = 0;
    bool settling = true;

    template <class Archive>
    void archive(Archive& a) {
      a(time_ns), a(wind_mps), a(sd_mps), a(lag_s), a(direction_deg), a(settling);
    }
  };
  struct Queue {
    std::string target;
    double period_s = 0;
    std::int64_t newest_ns = 0;
    std::vector<Entry> entries;  // not yet given out, oldest first

    template <class Archive>
    void archive(Archive& a) {
      a(target), a(period_s), a(newest_ns), a(entries);
    }
  };

  std::int64_t newest_ns() const;
  bool is_active(const Queue& queue) const;
  Fused fuse(const Queue& leader, const Entry& entry) const;

  std::map<std::string, Queue> queues_;
};

template <class Archive>
void WindFusion::archive(Archive& a) {
  std::vector<Queue> queues;
  for (const auto& [target, queue] : queues_) queues.push_back(queue);
  a(queues);
  queues_.clear();
  for (Queue& queue : queues) {
    const std::string target = queue.target;
    queues_[target] = std::move(queue);
  }
}

}  // namespace roseau::estimation
