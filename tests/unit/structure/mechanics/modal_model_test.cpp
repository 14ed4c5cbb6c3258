#include "structure/mechanics/modal_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/structure/mechanics/trees.h"

namespace roseau::structure {
namespace {

using testing::crooked_tree;
using testing::pole;

ModalModel model_of(const TreeModel& tree, std::size_t modes, const BeamOptions& options = {}) {
  auto model = ModalModel::build(tree, options, {.mode_count = modes});
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return std::move(*model);
}

TEST(ModalModel, ScalesGiveWhatANewAnalysisGives) {
  ModalModel scaled = model_of(crooked_tree(), 8);
  ASSERT_TRUE(scaled.set_parameters({.young_modulus_scale = 0.7, .density_scale = 1.3, .mass_factor = 1}));
  const Material material{.young_modulus_pa = 0.7e10, .density_kg_m3 = 1300, .leaf_mass_per_area_kg_m2 = 0.26};
  const ModalModel fresh = model_of(crooked_tree(), 8, {.material = material, .point_masses = {}});
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(scaled.natural_frequency_hz(i), fresh.natural_frequency_hz(i), 1e-9 * fresh.natural_frequency_hz(i));
  }
  EXPECT_NEAR(scaled.total_mass_kg(), fresh.total_mass_kg(), 1e-9);
  // The same force bends both by as much.
  const auto bend = [](const ModalModel& model) {
    return model.displacement_m(8, model.static_amplitudes(model.modal_force_at(8, {3, -2, 1})));
  };
  EXPECT_NEAR(bend(scaled).x, bend(fresh).x, 1e-9);
  EXPECT_NEAR(bend(scaled).y, bend(fresh).y, 1e-9);
}

TEST(ModalModel, MassFactorAsInTheThesisCorrected) {
  ModalModel model = model_of(crooked_tree(), 6);
  const double before = model.natural_frequency_hz(2);
  ASSERT_TRUE(model.set_parameters({.mass_factor = 4, .alpha_per_s = 0.3, .beta_s = 0.002}));
  EXPECT_NEAR(model.natural_frequency_hz(2), before / 2, 1e-12 * before);  // 6.37
  const double w = 2 * std::numbers::pi * model.natural_frequency_hz(2);
  EXPECT_NEAR(model.damping_coefficient_per_s()[2], 0.3 + 0.002 * w * w, 1e-12);  // 6.38 for C' = alpha M' + beta K
  EXPECT_NEAR(model.damping_ratio(2), (0.3 + 0.002 * w * w) / (2 * w), 1e-12);
  EXPECT_EQ(model.modal_mass(), 4);
}

TEST(ModalModel, RayleighDampingHitsBothRatios) {
  ModalModel model = model_of(crooked_tree(), 6);
  const auto damping = rayleigh_damping(model.natural_frequency_hz(0), 0.05, model.natural_frequency_hz(5), 0.08);
  ASSERT_TRUE(model.set_parameters({.alpha_per_s = damping.alpha_per_s, .beta_s = damping.beta_s}));
  EXPECT_NEAR(model.damping_ratio(0), 0.05, 1e-12);
  EXPECT_NEAR(model.damping_ratio(5), 0.08, 1e-12);
}

TEST(ModalModel, RefusesParametersWithoutMeaning) {
  ModalModel model = model_of(pole(5), 3);
  const double before = model.natural_frequency_hz(0);
  EXPECT_FALSE(model.set_parameters({.young_modulus_scale = 0}));
  EXPECT_FALSE(model.set_parameters({.density_scale = -1}));
  EXPECT_FALSE(model.set_parameters({.mass_factor = std::nan("")}));
  EXPECT_FALSE(model.set_parameters({.alpha_per_s = -0.1}));
  EXPECT_FALSE(model.set_parameters({.beta_s = std::numeric_limits<double>::infinity()}));
  EXPECT_EQ(model.natural_frequency_hz(0), before);
}

TEST(ModalModel, FootStandsStillAndTheTipMoves) {
  const ModalModel model = model_of(pole(10), 4);
  const Eigen::VectorXd q = Eigen::VectorXd::Constant(4, 0.3);
  EXPECT_EQ(model.displacement_m(0, q).x, 0);
  EXPECT_EQ(model.rotation_rad(0, q).y, 0);
  EXPECT_NE(model.displacement_m(10, q).x, 0);
  // Pole along z: leaning to +x turns it about +y.
  EXPECT_GT(model.translation(10, 0).x() * model.rotations()(3 * 10 + 1, 0), 0);
  EXPECT_EQ(model.translations().rows(), 33);
}

TEST(ModalModel, AllModesTogetherBendLikeTheBeam) {
  const ModalModel model = model_of(pole(10), 60);
  const Eigen::VectorXd q = model.static_amplitudes(model.modal_force_at(10, {10, 0, 0}));
  const double truth = 10 * 8 / (3 * 1e10 * std::numbers::pi * 1.6e-7 / 4);  // F L^3 / 3 E I
  EXPECT_NEAR(model.displacement_m(10, q).x, truth, 1e-8 * truth);
  EXPECT_NEAR(model.rotation_rad(10, q).y, 1.5 * truth / 2, 1e-8 * truth);  // F L^2 / 2 E I
}

TEST(ModalModel, AbsurdSizesAreRefusedBeforeTheyStart) {
  const auto model = ModalModel::build(pole(100), {}, {.mode_count = 10, .memory_limit_bytes = 1e5});
  ASSERT_FALSE(model);
  EXPECT_THAT(model.error().message, ::testing::HasSubstr("cantilever"));
}

}  // namespace
}  // namespace roseau::structure
