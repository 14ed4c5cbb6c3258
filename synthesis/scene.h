// Scene: everything a simulated session is made from, besides nothing. The same scene (with its seed) gives the same bytes.
//
// World frame: metres, x east, y north, z up, origin on the ground at the foot of the tree. The cameras stand south of the
// tree and look north, so that east is to the right in their pictures. The branch swings east-west; the wind that matters
// most is the one from the west or the east.
//
// In a file: config/scenes/demo.toml lists every key.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame.h"
#include "core/geometry.h"
#include "core/result.h"
#include "core/sample.h"
#include "synthesis/instruments/device_timing.h"
#include "synthesis/instruments/sonic.h"
#include "synthesis/wind/turbulent_wind.h"

namespace roseau::synthesis {

struct BranchScene {
  double natural_frequency_hz = 1.2;  // undamped
  double damping_ratio = 0.05;        // 0 < ratio < 1
  double drag_exponent = 2;           // 2 = rigid; 2 + Vogel exponent for streamlining foliage
  double mean_deflection_m = 0.0625;  // static deflection of its top under the mean wind
  Vec3 root_in_world_m{-0.08, 0, 1.45};
  double length_m = 1.7;  // height of the top above the root
};

struct CameraScene {
  std::uint32_t width_px = 640;
  std::uint32_t height_px = 480;
  PixelFormat format = PixelFormat::bgr8;
  double focal_length_px = 800;
  Vec3 position_in_world_m{-0.3, -5, 1.6};
  Vec3 look_at_in_world_m{0.15, 0, 2.05};
  double rate_hz = 30;
  double exposure_duration_s = 0.004;
  int exposure_taps = 1;          // pictures averaged over the exposure: 1 freezes the motion, 4 and more blur it
  double read_noise_counts = 1;   // standard deviation, of 255
  double shot_noise_gain = 0.02;  // variance per count of signal, counts
  DeviceTiming timing{.latency_s = 0.012, .jitter_s = 0.001};
};

using SonicScene = SonicOptions;

struct TruthScene {
  bool enabled = true;
  double wind_rate_hz = 20;
};

struct Scene {
  std::uint64_t seed = 1;
  TurbulentWindOptions wind;
  BranchScene branch;
  std::vector<CameraScene> cameras = two_cameras();
  SonicScene sonic;
  TruthScene truth;

  /// The demo's pair, 0.6 m apart.
  static std::vector<CameraScene> two_cameras();
};

/// The demo's scene with two 1280x1024 mono8 cameras: what the `pipeline` benchmark runs on.
Scene large_camera_scene();

/// What makes no sense, in words that name the key; nothing when all is well.
Result<void> check(const Scene& scene);

/// Strict: unknown keys are errors with their line. Absent keys keep the demo's value; `source_name` is for messages.
Result<Scene> scene_from_toml(std::string_view text, const std::string& source_name);

/// The camera's calibration as it would come out of a perfect calibration.
CameraCalibration calibration_of(const CameraScene& camera);

/// The middle of the branch's leafy top, the target, at rest.
Vec3 target_centre_in_world(const Scene& scene);

/// Where the target is in this camera's picture (ImageRect's pixels) at a deflection.
ImageRect target_region(const Scene& scene, const CameraScene& camera, double deflection_m);

/// Motion of the target in this camera's picture, relative to rest.
Vec2 target_displacement_px(const Scene& scene, const CameraScene& camera, double deflection_m);

}  // namespace roseau::synthesis
