// Scene: everything a simulated session is made from, besides nothing. The same scene (with its seed) gives the same bytes.
//
// World frame: metres, x east, y north, z up, origin on the ground at the foot of the tree. The cameras stand south of the
// tree and look north, so that east is to the right in their pictures.
//
// In a file: config/scenes/demo.toml lists every key.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/model/camera_model.h"
#include "core/frame.h"
#include "core/geometry.h"
#include "core/result.h"
#include "core/sample.h"
#include "structure/tree/cantilever.h"
#include "structure/tree/grown_tree.h"
#include "structure/tree/tree_model.h"
#include "synthesis/instruments/device_timing.h"
#include "synthesis/instruments/led_board.h"
#include "synthesis/instruments/magnetic_tracker.h"
#include "synthesis/instruments/sonic.h"
#include "synthesis/wind/wind_options.h"

namespace roseau::synthesis {

/// A recorded sonic as the wind: of a session's file, in place of turbulence.
struct RecordingScene {
  std::string file;   // .mcap, relative to the scene's file; empty: none
  std::string topic;  // empty: its first wind stream
  Vec3 place_in_world_m{0, 0, 2.6};
  double start_s = 0;
  bool loop = true;
  // Filled in by whoever reads the file.
  std::vector<Vec3> samples_mps;
  double rate_hz = 20;
};

struct WindScene {
  TurbulentWindOptions turbulence;
  RecordingScene recording;
  std::vector<FlowPrimitive> primitives;
  std::vector<GustFront> gusts;
};

struct TreeScene {
  std::string kind = "grown";                 // "grown", "cantilever", or "file": a digitised or laser-scanned tree
  std::string file;                           // .mtg, .mat or .txt; relative to the scene's file
  std::uint32_t node_limit = 1500;            // a bigger tree from a file is simplified
  std::optional<structure::TreeModel> model;  // the file's, filled in by whoever reads it
  structure::GrownTreeOptions grown{.trunk_radius_m = 0.05};
  structure::CantileverOptions cantilever{.board_leaves = 6};
};

/// What the tree is made of and how it is computed (plant thesis 6.2, 6.4.3).
struct MechanicsScene {
  std::uint32_t mode_count = 25;
  double young_modulus_gpa = 4;     // of green wood, with what the roots give way
  double wood_density_kg_m3 = 900;  // green wood
  double leaf_mass_kg_m2 = 0.2;     // per one-sided area
  double mass_factor = 1;
  double damping_alpha_per_s = 0.1;  // C = alpha M + beta K
  double damping_beta_s = 0.002;
  std::string load = "full";       // drag on every element with its relative velocity; or "projection" (6.29, 6.30)
  std::string stepping = "exact";  // or "semi_implicit": the thesis's
  double step_rate_hz = 120;
};

/// Drag of wood and leaves (6.23).
struct DragScene {
  double air_density_kg_m3 = 1.2;
  double wood_coefficient = 1.0;
  double leaf_coefficient = 0.07;     // of one-sided leaf area, all orientations and shelter together
  double leaf_vogel_exponent = -0.2;  // force ~ speed^(2 + exponent): below 0 leaves streamline
  double reference_speed_mps = 5;     // where the leaf coefficient holds
  bool relative_velocity = true;      // of the air and the moving tree: brings the aerodynamic damping
};

/// A part of the tree that is watched: the region around the node nearest to a point.
struct TargetScene {
  std::string name = "branch";
  Vec3 near_in_world_m{0.2, 0, 4.9};
  double width_m = 1.1;
  double height_m = 0.9;
};

/// Coloured balls on branches, with the magnetic tracker's receivers in their middle.
struct BallsScene {
  bool enabled = true;
  double diameter_m = 0.12;
  /// Each is fixed to the node nearest to its point: three numbers per ball.
  std::vector<double> near_in_world_m = four_places();

