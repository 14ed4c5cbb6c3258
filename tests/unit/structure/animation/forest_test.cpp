#include "structure/animation/forest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "allocation_count.h"
#include "core/random.h"
#include "structure/animation/forest_kernels.h"
#include "structure/animation/gust_wind.h"

namespace roseau::structure {
namespace {

using testing::HasSubstr;

constexpr double kTurn = 2 * std::numbers::pi;

ModalBasis random_basis(std::size_t nodes, std::size_t modes) {
  const RandomStream numbers(3, nodes);
  std::uint64_t next = 0;
  const auto columns = static_cast<Eigen::Index>(modes);
  ModalBasis basis{.shapes = Eigen::MatrixXd(static_cast<Eigen::Index>(3 * nodes), columns),
                   .natural_frequency_hz = Eigen::VectorXd::LinSpaced(columns, 0.5, 4),
                   .damping_coefficient_per_s = Eigen::VectorXd::LinSpaced(columns, 0.2, 0.6),
                   .wind_projection = Eigen::Matrix3Xd(3, columns)};
  for (double& value : basis.shapes.reshaped()) value = numbers.uniform(next++, -1, 1);
  for (double& value : basis.wind_projection.reshaped()) value = numbers.uniform(next++, -0.1, 0.1);
  return basis;
}

LargeAmplitudeCorrection random_correction(const ModalBasis& basis) {
  LargeAmplitudeCorrection correction{.b = Eigen::VectorXd::LinSpaced(basis.shapes.cols(), 0, 2),
                                      .v = basis.shapes,
                                      .w = basis.shapes.colwise().reverse(),
                                      .residual = Eigen::VectorXd::Zero(basis.shapes.cols())};
  return correction;
}

std::vector<TreeInstance> stand(std::size_t count) {
  std::vector<TreeInstance> trees(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double half_turn = 0.37 * static_cast<double>(k);
    const std::size_t row = k / 10;
    trees[k].position_in_world_m = {5 * static_cast<double>(k % 10), 7 * static_cast<double>(row), 0};
    trees[k].world_from_tree = {std::cos(half_turn), 0, 0, std::sin(half_turn)};
  }
  return trees;
}

Forest made(Result<Forest> forest) {
  EXPECT_TRUE(forest) << forest.error().message;
  return std::move(*forest);
}

// Every instance in a state of its own, then a frame of no length: what is computed is the product alone.
Forest scattered(const ModalBasis& basis, const LargeAmplitudeCorrection* correction, std::size_t count, unsigned threads = 2) {
  Forest forest = made(correction != nullptr ? Forest::make(basis, *correction, stand(count), {.threads = threads})
                                             : Forest::make(basis, stand(count), {.threads = threads}));
  const RandomStream numbers(4, count);
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t i = 0; i < basis.mode_count(); ++i) {
      forest.set_modal_state(k, i, numbers.uniform(k * basis.mode_count() + i, -3, 3), 0);
    }
  }
  forest.advance(0, std::vector<Vec3>(count));
  return forest;
}

// Largest error of the output against a loop in double precision, relative to the largest displacement.
double product_error(const Forest& forest, const ModalBasis& basis, const LargeAmplitudeCorrection* correction) {
  double worst = 0;
  double largest = 0;
  for (std::size_t k = 0; k < forest.instance_count(); ++k) {
    const auto row = forest.displacements_m(k);
    for (Eigen::Index r = 0; r < basis.shapes.rows(); ++r) {
      double sum = 0;
      for (Eigen::Index i = 0; i < basis.shapes.cols(); ++i) {
        const double q = forest.modal_coordinate(k, static_cast<std::size_t>(i));
        if (correction == nullptr) {
          sum += basis.shapes(r, i) * q;
        } else {
          const double b = correction->b[i];
          const double s = b > 0 ? std::atan(b * q) / b : q;
          sum += s * correction->v(r, i) + s * s * correction->w(r, i);
        }
      }
      worst = std::max(worst, std::abs(sum - row[static_cast<std::size_t>(r)]));
      largest = std::max(largest, std::abs(sum));
    }
  }
  return worst / largest;
}

