// RecordedWind: what a sonic has recorded, blowing again. What it measured at its place drifts with the recording's mean wind
// unchanged (frozen flow), is the same at all places across the wind, and gets a mean profile in height.
//
// Between samples: Catmull-Rom's cubic, so that the recording's own values come back at their own times. At the end: either
// the recording starts again (its last 2 seconds fade into its first), or it is refused when it is shorter than what is
// wanted. Holes of up to 2 s are bridged by straight lines; longer ones are refused.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "core/wind_field.h"
#include "core/wind_geometry.h"
#include "synthesis/wind/mean_wind.h"
#include "synthesis/wind/wind_region.h"

namespace roseau::synthesis {

enum class RecordingEnd : std::uint8_t { refuse, loop };

constexpr std::string_view to_string(RecordingEnd end) { return end == RecordingEnd::loop ? "loop" : "refuse"; }

struct RecordedWindOptions {
  std::vector<Vec3> samples_mps;  // in the world's axes, towards; NaN where there is none
  double rate_hz = 20;
  Vec3 place_in_world_m{0, 0, 2.6};  // where it is taken to have been recorded
  double start_s = 0;                // the recording's time at time 0
  RecordingEnd at_end = RecordingEnd::refuse;
  ProfileShape profile = ProfileShape::power;  // with the height of place_in_world_m as reference
  double profile_exponent = 0;
  double roughness_length_m = 0.03;
  double displacement_height_m = 0;
};

/// A record of an anemometer in the world's axes; NaN where it is not valid.
Vec3 velocity_in_world_mps(const WindSample& sample, double north_offset_deg, WindAxes axes = WindAxes::gill_spar);

/// Mean of all samples that are numbers; zero when there are none.
Vec3 mean_mps(const std::vector<Vec3>& samples_mps);

class RecordedWind final : public WindField {
 public:
  /// Error: no samples, a hole too long, a mean wind under 0.1 m/s (nothing would carry it), or, with RecordingEnd::refuse,
  /// too short for the region and its duration, with the time that it takes the air to cross the region.
  static Result<std::shared_ptr<const RecordedWind>> make(const RecordedWindOptions& options, const WindRegion& region);

  /// Outside a recording that does not loop: its first or last value.
  Vec3 velocity_mps(const Vec3& point_in_world, double time_s) const override;

  Vec3 mean_mps() const { return mean_mps_; }

 private:
  RecordedWind(const RecordedWindOptions& options, std::vector<Vec3> samples);
  Result<void> check_length(const WindRegion& region) const;
  double recording_time_s(const Vec3& point, double time_s) const;
  Vec3 sample(std::int64_t index) const;

  std::vector<Vec3> samples_;
  double rate_hz_;
  Vec3 place_;
  double start_s_;
  bool loops_;
  Vec3 mean_mps_;
  Vec3 along_;           // unit vector, horizontal
  double speed_mps_;     // that carries it
  MeanProfile profile_;  // relative to the place's height
};

}  // namespace roseau::synthesis
