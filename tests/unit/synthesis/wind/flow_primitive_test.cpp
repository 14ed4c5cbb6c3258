#include "synthesis/wind/flow_primitive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "synthesis/wind/sum_of_winds.h"

namespace roseau::synthesis {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

struct Derivatives {
  double divergence_per_s = 0;
  double rotation_per_s = 0;  // about the vertical
};

Derivatives derivatives(const WindField& wind, const Vec3& at, double time_s = 0) {
  constexpr double kStep = 1e-4;
  const Vec3 east = wind.velocity_mps({at.x + kStep, at.y, at.z}, time_s);
  const Vec3 west = wind.velocity_mps({at.x - kStep, at.y, at.z}, time_s);
  const Vec3 north = wind.velocity_mps({at.x, at.y + kStep, at.z}, time_s);
  const Vec3 south = wind.velocity_mps({at.x, at.y - kStep, at.z}, time_s);
  return {(east.x - west.x + north.y - south.y) / (2 * kStep), (east.y - west.y - north.x + south.x) / (2 * kStep)};
}

FlowPrimitive vortex() {
  return {.kind = FlowKind::vortex, .centre_in_world_m = {1, -2}, .strength_m2ps = 12, .core_radius_m = 0.8};
}
FlowPrimitive source() {
  FlowPrimitive made = vortex();
  made.kind = FlowKind::source;
  return made;
}

TEST(FlowPrimitive, VortexTurnsWithoutDivergenceAndRotatesOnlyInItsCore) {
  const FlowPrimitives wind({vortex()}, {});
  for (const Vec3& far : {Vec3{5.5, -2, 1}, Vec3{1, 4, 9}, Vec3{-3, -6, 2}}) {
    EXPECT_NEAR(derivatives(wind, far).divergence_per_s, 0, 1e-8);
    EXPECT_NEAR(derivatives(wind, far).rotation_per_s, 0, 1e-8);
  }
  const Vec3 in_core{1.3, -1.8, 2};
  EXPECT_NEAR(derivatives(wind, in_core).divergence_per_s, 0, 1e-7);
  // Lamb and Oseen: G / (pi r_c^2) exp(-r^2 / r_c^2)
  const double wanted = 12 / (std::numbers::pi * 0.64) * std::exp(-0.13 / 0.64);
  EXPECT_NEAR(derivatives(wind, in_core).rotation_per_s, wanted, 1e-5);
}

TEST(FlowPrimitive, CirculationAroundAVortexIsItsStrength) {
  const FlowPrimitives wind({vortex()}, {});
  for (const double radius : {4.0, 20.0}) {
    double circulation = 0;
    for (int i = 0; i < 360; ++i) {
      const double angle = kTwoPi * i / 360;
      const Vec3 air = wind.velocity_mps({1 + radius * std::cos(angle), -2 + radius * std::sin(angle), 3}, 7);
      circulation += (-air.x * std::sin(angle) + air.y * std::cos(angle)) * kTwoPi * radius / 360;
    }
    EXPECT_NEAR(circulation, 12, 1e-9);
  }
  // Counter-clockwise seen from above: east of it, the air goes north.
  EXPECT_GT(wind.velocity_mps({3, -2, 0}, 0).y, 0);
}

TEST(FlowPrimitive, SourceBlowsAwayWithoutRotationAndKeepsItsFlow) {
  const FlowPrimitives wind({source()}, {});
  for (const Vec3& at : {Vec3{5.5, -2, 1}, Vec3{1.3, -1.8, 2}}) EXPECT_NEAR(derivatives(wind, at).rotation_per_s, 0, 1e-8);
  EXPECT_NEAR(derivatives(wind, {5.5, -2, 1}).divergence_per_s, 0, 1e-8);
  EXPECT_GT(derivatives(wind, {1, -2, 1}).divergence_per_s, 1);
  EXPECT_NEAR(wind.velocity_mps({11, -2, 5}, 0).x, 12 / (kTwoPi * 10), 1e-9);
  FlowPrimitive sink = source();
  sink.strength_m2ps = -12;
  EXPECT_NEAR(FlowPrimitives({sink}, {}).velocity_mps({11, -2, 5}, 0).x, -12 / (kTwoPi * 10), 1e-9);
}

TEST(FlowPrimitive, IsFiniteInItsCore) {
  for (const FlowPrimitive& primitive : {vortex(), source()}) {
    const FlowPrimitives wind({primitive}, {});
    const Vec3 middle = wind.velocity_mps({1, -2, 0}, 0);
    EXPECT_EQ(std::hypot(middle.x, middle.y), 0);
    double highest = 0;
    double highest_at = 0;
    for (double r = 0; r < 5; r += 0.001) {
      const Vec3 air = wind.velocity_mps({1 + r, -2, 0}, 0);
      if (std::hypot(air.x, air.y) > highest) highest_at = r;
      highest = std::max(highest, std::hypot(air.x, air.y));
    }
    EXPECT_NEAR(highest, 0.638 * 12 / (kTwoPi * 0.8), 2e-3);
    EXPECT_NEAR(highest_at, 1.121 * 0.8, 2e-3);
  }
}

TEST(FlowPrimitive, AddsUpAndDriftsWhenAsked) {
  const FlowPrimitive uniform{.velocity_mps = {3, -1, 0.5}};
  FlowPrimitive carried = vortex();
  carried.drifts_with_wind = true;
  const FlowPrimitives both({uniform, carried}, {3, -1, 0});
  const FlowPrimitives alone({vortex()}, {3, -1, 0});
  const Vec3 sum = both.velocity_mps({2 + 3 * 4, 1 - 4, 2}, 4);
  const Vec3 part = alone.velocity_mps({2, 1, 2}, 4);
  EXPECT_NEAR(sum.x, part.x + 3, 1e-12);
  EXPECT_NEAR(sum.y, part.y - 1, 1e-12);
  EXPECT_NEAR(sum.z, 0.5, 1e-12);
}

TEST(SumOfWinds, AddsFieldsPointByPointAndIsCalmWithoutAny) {
  const auto first = std::make_shared<FlowPrimitives>(std::vector{vortex()}, Vec3{});
  const auto second = std::make_shared<FlowPrimitives>(std::vector{source()}, Vec3{});
  const SumOfWinds sum({first, second});
  std::vector<Vec3> points;
  for (double i = 0; i < 600; ++i) points.push_back({0.01 * i, -0.02 * i, i});
  std::vector<Vec3> out(points.size(), Vec3{99, 99, 99});
  sum.velocities_mps(points, 1, out);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 a = first->velocity_mps(points[i], 1);
    const Vec3 b = second->velocity_mps(points[i], 1);
    ASSERT_NEAR(out[i].x, a.x + b.x, 1e-12);
    ASSERT_NEAR(out[i].y, a.y + b.y, 1e-12);
  }
  EXPECT_EQ(sum.velocity_mps(points[3], 1).x, out[3].x);
  EXPECT_EQ(SumOfWinds({}).velocity_mps({1, 2, 3}, 4).x, 0);
}

}  // namespace
}  // namespace roseau::synthesis
