#include "estimation/wind_fusion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roseau::estimation {

namespace {

constexpr std::int64_t kSilent_ns = 1'000'000'000;
constexpr double kSameDirectionCosine = 0.94;  // 20 degrees
constexpr double kSmallestSd_mps = 1e-3;

bool agree(double a_deg, double b_deg) { return std::cos((a_deg - b_deg) * std::numbers::pi / 180) >= kSameDirectionCosine; }

}  // namespace

std::int64_t WindFusion::newest_ns() const {
  std::int64_t newest = 0;
  for (const auto& [target, queue] : queues_) newest = std::max(newest, queue.newest_ns);
  return newest;
}

bool WindFusion::is_active(const Queue& queue) const { return queue.newest_ns + kSilent_ns >= newest_ns(); }

WindFusion::Fused WindFusion::fuse(const Queue& leader, const Entry& entry) const {
  const auto reach_ns = from_seconds(0.5 * leader.period_s + 1e-3).count();
  Fused fused{host_time_from_ns(entry.time_ns), {}};
  fused.wind.wind_mps = 0;
  fused.wind.wind_sd_mps = 0;
  fused.wind.accepted = true;
  fused.wind.scale_known = true;
  double weights = 0;
  for (const auto& [target, queue] : queues_) {
    const auto nearest = std::ranges::min_element(queue.entries, {},
                                                  [&](const Entry& other) { return std::abs(other.time_ns - entry.time_ns); });
    if (nearest == queue.entries.end() || std::abs(nearest->time_ns - entry.time_ns) > reach_ns) continue;
    if (!agree(nearest->direction_deg, entry.direction_deg)) continue;
    const double weight = 1 / std::pow(std::max(nearest->sd_mps, kSmallestSd_mps), 2);
    weights += weight;
    fused.wind.wind_mps += weight * nearest->wind_mps;
    // The calibrations share one reference, so their errors go together: the mean spread, not the smaller one of a mean.
    fused.wind.wind_sd_mps += weight * nearest->sd_mps;
    fused.wind.lag_s = std::max(fused.wind.lag_s, nearest->lag_s);
    fused.wind.settling = fused.wind.settling && nearest->settling;
  }
  fused.wind.wind_mps /= weights;
  fused.wind.wind_sd_mps /= weights;
  return fused;
}

std::vector<WindFusion::Fused> WindFusion::add(const std::string& target, HostTime sample_time, const WindEstimate& wind,
                                               double direction_deg, double period_s) {
  if (!wind.accepted || !wind.scale_known || !std::isfinite(wind.wind_mps)) return {};
  Queue& mine = queues_[target];
  mine.target = target;
  mine.period_s = period_s;
  mine.newest_ns = to_ns(sample_time);
  mine.entries.push_back({mine.newest_ns, wind.wind_mps, wind.wind_sd_mps, wind.lag_s, direction_deg, wind.settling});

  const Queue* leader = nullptr;
  std::int64_t complete_ns = newest_ns();
  for (const auto& [name, queue] : queues_) {
    if (!is_active(queue)) continue;
    if (leader == nullptr) leader = &queue;
    complete_ns = std::min(complete_ns, queue.newest_ns);
  }
  std::vector<Fused> result;
  for (const Entry& entry : leader->entries) {
    if (entry.time_ns <= complete_ns) result.push_back(fuse(*leader, entry));
  }
  if (!result.empty()) {
    // What lies before the last time given out can no longer be nearest to anything.
    const std::int64_t done_ns = to_ns(result.back().sample_time);
    for (auto& [name, queue] : queues_) {
      std::erase_if(queue.entries,
                    [&](const Entry& entry) { return &queue == leader ? entry.time_ns <= done_ns : entry.time_ns < done_ns; });
    }
  }
  return result;
}

}  // namespace roseau::estimation
