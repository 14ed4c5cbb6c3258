#include "structure/animation/large_amplitude.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace roseau::structure {
namespace {

using testing::HasSubstr;

// A pole of 1 m in 20 segments along z.
Skeleton pole(int segments = 20) {
  Skeleton skeleton{.rest_m = Eigen::VectorXd::Zero(3 * (segments + 1)), .parents = {}};
  for (int n = 0; n <= segments; ++n) {
    skeleton.rest_m[3 * n + 2] = static_cast<double>(n) / segments;
    skeleton.parents.push_back(n - 1);
  }
  return skeleton;
}

// Bent by the same angle everywhere: per unit of q, one radian between foot and tip.
Eigen::VectorXd uniform_bending(const Skeleton& skeleton) {
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(skeleton.rest_m.size());
  for (Eigen::Index at = 0; at < shape.size(); at += 3) shape[at] = skeleton.rest_m[at + 2] * skeleton.rest_m[at + 2] / 2;
  return shape;
}

TEST(KeepLengths, EverySegmentKeepsItsLengthAndTheFootStands) {
  const Skeleton skeleton = pole();
  Eigen::VectorXd displacement_m = 1.3 * uniform_bending(skeleton);
  EXPECT_GT(length_error(skeleton, displacement_m).worst, 0.5);
  keep_lengths(skeleton, displacement_m);
  EXPECT_LT(length_error(skeleton, displacement_m).worst, 1e-13);
  EXPECT_EQ(displacement_m.head<3>().norm(), 0);
}

// The end of an arc of one radian is sin(1) up and 1 - cos(1) aside; the linear mode has it at 1 and 1/2.
TEST(KeepLengths, BentPoleIsNearerToTheExactArc) {
  const Skeleton skeleton = pole(200);
  Eigen::VectorXd displacement_m = uniform_bending(skeleton);
  const Eigen::Vector3d arc(1 - std::cos(1.0), 0, std::sin(1.0) - 1);
  EXPECT_NEAR((Eigen::Vector3d(displacement_m.tail<3>()) - arc).norm(), 0.1635, 1e-3);
  keep_lengths(skeleton, displacement_m);
  const double left_m = (Eigen::Vector3d(displacement_m.tail<3>()) - arc).norm();
  // Pulling restores the lengths, not the whole turn: less than half of the linear mode's error is left.
  EXPECT_NEAR(left_m, 0.0605, 1e-3);
}

// What a branch bears moves along with it, and is not turned towards where it was: a twig across the tip stays across.
TEST(KeepLengths, SegmentsKeepTheDirectionThatTheModeGaveThem) {
  Skeleton skeleton = pole();
  skeleton.rest_m.conservativeResize(skeleton.rest_m.size() + 3);
  skeleton.rest_m.tail<3>() << 0, 0.02, 1;
  skeleton.parents.push_back(20);
  Eigen::VectorXd displacement_m = Eigen::VectorXd::Zero(skeleton.rest_m.size());
  displacement_m.head(63) = uniform_bending(pole());
  displacement_m.tail<3>() = displacement_m.segment<3>(60);
  keep_lengths(skeleton, displacement_m);
  const Eigen::Vector3d twig = displacement_m.tail<3>() - displacement_m.segment<3>(60);
  EXPECT_LT(twig.norm(), 1e-15);
  EXPECT_LT(displacement_m[62], -0.1);
}

TEST(KeepLengths, NodeOnItsParentFollowsItAndCollapsedSegmentStands) {
  Skeleton skeleton = pole(2);
  skeleton.rest_m.tail<3>() = skeleton.rest_m.segment<3>(3);  // the last segment has no length
  Eigen::VectorXd displacement_m(9);
  displacement_m << 0, 0, 0, 0, 0, -0.5, 7, 7, 7;  // the first one is pushed onto the foot
  keep_lengths(skeleton, displacement_m);
  EXPECT_TRUE(displacement_m.isZero()) << displacement_m.transpose();
}

TEST(FitCurve, FindsTheCurveThatTheSamplesLieOn) {
  std::vector<double> q(41);
  std::iota(q.begin(), q.end(), -20);
  for (double& value : q) value *= 0.13;
  const double b = 0.83;
  Eigen::VectorXd v(6);
  Eigen::VectorXd w(6);
  v << 1, -2, 0.5, 0, 0.1, 3;
  w << -0.4, 0.3, 0, 0.2, -1, 0.05;
  Eigen::MatrixXd samples(6, static_cast<Eigen::Index>(q.size()));
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double s = std::atan(b * q[j]) / b;
    samples.col(static_cast<Eigen::Index>(j)) = s * v + s * s * w;
  }
  const CurveFit fit = fit_curve(q, samples);
  EXPECT_NEAR(fit.b, b, 1e-5);
  EXPECT_LT((fit.v - v).norm(), 1e-4);
  EXPECT_LT((fit.w - w).norm(), 1e-4);
  EXPECT_LT(fit.residual, 1e-6);
}

