#include "synthesis/wind/lattice_axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace roseau::synthesis {
namespace {

TEST(LatticeAxis, CoversTheRangeAtTheSpacingWithLinesThroughExactPositions) {
  const LatticeAxis axis(std::vector{1.35, 9.0, -3.0}, LatticeRange{-2, 2}, 0.6);
  const auto& lines = axis.lines_m();
  EXPECT_TRUE(std::ranges::is_sorted(lines));
  for (const double exact : {1.35, 9.0, -3.0, -2.0, 2.0}) EXPECT_EQ(std::ranges::count(lines, exact), 1) << exact;
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    if (lines[i] >= -2 && lines[i + 1] <= 2) {
      EXPECT_LE(lines[i + 1] - lines[i], 0.6 + 1e-9);
    }
    EXPECT_NEAR(axis.widths_m()[axis.width_index(i)], lines[i + 1] - lines[i], 2e-6);
  }
  EXPECT_EQ(lines.size(), 11U);  // -3 | -2 and 6 parts | 1.35 and 2 parts | 2 | 9
}

TEST(LatticeAxis, SharesALineBelowAMillimetre) {
  EXPECT_EQ(LatticeAxis(std::vector{1.0, 1.0007, 0.9996}, {}, 0.6).size(), 2U);
  EXPECT_EQ(LatticeAxis(std::vector{1.0005, 1.0}, {}, 0.6).size(), 1U);
  EXPECT_EQ(LatticeAxis(std::vector{0.0005}, LatticeRange{0, 1.2}, 0.6).size(), 3U);
  EXPECT_EQ(LatticeAxis({}, LatticeRange{2, 2}, 0.6).size(), 1U);
}

TEST(LatticeAxis, FindsPlacesOnAnyLattice) {
  const LatticeAxis axis(std::vector{0.31, 0.313, 7.7, -20.0}, LatticeRange{-1, 1}, 0.25);
  const auto& lines = axis.lines_m();
  for (double position = -20.5; position < 8; position += 0.00137) {
    const auto place = axis.locate(position);
    const auto right = std::ranges::upper_bound(lines, position);
    const auto expected = right == lines.begin() ? 0 : static_cast<std::uint32_t>(right - lines.begin() - 1);
    ASSERT_EQ(place.line, expected) << position;
    if (place.line + 1 < lines.size() && position > lines.front()) {
      const double share = (position - lines[place.line]) / (lines[place.line + 1] - lines[place.line]);
      ASSERT_NEAR(place.share, share, 1e-6);
    } else {
      ASSERT_EQ(place.share, 0);
    }
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_EQ(axis.locate(lines[i]).line, i);
    EXPECT_EQ(axis.locate(lines[i]).share, 0);
    const auto before = axis.locate(std::nextafter(lines[i], -100));
    EXPECT_GE(before.share, 0);
    EXPECT_LE(before.share, 1);
  }
  EXPECT_EQ(axis.locate(std::nan("")).line, 0U);
}

}  // namespace
}  // namespace roseau::synthesis