  static std::vector<double> four_places();
  std::size_t count() const { return enabled ? near_in_world_m.size() / 3 : 0; }
};

/// A rope pulls a branch, holds it and lets go (plant thesis 2.3.3).
struct PullScene {
  Vec3 near_in_world_m{0, 0, 4};
  Vec3 force_n{60, 0, -20};
  double start_s = 5;     // the pull grows evenly
  double full_s = 8;      // to its full force
  double release_s = 10;  // and ends at once
};

struct CameraScene {
  std::uint32_t width_px = 640;
  std::uint32_t height_px = 480;
  PixelFormat format = PixelFormat::bgr8;
  std::string lens = "pinhole";  // pinhole, opencv4, opencv5 or opencv8
  double focal_length_px = 950;
  std::vector<double> distortion;  // as many as the lens has: k1 k2 p1 p2, k3, k4 k5 k6; fewer: the others are 0
  Vec3 position_in_world_m{-1.5, -12, 1.6};
  Vec3 look_at_in_world_m{0, 0, 2.75};
  double rate_hz = 30;
  double exposure_duration_s = 0.004;
  int exposure_taps = 1;      // pictures averaged over the exposure: 1 freezes the motion, 4 and more blur it
  double line_delay_s = 0;    // rolling shutter: each row begins this much after the one above; 0: global shutter
  double lens_blur_px = 0.6;  // standard deviation
  double gain = 1;
  double read_noise_counts = 1;   // standard deviation, of 255
  double shot_noise_gain = 0.02;  // variance per count of signal, counts
  std::string stamps = "host";    // "host": the host knows the exposure midpoint; "device": only the camera's own clock does
  DeviceTiming timing{.latency_s = 0.012, .jitter_s = 0.001};
};

struct TrackerScene {
  bool enabled = true;  // with a station in each ball, four at most
  MagneticTrackerOptions instrument{.source_position_in_world_m = {0, -1.6, 3}, .hemisphere_in_source = {0, 1, 0}};
};

struct LedBoardScene {
  bool enabled = true;
  Vec3 centre_in_world_m{1.9, -1.2, 0.55};
  double pitch_m = 0.05;  // between neighbouring LEDs
  LedBoardOptions instrument;
};

struct BackgroundScene {
  bool visible = true;  // false: a plain grey sheet hangs behind
  double hedge_sway_m = 0.05;
  double cloud_speed_mps = 8;
  double light_change = 0.08;  // how much the light comes and goes, share of its mean
  double light_period_s = 40;
};

/// A bar of five metres with one of one metre across it and six tags on them, waved through the volume.
struct BarRigScene {
  bool enabled = false;
  double speed_mps = 0.5;         // of its middle
  double sag_m = 0.015;           // of the long bar's ends, by its own weight
  double survey_error_m = 0.002;  // standard deviation of what the operator believes about each target
  double tag_size_m = 0.3;        // side of the black square
  Vec3 volume_low_in_world_m{-2.5, -2.5, 0.8};
  Vec3 volume_high_in_world_m{2.5, 2.5, 4.8};
};

struct TruthScene {
  bool enabled = true;
  double wind_rate_hz = 20;
  double marker_rate_hz = 30;  // of balls, rig targets and modes
};

struct Scene {
  std::uint64_t seed = 1;
  WindScene wind;
  TreeScene tree;
  MechanicsScene mechanics;
  DragScene drag;
  std::vector<TargetScene> targets = {{}};
  BallsScene balls;
  std::vector<PullScene> pulls;
  std::vector<CameraScene> cameras = two_cameras();
  SonicOptions sonic{.position_in_world_m = {2.4, 0.1, 3.7}};
  TrackerScene tracker;
  LedBoardScene led_board;
  BackgroundScene background;
  BarRigScene bar_rig;
  TruthScene truth;

  /// The demo's pair, 3 m apart.
  static std::vector<CameraScene> two_cameras();
};

/// The demo's scene with two 1280x1024 mono8 cameras: what the `pipeline` benchmark runs on.
Scene large_camera_scene();

/// What makes no sense, in words that name the key; nothing when all is well.
Result<void> check(const Scene& scene);

/// Strict: unknown keys are errors with their line. Absent keys keep the demo's value; `source_name` is for messages.
Result<Scene> scene_from_toml(std::string_view text, const std::string& source_name);

/// The camera as a perfect calibration would find it.
calib::CameraModel model_of(const CameraScene& camera);

}  // namespace roseau::synthesis