TEST(FitCurve, StraightMotionIsNotBent) {
  const std::array q{-2.0, -1.0, 0.0, 1.0, 2.0};
  Eigen::MatrixXd samples(3, 5);
  for (int j = 0; j < 5; ++j) samples.col(j) = Eigen::Vector3d(1, 0, -1) * q[static_cast<std::size_t>(j)];
  const CurveFit fit = fit_curve(q, samples);
  EXPECT_LT((fit.v - Eigen::Vector3d(1, 0, -1)).norm(), 1e-3);
  EXPECT_LT(fit.w.norm(), 1e-9);
  EXPECT_LT(fit.residual, 1e-5);
}

class CorrectedPole : public testing::Test {
 protected:
  // The figures of docs/animation.md.
  void expect_lengths(double q, double linear, double shared, double node_wise) const {
    const Eigen::VectorXd amplitude = Eigen::VectorXd::Constant(1, q);
    EXPECT_NEAR(length_error(skeleton_, q * shape_).rms, linear, 0.005 * linear) << q;
    EXPECT_LT(length_error(skeleton_, shared_->displacement_m(amplitude)).rms, shared) << q;
    EXPECT_LT(length_error(skeleton_, node_wise_->displacement_m(amplitude)).rms, node_wise) << q;
  }

  Skeleton skeleton_ = pole();
  Eigen::VectorXd shape_ = uniform_bending(skeleton_);
  std::array<double, 1> range_{1};
  Result<LargeAmplitudeCorrection> shared_ = fit_correction(skeleton_, shape_, range_);
  Result<NodeWiseCorrection> node_wise_ = fit_node_wise_correction(skeleton_, shape_, range_);
};

TEST_F(CorrectedPole, LengthsAreKeptFarBetterThanByTheLinearShape) {
  ASSERT_TRUE(shared_ && node_wise_);
  expect_lengths(0.25, 0.0138, 0.0008, 0.0005);
  expect_lengths(0.50, 0.0536, 0.0016, 0.0010);
  expect_lengths(0.75, 0.1152, 0.0013, 0.0005);
  expect_lengths(1.00, 0.1941, 0.0090, 0.0015);
  EXPECT_LT(shared_->residual[0], 0.013);
  EXPECT_LT(node_wise_->residual[0], 0.0015);
}

TEST_F(CorrectedPole, SmallMotionIsTheLinearOneAndFarBeyondTheRangeItStaysBounded) {
  ASSERT_TRUE(shared_);
  const Eigen::VectorXd small = shared_->displacement_m(Eigen::VectorXd::Constant(1, 1e-4));
  EXPECT_LT((small - 1e-4 * shape_).norm(), 0.05 * 1e-4 * shape_.norm());
  EXPECT_LT(shared_->displacement_m(Eigen::VectorXd::Constant(1, 1e6)).cwiseAbs().maxCoeff(), 3);
}

TEST_F(CorrectedPole, SecondAxisIsCurvedTowardsTheFoot) {
  ASSERT_TRUE(shared_);
  EXPECT_GT(shared_->b[0], 0);
  EXPECT_LT(shared_->w(shared_->w.rows() - 1, 0), 0);  // the tip sinks when bent either way
  EXPECT_EQ(shared_->v.col(0).head<3>().norm(), 0);    // the foot stands
  EXPECT_EQ(shared_->w.col(0).head<3>().norm(), 0);
}

