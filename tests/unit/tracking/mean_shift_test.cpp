#include "tracking/mean_shift.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

namespace roseau::tracking {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : random_(seed) {}
  void normal(int count, const Vector2d& mean, double sd) {
    std::normal_distribution<double> spread(0, sd);
    for (int i = 0; i < count; ++i) all.push_back(mean + Vector2d(spread(random_), spread(random_)));
  }
  void uniform(int count, double half_width) {
    std::uniform_real_distribution<double> spread(-half_width, half_width);
    for (int i = 0; i < count; ++i) all.emplace_back(spread(random_), spread(random_));
  }
  std::vector<Vector2d> all;

 private:
  std::mt19937_64 random_;
};

RobustMean robust_mean_of(const std::vector<Vector2d>& draws, const MeanShiftOptions& options = {}) {
  RobustMean result;
  robust_mean(draws, options, result);
  return result;
}

/// The step as the thesis prints it: M = -[weighted mean - x]^T S^-1, x <- x + M.
Vector2d printed_step(const std::vector<Vector2d>& draws, const Vector2d& x, const Matrix2d& covariance) {
  const Vector2d weighted_mean = mean_shift_step(draws, x, covariance).x;
  return x - covariance.inverse() * (weighted_mean - x);
}

// docs/errata.md, plant thesis 2.5.2: the printed step walks away from the mode, the corrected one to it.
TEST(MeanShift, CorrectedStepClimbsWherePrintedStepDescends) {
  Draws draws(7);
  draws.normal(60, {3.0, -1.0}, 0.3);
  draws.uniform(40, 8.0);
  const Matrix2d kernel = Matrix2d::Identity() * 0.5;
  const Vector2d start(2.0, -0.4);
  const double before = kernel_density(draws.all, start, kernel);

  Vector2d corrected = start;
  Vector2d printed = start;
  double corrected_density = before;
  for (int i = 0; i < 15; ++i) {
    corrected = mean_shift_step(draws.all, corrected, kernel).x;
    const double density = kernel_density(draws.all, corrected, kernel);
    EXPECT_GE(density, corrected_density - 1e-12) << "step " << i;
    corrected_density = density;
    printed = printed_step(draws.all, printed, kernel);
  }
  EXPECT_NEAR((corrected - Vector2d(3.0, -1.0)).norm(), 0, 0.1);
  EXPECT_GT(corrected_density, 1.2 * before);
  EXPECT_LT(kernel_density(draws.all, printed, kernel), 0.01 * before);
  EXPECT_GT((printed - Vector2d(3.0, -1.0)).norm(), 4.0);
}

// The other half of the erratum: the covariance must be taken about x. About the origin it holds the motion itself.
TEST(MeanShift, CovarianceIsAboutTheOldCentre) {
  Draws draws(8);
  draws.normal(4000, {50.0, 20.0}, 0.3);
  const MeanShiftStep step = mean_shift_step(draws.all, {50.0, 20.0}, Matrix2d::Identity() * 100);
  EXPECT_NEAR(step.covariance(0, 0), 0.09, 0.01);
  EXPECT_NEAR(step.covariance(1, 1), 0.09, 0.01);
}

// Why the narrowing must be stopped: a kernel as wide as the cluster sees half of its variance, every pass.
TEST(MeanShift, EveryPassHalvesTheCovarianceOfANormalCluster) {
  Draws draws(9);
  draws.normal(20000, {0, 0}, 1.0);
  Matrix2d covariance = Matrix2d::Identity();
  for (const double expected : {1.0 / 2, 1.0 / 3, 1.0 / 4}) {
    const MeanShiftStep step = mean_shift_step(draws.all, Vector2d::Zero(), covariance);
    covariance = step.covariance;
    EXPECT_NEAR(covariance(0, 0), expected, 0.02);
  }
}

TEST(RobustMean, FortyPercentScatteredOutliersDoNotPull) {
  Draws draws(1);
  draws.normal(120, {4.2, -2.6}, 0.1);
  draws.uniform(80, 12.0);
  const RobustMean result = robust_mean_of(draws.all);
  ASSERT_TRUE(result.found);
  EXPECT_NEAR(result.mean.x(), 4.2, 0.04);
  EXPECT_NEAR(result.mean.y(), -2.6, 0.04);
  EXPECT_NEAR(result.agreeing, 120, 6);
  EXPECT_NEAR(std::sqrt(result.covariance(0, 0)), 0.11, 0.03);  // 0.1 and the floor of 0.05
}

TEST(RobustMean, FortyPercentOutliersInOneClusterDoNotPull) {
  for (const double away : {0.8, 2.0, 20.0}) {
    Draws draws(2);
    draws.normal(60, {1.0, 0.5}, 0.1);
    draws.normal(40, {1.0 + away, 0.5}, 0.1);
    const RobustMean result = robust_mean_of(draws.all);
    ASSERT_TRUE(result.found);
    EXPECT_NEAR(result.mean.x(), 1.0, 0.04) << "second cluster " << away << " away";
    EXPECT_NEAR(result.agreeing, 60, 3) << "second cluster " << away << " away";
  }
}

TEST(RobustMean, CleanDrawsAreAveragedAlmostAll) {
  double error2 = 0;
  int agreeing = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Draws draws(seed);
    draws.normal(100, {-3.0, 7.0}, 0.5);
    const RobustMean result = robust_mean_of(draws.all);
    ASSERT_TRUE(result.found);
    error2 += (result.mean - Vector2d(-3.0, 7.0)).squaredNorm() / 2;
    agreeing += result.agreeing;
  }
  // The plain mean's standard error is 0.05; losing a few draws at the rim costs little.
  EXPECT_LT(std::sqrt(error2 / 50), 0.065);
  EXPECT_GT(agreeing, 50 * 93);
}

TEST(RobustMean, AWideUniformClusterIsKeptWhole) {
  // A turning region: displacement changes steadily across it. Its middle is wanted, not some part that happens to be dense.
  Draws draws(3);
  draws.uniform(200, 2.0);
  const RobustMean result = robust_mean_of(draws.all);
  ASSERT_TRUE(result.found);
  EXPECT_GT(result.agreeing, 170);
  EXPECT_NEAR(result.mean.norm(), 0, 0.35);
}

TEST(RobustMean, EqualDrawsGiveTheFloor) {
  const std::vector<Vector2d> draws(10, Vector2d(2, 3));
  const RobustMean result = robust_mean_of(draws, {.kernel_floor = 0.05});
  ASSERT_TRUE(result.found);
  EXPECT_EQ(result.agreeing, 10);
  EXPECT_DOUBLE_EQ(result.mean.x(), 2);
  EXPECT_NEAR(result.covariance(0, 0), 0.0025, 1e-12);
}

TEST(RobustMean, TwoDrawsAreNotEnough) {
  EXPECT_FALSE(robust_mean_of({Vector2d(0, 0), Vector2d(1, 1)}).found);
  EXPECT_FALSE(robust_mean_of({}).found);
}

}  // namespace
}  // namespace roseau::tracking