TEST(Forest, DisplacementIsTheProductOfShapesAndAmplitudes) {
  for (const std::size_t nodes : {1U, 5U, 32U, 37U, 333U}) {
    for (const std::size_t count : {1U, 3U, 16U, 21U, 67U, 200U}) {
      const ModalBasis basis = random_basis(nodes, 7);
      EXPECT_LT(product_error(scattered(basis, nullptr, count), basis, nullptr), 5e-7) << nodes << " nodes, " << count;
    }
  }
}

TEST(Forest, CorrectedDisplacementIsTheSumOfCurves) {
  for (const std::size_t nodes : {1U, 37U, 333U}) {
    for (const std::size_t count : {1U, 21U, 200U}) {
      const ModalBasis basis = random_basis(nodes, 7);
      const auto correction = random_correction(basis);
      EXPECT_LT(product_error(scattered(basis, &correction, count), basis, &correction), 2e-6) << nodes << " nodes, " << count;
    }
  }
}

TEST(Forest, CorrectedCoordinatesAreExactFromTheSmallestToTheLargest) {
  ModalBasis basis = random_basis(1, 1);
  basis.shapes << 1, 0, 0;
  const LargeAmplitudeCorrection correction{
      .b = Eigen::VectorXd::Constant(1, 1.5), .v = basis.shapes, .w = Eigen::Vector3d(0, 1, 0), .residual = {}};
  Forest forest = made(Forest::make(basis, correction, stand(1)));
  const std::vector<Vec3> still(1);
  for (double q = 1e-15; q < 1e6; q *= 1.37) {
    for (const double signed_q : {q, -q}) {
      forest.set_modal_state(0, 0, signed_q, 0);
      forest.advance(0, still);
      const double s = std::atan(1.5 * signed_q) / 1.5;
      EXPECT_NEAR(forest.displacements_m(0)[0], s, 4e-7 * std::abs(s));
      EXPECT_NEAR(forest.displacements_m(0)[1], s * s, 8e-7 * s * s);
    }
  }
}

TEST(Forest, OutputLargerThanTheCachesIsTheSame) {
  const ModalBasis basis = random_basis(8001, 3);
  const Forest forest = scattered(basis, nullptr, 190);
  ASSERT_GT(forest.all_displacements_m().size_bytes(), std::size_t{16} << 20);
  EXPECT_LT(product_error(forest, basis, nullptr), 5e-7);
}

TEST(Forest, EveryInstructionSetComputesTheSameForest) {
  const ModalBasis basis = random_basis(37, 7);
  const auto correction = random_correction(basis);
  const auto wind = GustWind::with_intensity({5, 1, 0}, 0.3);
  std::vector<std::vector<float>> outputs;
  const auto targets = hwy::SupportedAndGeneratedTargets();
  for (const std::int64_t target : targets) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_STREQ(instruction_set(), hwy::TargetName(target));
    Forest forest = scattered(basis, &correction, 21);
    EXPECT_LT(product_error(forest, basis, &correction), 2e-6) << instruction_set();
    for (int frame = 1; frame <= 50; ++frame) forest.advance(0.02, wind, 0.02 * frame);
    const auto all = forest.all_displacements_m();
    outputs.emplace_back(all.begin(), all.end());
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  ASSERT_GE(outputs.size(), 1U);
  for (const auto& output : outputs) {
    for (std::size_t i = 0; i < output.size(); ++i) ASSERT_NEAR(output[i], outputs.front()[i], 2e-4) << i;
  }
}

TEST(Forest, ThreadsDoNotShowInTheBits) {
  const ModalBasis basis = random_basis(50, 6);
  const auto correction = random_correction(basis);
  const auto wind = GustWind::with_intensity({4, -3, 0}, 0.4);
  std::vector<float> first;
  for (const unsigned threads : {1U, 2U, 3U}) {
    Forest forest = scattered(basis, &correction, 333, threads);
    for (int frame = 1; frame <= 100; ++frame) forest.advance(0.017, wind, 0.017 * frame);
    const auto all = forest.all_displacements_m();
    if (first.empty()) first.assign(all.begin(), all.end());
    ASSERT_EQ(first.size(), all.size());
    EXPECT_EQ(std::memcmp(first.data(), all.data(), all.size_bytes()), 0) << threads << " threads";
  }
}

