// A pole with a board of leaves before the simulated rig's landscape, against the rig's truth.
#include <gtest/gtest.h>

#include <cmath>

#include "synthesis/rig/camera_view.h"
#include "tests/unit/tracking/run.h"

namespace roseau::tracking {
namespace {

TEST(SimulatedRig, TheBranchIsWhereTheTruthSays) {
  synthesis::Scene scene;
  scene.tracker.enabled = false;
  scene.tree.kind = "cantilever";
  scene.tree.cantilever = {.length_m = 4,
                           .start_radius_m = 0.025,
                           .end_radius_m = 0.025,
                           .board_leaves = 8,
                           .board_length_m = 0.8,
                           .board_width_m = 0.8};
  scene.targets = {{.name = "branch", .near_in_world_m = {0, 0, 4}, .width_m = 0.8, .height_m = 0.8}};
  scene.balls.enabled = false;
  scene.drag.leaf_coefficient = 0.09;
  scene.mechanics.young_modulus_gpa = 7;
  scene.mechanics.damping_alpha_per_s = 0.2;
  const auto world = synthesis::World::build(scene);
  ASSERT_TRUE(world) << world.error().message;
  const synthesis::PlacedTarget& target = (*world)->targets().front();
  for (const std::size_t index : {std::size_t{0}, std::size_t{1}}) {
    synthesis::CameraView view(*world, index);
    FramePool pool(1, view.frame_bytes());
    const auto truth_at = [&](double time_s) {
      Eigen::VectorXd amplitudes;
      (*world)->tree_motion().amplitudes(time_s, amplitudes);
      return (*world)->target_displacement_px(target, index, target.displacement_m(amplitudes));
    };
    TrackerOptions options;
    options.targets = {{"branch", (*world)->target_region(target, index, {})}};
    testing::TrackerRun run(options);
    const Vec2 start = truth_at(0);
    double square = 0;
    double most = 0;
    constexpr int kFrames = 45;
    for (int i = 0; i <= kFrames; ++i) {
      const double time_s = i / view.camera().rate_hz;
      run.tracker.process(testing::sample_of(view.take(static_cast<std::uint64_t>(i), time_s, pool), run.image, i),
                          run.collected);
      const Vec2 truth = truth_at(time_s);
      const Displacement measured = run.displacements("branch").back();
      EXPECT_TRUE(measured.valid) << "camera " << index << " frame " << i;
      const double error_x = measured.x - (truth.x - start.x);
      const double error_y = measured.y - (truth.y - start.y);
      square += (error_x * error_x + error_y * error_y) / (2 * kFrames);
      most = std::max(most, std::abs(truth.x - start.x));
    }
    EXPECT_LT(std::sqrt(square), 0.03) << "camera " << index;
    EXPECT_GT(most, 1) << "it did move";
  }
}

}  // namespace
}  // namespace roseau::tracking
