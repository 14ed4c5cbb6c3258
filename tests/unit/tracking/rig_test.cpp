// The simulated rig's branch before its landscape, against the rig's truth.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "synthesis/camera/frame_renderer.h"
#include "synthesis/rig/world.h"
#include "tests/unit/tracking/run.h"

namespace roseau::tracking {
namespace {

TEST(SimulatedRig, TheBranchIsWhereTheTruthSays) {
  const synthesis::Scene scene;
  for (const std::size_t index : {std::size_t{0}, std::size_t{1}}) {
    const synthesis::CameraScene& camera = scene.cameras[index];
    synthesis::FrameRenderer renderer(scene, index);
    synthesis::BranchMotion branch = synthesis::World(scene).branch_motion();
    FramePool pool(1, renderer.frame_bytes());
    TrackerOptions options;
    options.targets = {{"branch", synthesis::target_region(scene, camera, branch.deflection_m(0))}};
    testing::TrackerRun run(options);
    Vec2 start;
    double square = 0;
    double most = 0;
    constexpr int kFrames = 45;
    for (int i = 0; i <= kFrames; ++i) {
      const std::array deflection_m{branch.deflection_m(i / camera.rate_hz)};
      Frame frame;
      frame.pixels = pool.acquire();
      frame.width = camera.width_px;
      frame.height = camera.height_px;
      frame.stride = static_cast<std::uint32_t>(renderer.row_bytes());
      frame.format = camera.format;
      renderer.render(deflection_m, static_cast<std::uint64_t>(i), frame.pixels.writable_bytes());
      run.tracker.process(testing::sample_of(std::move(frame), run.image, i), run.collected);
      const Vec2 truth = synthesis::target_displacement_px(scene, camera, deflection_m[0]);
      if (i == 0) start = truth;
      const Displacement measured = run.displacements("branch").back();
      EXPECT_TRUE(measured.valid) << "camera " << index << " frame " << i;
      const double error_x = measured.x - (truth.x - start.x);
      const double error_y = measured.y - (truth.y - start.y);
      square += (error_x * error_x + error_y * error_y) / (2 * kFrames);
      most = std::max(most, std::abs(truth.x - start.x));
    }
    EXPECT_LT(std::sqrt(square), 0.015) << "camera " << index;
    EXPECT_GT(most, 2.0) << "it did move";
  }
}

}  // namespace
}  // namespace roseau::tracking
