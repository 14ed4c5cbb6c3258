// The figures of docs/mechanics.md for real trees.
#include <gtest/gtest.h>

#include "structure/mechanics/modal_model.h"
#include "structure/tree/tree_file.h"
#include "tests/support/data.h"

namespace roseau::structure {
namespace {

ModalModel model_of(const std::filesystem::path& path, std::size_t modes) {
  const auto imported = read_tree(path, {});
  EXPECT_TRUE(imported.has_value()) << imported.error().message;
  auto model = ModalModel::build(imported->tree, {}, {.mode_count = modes});
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return std::move(*model);
}

TEST(RealTrees, ScannedTreesSwayAsDocumented) {
  ROSEAU_REQUIRE_DATA(folder, "data/tree_qsm_wytham");
  const ModalModel tree14 = model_of(folder / "cyl_data_Tf14_Validation_1_1.mat", 3);
  EXPECT_NEAR(tree14.natural_frequency_hz(0), 0.1814, 0.0005);
  EXPECT_NEAR(tree14.natural_frequency_hz(1), 0.1818, 0.0005);
  EXPECT_LT(tree14.largest_residual(), 1e-9);
  const ModalModel tree16 = model_of(folder / "cyl_data_Tf16_Validation_1_1.mat", 3);
  EXPECT_NEAR(tree16.natural_frequency_hz(0), 0.2665, 0.0005);
  EXPECT_LT(tree16.largest_residual(), 1e-9);
}

TEST(RealTrees, WalnutHasTwentyFiveModes) {
  ROSEAU_REQUIRE_DATA(path, "data/mtg_walnut/noylum2.mtg");
  const ModalModel walnut = model_of(path, 25);
  EXPECT_NEAR(walnut.natural_frequency_hz(0), 1.14, 0.01);
  EXPECT_LT(walnut.largest_residual(), 1e-9);
}

}  // namespace
}  // namespace roseau::structure