TEST(FitCorrection, NodesAndModesThatDoNotMoveStayWhereTheyAre) {
  Skeleton skeleton = pole(4);
  for (int n = 0; n <= 4; ++n) {  // a twig from the foot that the mode does not move
    skeleton.rest_m.conservativeResize(skeleton.rest_m.size() + 3);
    skeleton.rest_m.tail<3>() << 0.1 * (n + 1), 0, 0;
    skeleton.parents.push_back(n == 0 ? 0 : 4 + n);
  }
  Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(skeleton.rest_m.size(), 2);
  for (Eigen::Index n = 1; n <= 4; ++n) shapes(3 * n, 0) = static_cast<double>(n * n);
  shapes(3 * 7 + 1, 0) = 1e-14;
  const std::array range{0.05, 1.0};
  const Eigen::Vector2d q(0.05, 1);
  const auto shared = fit_correction(skeleton, shapes, range);
  const auto node_wise = fit_node_wise_correction(skeleton, shapes, range);
  ASSERT_TRUE(shared && node_wise);
  for (const Eigen::VectorXd& displacement_m : {shared->displacement_m(q), node_wise->displacement_m(q)}) {
    EXPECT_TRUE(displacement_m.allFinite());
    EXPECT_GT(displacement_m[3 * 4], 0.5);
    EXPECT_LT(displacement_m.tail(15).cwiseAbs().maxCoeff(), 1e-12);
  }
  EXPECT_EQ(shared->residual[1], 0);
  EXPECT_EQ(shared->displacement_m(Eigen::Vector2d(0, 1)).norm(), 0);
}

TEST(FitCorrection, RefusesWhatDoesNotFit) {
  const Skeleton skeleton = pole(4);
  const Eigen::MatrixXd shapes = Eigen::MatrixXd::Ones(15, 2);
  const auto message = [&](const Skeleton& s, const Eigen::MatrixXd& m, std::vector<double> range, std::size_t samples = 33) {
    const auto fit = fit_correction(s, m, range, {.samples = samples});
    return fit ? std::string("accepted") : fit.error().message;
  };
  EXPECT_EQ(message(skeleton, shapes, {1, 1}), "accepted");
  EXPECT_THAT(message(skeleton, shapes.topRows(12), {1, 1}), HasSubstr("12 per shape"));
  EXPECT_THAT(message(skeleton, Eigen::MatrixXd(15, 0), {}), HasSubstr("no mode"));
  EXPECT_THAT(message(skeleton, shapes, {1}), HasSubstr("2 modes, but 1 amplitude"));
  EXPECT_THAT(message(skeleton, shapes, {1, 0}), HasSubstr("mode 1 is 0"));
  EXPECT_THAT(message(skeleton, shapes, {1, 1}, 4), HasSubstr("fewer than 5"));
  Skeleton loop = skeleton;
  loop.parents[2] = 3;
  EXPECT_THAT(message(loop, shapes, {1, 1}), HasSubstr("node 2 comes before its parent 3"));
  Eigen::MatrixXd hole = shapes;
  hole(3, 1) = std::nan("");
  EXPECT_THAT(message(skeleton, hole, {1, 1}), HasSubstr("not a finite number"));
}

TEST(AmplitudesInWind, AreTwiceTheSteadyDeflectionAndNeverNothing) {
  ModalBasis basis{.shapes = Eigen::MatrixXd::Identity(3, 3),
                   .natural_frequency_hz = Eigen::Vector3d(0.5, 1, 2),
                   .damping_coefficient_per_s = Eigen::Vector3d(1, 1, 1),
                   .wind_projection = Eigen::Matrix3d::Zero()};
  basis.wind_projection.col(0) << 0.3, 0.4, 7;  // 7: what the ground lets through
  const auto amplitudes = amplitudes_in_wind(basis, 10);
  const double steady = 100 * 0.5 / std::pow(2 * std::numbers::pi * 0.5, 2);
  EXPECT_NEAR(amplitudes[0], 2 * steady, 1e-12);
  EXPECT_NEAR(amplitudes[1], 0.1 * steady, 1e-12);
  basis.wind_projection.setZero();
  EXPECT_GT(amplitudes_in_wind(basis, 10)[2], 0);
}

TEST(AmplitudeFor, MovesTheFarthestNodeByTheGivenDisplacement) {
  Eigen::VectorXd shape(6);
  shape << 0, 1, 0, 3, 0, 4;
  EXPECT_DOUBLE_EQ(amplitude_for(shape, 0.5), 0.1);
  EXPECT_EQ(amplitude_for(Eigen::VectorXd::Zero(6), 0.5), 0);
}

}  // namespace
}  // namespace roseau::structure