TEST(Forest, FramesAllocateNothing) {
  const ModalBasis basis = random_basis(50, 6);
  const auto correction = random_correction(basis);
  const auto wind = GustWind::with_intensity({4, -3, 0}, 0.4);
  Forest forest = scattered(basis, &correction, 333);
  const std::vector<Vec3> winds(333, Vec3{1, 2, 3});
  const std::size_t before = allocation_count();
  for (int frame = 1; frame <= 20; ++frame) {
    forest.advance(0.01 * frame, wind, 0.01 * frame);
    forest.advance(0.02, winds);
  }
  forest.settle(winds);
  EXPECT_EQ(allocation_count(), before);
}

// q'' + gamma q' + w^2 q = f from rest, with f constant.
double step_response(double force, double frequency_hz, double gamma_per_s, double time_s) {
  const double omega = kTurn * frequency_hz;
  const double damped = std::sqrt(omega * omega - gamma_per_s * gamma_per_s / 4);
  const double decay = std::exp(-gamma_per_s * time_s / 2);
  const double wave = std::cos(damped * time_s) + gamma_per_s / 2 / damped * std::sin(damped * time_s);
  return force / (omega * omega) * (1 - decay * wave);
}

TEST(Forest, ModesAnswerAGustOfConstantWindInTheTreesOwnFrame) {
  const ModalBasis basis = random_basis(2, 5);
  const std::size_t count = 19;
  Forest forest = made(Forest::make(basis, stand(count)));
  const Vec3 wind{3, -4, 1};
  const std::vector<Vec3> winds(count, wind);
  forest.advance(0, winds);  // the wind sets in at once
  const double step_s = 1.0 / 240;
  const int frames = 2400;
  for (int frame = 0; frame < frames; ++frame) forest.advance(step_s, winds);
  for (std::size_t k = 0; k < count; ++k) {
    const double yaw = 2 * 0.37 * static_cast<double>(k);
    const Eigen::Vector3d local(std::cos(yaw) * wind.x + std::sin(yaw) * wind.y,
                                std::cos(yaw) * wind.y - std::sin(yaw) * wind.x, wind.z);
    for (Eigen::Index i = 0; i < 5; ++i) {
      const double force = local.norm() * local.dot(basis.wind_projection.col(i));
      const double gamma_per_s = basis.damping_coefficient_per_s[i];
      const double exact = step_response(force, basis.natural_frequency_hz[i], gamma_per_s, step_s * frames);
      const double scale = std::abs(force) / std::pow(kTurn * basis.natural_frequency_hz[i], 2);
      EXPECT_NEAR(forest.modal_coordinate(k, static_cast<std::size_t>(i)), exact, 5e-5 * scale + 1e-7) << k << " " << i;
    }
  }
}

TEST(Forest, FreeDecayAtAThousandFramesPerSecondIsTheClosedForm) {
  ModalBasis basis = random_basis(1, 1);
  basis.natural_frequency_hz[0] = 0.41;
  basis.damping_coefficient_per_s[0] = 0.02;
  Forest forest = made(Forest::make(basis, stand(1)));
  forest.set_modal_state(0, 0, 1, 0);
  const std::vector<Vec3> still(1);
  const int frames = 50'000;  // 50 s, 20.5 periods
  for (int frame = 0; frame < frames; ++frame) forest.advance(1e-3, still);
  const double decay = std::exp(-0.01 * 50);
  EXPECT_NEAR(forest.modal_coordinate(0, 0), -decay, 5e-5);
  EXPECT_NEAR(forest.modal_rate(0, 0) / (kTurn * 0.41), 0, 5e-3);
}

TEST(Forest, WindIsTakenWhereEachTreeStands) {
  const ModalBasis basis = random_basis(4, 3);
  const auto wind = GustWind::with_intensity({5, 2, 0}, 0.5);
  Forest with_field = made(Forest::make(basis, stand(70)));
  Forest with_array = made(Forest::make(basis, stand(70)));
  std::vector<Vec3> winds;
  for (int frame = 1; frame <= 30; ++frame) {
    winds.clear();
    for (const auto& tree : stand(70)) winds.push_back(wind.velocity_mps(tree.position_in_world_m, 0.1 * frame));
    with_field.advance(0.1, wind, 0.1 * frame);
    with_array.advance(0.1, winds);
  }
  EXPECT_GT(std::abs(winds[0].x - winds[69].x), 0.01);
  const auto a = with_field.all_displacements_m();
  EXPECT_EQ(std::memcmp(a.data(), with_array.all_displacements_m().data(), a.size_bytes()), 0);
}

