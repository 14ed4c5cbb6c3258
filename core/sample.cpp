#include "core/sample.h"

#include <algorithm>

namespace roseau {

namespace {
constexpr std::array<std::string_view, kSampleKindCount> kKindNames = {"raw_bytes",
                                                                       "frame",
                                                                       "camera_calibration",
                                                                       "operator_action",
                                                                       "skip",
                                                                       "wind",
                                                                       "displacement",
                                                                       "image_motion",
                                                                       "identification",
                                                                       "wind_estimate",
                                                                       "wind_calibration",
                                                                       "force_spectrum",
                                                                       "clock_state",
                                                                       "gap",
                                                                       "drop",
                                                                       "health",
                                                                       "log",
                                                                       "station_pose",
                                                                       "led_board_time",
                                                                       "marker_positions",
                                                                       "modal_state"};
constexpr std::array<std::string_view, 4> kUnitNames = {"px", "m", "strain", "other"};
constexpr std::array<std::string_view, 6> kStateNames = {"starting", "running", "degraded", "reopening", "failed", "finished"};
}  // namespace

std::string_view to_string(SampleKind kind) { return kKindNames.at(static_cast<std::size_t>(kind)); }

std::optional<SampleKind> sample_kind_from_string(std::string_view name) {
  const auto* found = std::ranges::find(kKindNames, name);
  if (found == kKindNames.end()) return std::nullopt;
  return static_cast<SampleKind>(found - kKindNames.begin());
}

std::string_view to_string(LengthUnit unit) { return kUnitNames.at(static_cast<std::size_t>(unit)); }

std::string_view to_string(DeviceState state) { return kStateNames.at(static_cast<std::size_t>(state)); }

std::string_view to_string(RecordingPhase phase) {
  static constexpr std::array<std::string_view, 3> kNames = {"idle", "recording", "post_trigger"};
  return kNames.at(static_cast<std::size_t>(phase));
}

}  // namespace roseau
