#include "tracking/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tracking/patch.h"

namespace roseau::tracking {

namespace {

struct Bounds {
  const char* key;
  double value;
  double least;
  double most;
};

Result<void> check_targets(const std::vector<TargetRegion>& targets) {
  std::set<std::string> names;
  for (const TargetRegion& target : targets) {
    if (!is_target_name(target.name)) {
      return Error{ErrorCode::invalid_argument,
                   fmt::format("target name \"{}\": give 1 to 64 letters, digits, '-', '_' or '.'", target.name)};
    }
    if (!names.insert(target.name).second) {
      return Error{ErrorCode::invalid_argument, fmt::format("target \"{}\" is given twice: rename one", target.name)};
    }
    if (!(target.region.width >= Patch::kSide && target.region.height >= Patch::kSide)) {
      return Error{ErrorCode::invalid_argument,
                   fmt::format("target \"{}\" is {} x {} px: at least {} x {} px are needed", target.name, target.region.width,
                               target.region.height, Patch::kSide, Patch::kSide)};
    }
  }
  if (targets.size() > kMostTargets) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("{} targets for one camera: at most {} are possible", targets.size(), kMostTargets)};
  }
  return {};
}

}  // namespace

Result<void> validate(const TrackerOptions& options) {
  const Bounds all[] = {
      {"automatic_frames", static_cast<double>(options.automatic_frames), 10, 10000},
      {"automatic_most_targets", static_cast<double>(options.automatic_most_targets), 1, 32},
      {"automatic_least_motion_px", options.automatic_least_motion_px, 0.02, 100},
      {"feature_count", static_cast<double>(options.feature_count), 10, 20000},
      {"background_share", options.background_share, 0, 0.9},
      {"pyramid_levels", static_cast<double>(options.pyramid_levels), 0, 6},
      {"window_px", static_cast<double>(options.window_px), 5, 63},
      {"flow_iterations", static_cast<double>(options.flow_iterations), 1, 100},
      {"flow_converged_px", options.flow_converged_px, 0.0001, 1},
      {"forward_backward_px", options.forward_backward_px, 0.01, 100},
      {"least_correlation", options.least_correlation, 0.1, 0.99},
      {"search_radius_px", options.search_radius_px, 4, 256},
      {"standard_error_floor_px", options.standard_error_floor_px, 0, 10},
  };
  for (const Bounds& option : all) {
    if (!(option.value >= option.least && option.value <= option.most)) {
      return Error{ErrorCode::invalid_argument,
                   fmt::format("{} = {}: must be from {} to {}", option.key, option.value, option.least, option.most)};
    }
  }
  const int bits = options.mono16_significant_bits;
  if (bits != 0 && (bits < 9 || bits > 16)) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("mono16_significant_bits = {}: must be 0 (from the first frame) or from 9 to 16", bits)};
  }
  return check_targets(options.targets);
}

bool is_target_name(std::string_view name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
  };
  return !name.empty() && name.size() <= 64 && std::ranges::all_of(name, allowed);
}

}  // namespace roseau::tracking