TEST(Forest, SettledTreesStayWhileTheWindDoes) {
  const ModalBasis basis = random_basis(4, 3);
  Forest forest = made(Forest::make(basis, stand(20)));
  const std::vector<Vec3> winds(20, Vec3{6, 2, 0});
  forest.set_modal_state(7, 1, 100, 100);
  forest.settle(winds);
  const auto all = forest.all_displacements_m();
  const std::vector<float> settled(all.begin(), all.end());
  const double omega = kTurn * basis.natural_frequency_hz[1];
  const double force = std::sqrt(40.0) * (6 * basis.wind_projection(0, 1) + 2 * basis.wind_projection(1, 1));
  EXPECT_NEAR(forest.modal_coordinate(0, 1), force / (omega * omega), 1e-6);
  for (int frame = 0; frame < 100; ++frame) forest.advance(0.02, winds);
  for (std::size_t i = 0; i < settled.size(); ++i) ASSERT_NEAR(all[i], settled[i], 2e-5) << i;
}

TEST(Forest, TreesInStillAirComeToFullRest) {
  ModalBasis basis = random_basis(4, 3);
  basis.damping_coefficient_per_s.setConstant(2);
  Forest forest = scattered(basis, nullptr, 5);
  const std::vector<Vec3> still(5);
  for (int frame = 0; frame < 1000; ++frame) forest.advance(0.1, still);
  for (const float value : forest.all_displacements_m()) ASSERT_EQ(value, 0);
}

TEST(Forest, HoleInTheWindKeepsTheLastOne) {
  const ModalBasis basis = random_basis(4, 3);
  Forest forest = made(Forest::make(basis, stand(3)));
  std::vector<Vec3> winds(3, Vec3{6, 2, 0});
  forest.settle(winds);
  const double before = forest.modal_coordinate(1, 0);
  winds[1].x = std::numeric_limits<double>::quiet_NaN();
  for (int frame = 0; frame < 10; ++frame) forest.advance(0.1, winds);
  EXPECT_NEAR(forest.modal_coordinate(1, 0), before, 1e-5);
}

TEST(Forest, DynamicsChangeAtRunTime) {
  const ModalBasis basis = random_basis(4, 3);
  Forest forest = made(Forest::make(basis, stand(3)));
  const std::vector<Vec3> winds(3, Vec3{6, 2, 0});
  forest.settle(winds);
  const double light = forest.modal_coordinate(0, 0);
  ModalBasis stiff = basis;
  stiff.natural_frequency_hz *= 2;
  ASSERT_TRUE(forest.set_dynamics(stiff));
  forest.settle(winds);
  EXPECT_NEAR(forest.modal_coordinate(0, 0), light / 4, 1e-6 * std::abs(light));
  EXPECT_THAT(forest.set_dynamics(random_basis(4, 2)).error().message, HasSubstr("it has 3 modes, the new dynamics 2"));
}

std::string refusal(const Result<Forest>& forest) { return forest ? "accepted" : forest.error().message; }

