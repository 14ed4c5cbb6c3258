#include "synthesis/rig/tree_motion.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "synthesis/rig/world.h"

namespace roseau::synthesis {
namespace {

// A pole in the wind: quick to compute.
Scene pole_scene() {
  Scene scene;
  scene.tree.kind = "cantilever";
  scene.balls.enabled = false;
  scene.mechanics.mode_count = 4;
  scene.cameras.resize(1);
  return scene;
}

std::shared_ptr<const World> world_of(const Scene& scene) {
  auto world = World::build(scene);
  EXPECT_TRUE(world) << world.error().message;
  return *world;
}

Eigen::VectorXd amplitudes(const World& world, double time_s) {
  Eigen::VectorXd q;
  world.tree_motion().amplitudes(time_s, q);
  return q;
}

TEST(TreeMotion, DoesNotDependOnWhoAskedBefore) {
  const auto forwards = world_of(pole_scene());
  const auto jumping = world_of(pole_scene());
  std::vector<Eigen::VectorXd> expected;
  for (double time_s = 0; time_s < 100; time_s += 0.37) expected.push_back(amplitudes(*forwards, time_s));
  // Far ahead, back beyond everything that is kept, and on again.
  for (const double time_s : {99.16, 0.0, 61.05, 0.37, 98.79}) {
    const auto index = static_cast<std::size_t>(std::lround(time_s / 0.37));
    EXPECT_EQ(amplitudes(*jumping, static_cast<double>(index) * 0.37),
              amplitudes(*forwards, static_cast<double>(index) * 0.37));
    EXPECT_LT((amplitudes(*jumping, 0.37 * static_cast<double>(index)) - expected[index]).norm(),
              1e-9 * expected[index].norm());
  }
}

TEST(TreeMotion, ThreadsSeeTheSameMotion) {
  const auto alone = world_of(pole_scene());
  const auto shared = world_of(pole_scene());
  constexpr int kThreads = 4;
  constexpr int kTimes = 400;
  std::vector<std::vector<double>> seen(kThreads);
  {
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < kThreads; ++thread) {
      threads.emplace_back([&, thread] {
        for (int i = 0; i < kTimes; ++i) seen[static_cast<std::size_t>(thread)].push_back(amplitudes(*shared, 0.1 * i)[0]);
      });
    }
  }
  for (int i = 0; i < kTimes; ++i) {
    const double expected = amplitudes(*alone, 0.1 * i)[0];
    for (const auto& values : seen) ASSERT_EQ(values[static_cast<std::size_t>(i)], expected);
  }
}

TEST(TreeMotion, BetweenStepsItIsTheMotionOfFinerSteps) {
  Scene coarse = pole_scene();
  Scene fine = pole_scene();
  coarse.drag.relative_velocity = fine.drag.relative_velocity = false;
  coarse.wind.turbulence.turbulence_intensity = fine.wind.turbulence.turbulence_intensity = 0;
  coarse.pulls =
      fine.pulls = {{.near_in_world_m = {0, 0, 2}, .force_n = {3, 0, 0}, .start_s = 0.5, .full_s = 1.5, .release_s = 2}};
  coarse.mechanics.step_rate_hz = 120;
  fine.mechanics.step_rate_hz = 960;
  const auto a = world_of(coarse);
  const auto b = world_of(fine);
  double worst = 0;
  double largest = 0;
  for (double time_s = 0; time_s < 6; time_s += 0.0371) {
    worst = std::max(worst, std::abs(amplitudes(*a, time_s)[0] - amplitudes(*b, time_s)[0]));
    largest = std::max(largest, std::abs(amplitudes(*b, time_s)[0]));
  }
  EXPECT_GT(largest, 0);
  EXPECT_LT(worst, 1e-3 * largest);
}

TEST(TreeMotion, ARopeLetGoRingsAtTheNaturalFrequency) {
  Scene scene = pole_scene();
  scene.wind.turbulence.mean_speed_mps = 0;
  scene.pulls = {{.near_in_world_m = {0, 0, 2}, .force_n = {3, 0, 0}, .start_s = 0.5, .full_s = 1.5, .release_s = 2}};
  const auto world = world_of(scene);
  const PlacedTarget& target = world->targets().front();
  EXPECT_NEAR(target.displacement_m(amplitudes(*world, 0.4)).x, 0, 1e-12);
  EXPECT_GT(target.displacement_m(amplitudes(*world, 2)).x, 1e-3);
  // Upward crossings of zero in free decay.
  std::vector<double> crossings;
  double before = 0;
  for (double time_s = 2; time_s < 8; time_s += 0.001) {
    const double now = target.displacement_m(amplitudes(*world, time_s)).x;
    if (before < 0 && now >= 0) crossings.push_back(time_s - 0.001 * now / (now - before));
    before = now;
  }
  ASSERT_GT(crossings.size(), 4U);
  const double frequency_hz = static_cast<double>(crossings.size() - 1) / (crossings.back() - crossings.front());
  EXPECT_NEAR(frequency_hz, target.natural_frequency_hz, 0.002 * target.natural_frequency_hz);
}

}  // namespace
}  // namespace roseau::synthesis
