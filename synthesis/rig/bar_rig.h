// The calibration rig of the plant thesis (2.3.2): a bar of five metres, a bar of one metre across it, six targets, waved
// through the volume by two people. It bends under its own weight, and its targets are not quite where the operator's tape
// says.
//
// Rig frame: origin at the junction, x along the long bar (from -1 m to 4 m), y along the cross bar (from -0.4 m to 0.6 m), z
// the side that the tags face.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/geometry.h"
#include "synthesis/render/scene_moment.h"

namespace roseau::synthesis {

struct BarRigScene;

class BarRigMotion {
 public:
  static constexpr std::size_t kTargets = 6;
  static constexpr double kLongBarBegin_m = -1;
  static constexpr double kLongBarEnd_m = 4;
  static constexpr double kCrossBarBegin_m = -0.4;
  static constexpr double kCrossBarEnd_m = 0.6;
  static constexpr std::array<std::string_view, kTargets> kNames{"left", "junction", "middle", "right", "low", "high"};

  BarRigMotion(const BarRigScene& scene, std::uint64_t seed);

  struct Pose {
    Vec3 junction_in_world_m;
    Quaternion world_from_rig;
  };
  /// Of the unbent rig. Smooth; a function of time alone.
  Pose pose(double time_s) const;

  /// Where a point of the rig is, bent by its weight.
  Vec3 point_in_world_m(const Vec3& point_in_rig_m, double time_s) const;
  std::array<Vec3, kTargets> targets_in_world_m(double time_s) const;

  /// For pictures.
  void fill(double time_s, render::RigMoment& moment) const;

  /// Where the operator believes them to be.
  static std::array<Vec3, kTargets> surveyed_in_rig_m();
  /// Where they are on the unbent rig.
  const std::array<Vec3, kTargets>& true_in_rig_m() const { return true_in_rig_m_; }

 private:
  // One coordinate of the path: two slow oscillations that do not repeat together.
  struct Wave {
    double middle = 0;
    double reach = 0;
    double rate_rad_s = 0;
    double phase_rad = 0;
    double at(double time_s) const;
  };

  std::array<Wave, 3> middle_;  // of the long bar, in the world
  Wave yaw_, pitch_, roll_;
  double yaw_rate_rad_s_ = 0;
  double sag_m_ = 0;
  std::array<Vec3, kTargets> true_in_rig_m_;
};

}  // namespace roseau::synthesis
