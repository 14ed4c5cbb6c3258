// World: what all devices of a rig observe: the air, the tree in it, what hangs on the tree. Immutable from outside, shared by
// the devices' threads; everything is a function of time.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/model/projection.h"
#include "core/result.h"
#include "core/wind_field.h"
#include "structure/tree/tree_model.h"
#include "synthesis/instruments/led_board.h"
#include "synthesis/instruments/surroundings.h"
#include "synthesis/render/visible_scene.h"
#include "synthesis/rig/bar_rig.h"
#include "synthesis/rig/tree_motion.h"
#include "synthesis/scene.h"

namespace roseau::synthesis {

/// A target of the scene: a part of the tree that is watched as a whole. Its motion is the mean of its nodes', weighted with
/// their leaves.
struct PlacedTarget {
  std::string name;
  Vec3 rest_in_world_m;  // its middle
  double width_m = 0;
  double height_m = 0;
  Eigen::Matrix3Xd shape;  // its displacement per unit of each mode's amplitude

  Vec3 displacement_m(const Eigen::VectorXd& amplitudes) const {
    const Eigen::Vector3d moved = shape * amplitudes;
    return {moved.x(), moved.y(), moved.z()};
  }

  // The mode that moves it most in the mean wind, with the damping that the air adds to it: what an identification should find.
  std::size_t mode = 0;
  double natural_frequency_hz = 0;
  double damping_ratio = 0;
  Vec3 axis;  // unit vector along which that mode moves it
};

/// A marker ball; the magnetic tracker's receivers are inside.
struct PlacedBall {
  std::string name;  // "ball1" has station 1
  std::size_t node = 0;
  Vec3 rest_in_world_m;
};

class World final : public Surroundings {
 public:
  /// Error: what check() finds, a tree that cannot be read, modes that do not exist, a scene too large for the memory it may
  /// use.
  static Result<std::shared_ptr<const World>> build(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const structure::TreeModel& tree() const { return tree_; }
  const TreeMotion& tree_motion() const { return *tree_motion_; }
  const std::vector<PlacedTarget>& targets() const { return targets_; }
  const std::vector<PlacedBall>& balls() const { return balls_; }
  const std::optional<BarRigMotion>& bar_rig() const { return bar_rig_; }
  const calib::Projection& camera(std::size_t index) const { return cameras_.at(index); }
  const std::shared_ptr<const render::VisibleScene>& visible() const { return visible_; }

  /// Of a camera's exposure midpoints.
  SampleTimes camera_times(std::size_t index) const;
  /// None when the scene has no board.
  const LedBoard* led_board() const { return led_board_ ? &*led_board_ : nullptr; }

  /// Where /truth/wind is: the middle of what the wind pushes.
  const Vec3& wind_point() const { return wind_point_; }
  const WindField& wind() const { return *wind_; }
  Vec3 wind_mps(const Vec3& point_in_world_m, double time_s) const override {
    return wind_->velocity_mps(point_in_world_m, time_s);
  }
  /// In ball `station`; its axes are the world's while the tree is at rest.
  StationPlace station_place(std::size_t station, double time_s) const override;

  /// The air's velocity at a point in the sonic's axes: what a perfect instrument, well levelled, would show.
  WindSample wind_in_sonic_axes(const Vec3& point_in_world_m, double time_s) const;

  Vec3 ball_in_world_m(std::size_t ball, const Eigen::VectorXd& amplitudes) const;

  /// Everything that pictures show at a time. `amplitudes` is the caller's scratch.
  void fill_moment(double time_s, Eigen::VectorXd& amplitudes, render::SceneMoment& moment) const;

  /// In a camera's picture, of a target from its place at rest, pixels (x right, y down).
  Vec2 target_displacement_px(const PlacedTarget& target, std::size_t camera, const Vec3& displacement_m) const;
  /// Where the target is in that picture (ImageRect's pixels).
  ImageRect target_region(const PlacedTarget& target, std::size_t camera, const Vec3& displacement_m) const;

 private:
  World() = default;
  Result<void> make_tree();
  Result<void> make_motion();
  Result<void> make_visible();
  void place_balls();
  void place_targets(const structure::DragLoad& load, const structure::ModalModel& model);
  Eigen::Matrix3Xd shape_of_region(const TargetScene& target, const Vec3& middle, const structure::ModalModel& model) const;
  double light_level(double time_s) const;

  Scene scene_;
  structure::TreeModel tree_;
  std::vector<PlacedBall> balls_;
  std::vector<PlacedTarget> targets_;
  std::vector<calib::Projection> cameras_;
  std::optional<BarRigMotion> bar_rig_;
  std::optional<LedBoard> led_board_;
  std::shared_ptr<const WindField> wind_;
  std::unique_ptr<const TreeMotion> tree_motion_;
  std::shared_ptr<const render::VisibleScene> visible_;
  Vec3 wind_point_;
};

}  // namespace roseau::synthesis