TEST(Forest, RefusesBadInput) {
  const ModalBasis good = random_basis(4, 3);
  const auto with = [&](auto change) {
    ModalBasis basis = good;
    change(basis);
    return refusal(Forest::make(basis, stand(2)));
  };
  EXPECT_EQ(with([](ModalBasis&) {}), "accepted");
  EXPECT_THAT(with([](ModalBasis& b) { b = ModalBasis{}; }), HasSubstr("no mode"));
  EXPECT_THAT(with([](ModalBasis& b) { b.shapes.resize(0, 3); }), HasSubstr("no node"));
  EXPECT_THAT(with([](ModalBasis& b) { b.shapes.conservativeResize(11, 3); }), HasSubstr("11 rows"));
  EXPECT_THAT(with([](ModalBasis& b) { b.natural_frequency_hz.conservativeResize(2); }),
              HasSubstr("2 have a natural frequency"));
  EXPECT_THAT(with([](ModalBasis& b) { b.damping_coefficient_per_s.resize(0); }), HasSubstr("0 have a damping"));
  EXPECT_THAT(with([](ModalBasis& b) { b.wind_projection.resize(3, 5); }), HasSubstr("5 have a wind projection"));
  EXPECT_THAT(with([](ModalBasis& b) { b.natural_frequency_hz[1] = 0; }), HasSubstr("mode 1 is 0 Hz"));
  EXPECT_THAT(with([](ModalBasis& b) { b.damping_coefficient_per_s[2] = -1; }), HasSubstr("mode 2 is -1"));
  EXPECT_THAT(with([](ModalBasis& b) { b.shapes(1, 1) = std::nan(""); }), HasSubstr("not a finite number"));

  EXPECT_THAT(refusal(Forest::make(good, {})), HasSubstr("no tree"));
  auto trees = stand(3);
  trees[2].world_from_tree = {1, 1, 0, 0};
  EXPECT_THAT(refusal(Forest::make(good, trees)), HasSubstr("rotation of tree 2"));
  auto correction = random_correction(random_basis(4, 2));
  EXPECT_THAT(refusal(Forest::make(good, correction, stand(2))), HasSubstr("made for 4 nodes and 2 modes"));
  correction = random_correction(good);
  correction.b[0] = -1;
  EXPECT_THAT(refusal(Forest::make(good, correction, stand(2))), HasSubstr("negative"));
}

TEST(Forest, RefusesWhatDoesNotFitIntoMemoryBeforeItTakesAny) {
  const auto forest = Forest::make(random_basis(10000, 2), stand(1000), {.memory_limit_bytes = 50'000'000});
  ASSERT_FALSE(forest);
  EXPECT_EQ(forest.error().code, ErrorCode::no_space);
  EXPECT_THAT(forest.error().message, HasSubstr("1000 trees of 10000 nodes with 2 modes need 121 MB of memory, but 50 MB"));
}

TEST(GustWind, IsTheSumOfItsWavesCarriedByTheMeanWind) {
  const Vec3 mean{3, 4, 0.5};
  const std::vector<Gust> gusts{{.wavelength_m = 40, .direction_rad = 0.3, .phase_rad = 1, .along_mps = 2, .across_mps = -1},
                                {.wavelength_m = 15, .direction_rad = -0.2, .phase_rad = 4, .along_mps = 0.5, .across_mps = 1}};
  const GustWind wind(mean, gusts);
  const Vec3 point{17, -40, 2};
  const double time_s = 12.5;
  Vec3 expected = mean;
  for (const Gust& gust : gusts) {
    const double angle = std::atan2(mean.y, mean.x) + gust.direction_rad;
    const double k = kTurn / gust.wavelength_m;
    const double east_m = point.x - mean.x * time_s;
    const double north_m = point.y - mean.y * time_s;
    const double wave = std::sin(k * (std::cos(angle) * east_m + std::sin(angle) * north_m) + gust.phase_rad);
    expected.x += wave * (0.6 * gust.along_mps - 0.8 * gust.across_mps);
    expected.y += wave * (0.8 * gust.along_mps + 0.6 * gust.across_mps);
  }
  const Vec3 velocity = wind.velocity_mps(point, time_s);
  EXPECT_NEAR(velocity.x, expected.x, 2e-5);
  EXPECT_NEAR(velocity.y, expected.y, 2e-5);
  EXPECT_EQ(velocity.z, 0.5);
}

TEST(GustWind, HasTheIntensityAskedFor) {
  const auto wind = GustWind::with_intensity({0, 8, 0}, 0.25);
  double squares = 0;
  const int samples = 20'000;
  for (int i = 0; i < samples; ++i) squares += std::pow(wind.velocity_mps({1, 2, 3}, 0.37 * i).y - 8, 2);
  EXPECT_NEAR(std::sqrt(squares / samples), 2, 0.1);
}

}  // namespace
}  // namespace roseau::structure
