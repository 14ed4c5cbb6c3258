#include "synthesis/render/coverage.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "core/random.h"

namespace roseau::render {
namespace {

constexpr int kSize = 24;
constexpr PixelArea kAll{0, 0, kSize, kSize};
using Picture = std::array<std::array<double, kSize>, kSize>;

Picture swept(Coverage& coverage) {
  Picture picture{};
  coverage.sweep([&picture](int y, int left, std::span<const float> shares) {
    for (std::size_t i = 0; i < shares.size(); ++i)
      picture.at(static_cast<std::size_t>(y)).at(static_cast<std::size_t>(left) + i) = shares[i];
  });
  return picture;
}

Picture covered(std::span<const ImagePoint> polygon, const PixelArea& clip = kAll) {
  Coverage coverage(kSize, kSize);
  return coverage.begin(polygon, clip) ? swept(coverage) : Picture{};
}

double total(const Picture& picture) {
  double sum = 0;
  for (const auto& row : picture) {
    for (const double share : row) sum += share;
  }
  return sum;
}

double area(std::span<const ImagePoint> polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const ImagePoint& a = polygon[i];
    const ImagePoint& b = polygon[(i + 1) % polygon.size()];
    twice += double{a.x} * double{b.y} - double{b.x} * double{a.y};
  }
  return std::abs(twice) / 2;
}

TEST(Coverage, OfARectangleIsThePixelsSharesInside) {
  // Pixel (3, 5) reaches from 2.5 to 3.5 and from 4.5 to 5.5.
  const Picture picture = covered(std::array<ImagePoint, 4>{{{2.75F, 4.9F}, {6.0F, 4.9F}, {6.0F, 7.1F}, {2.75F, 7.1F}}});
  EXPECT_NEAR(picture[5][3], 0.75 * 0.6, 1e-6);
  EXPECT_NEAR(picture[5][4], 0.6, 1e-6);
  EXPECT_NEAR(picture[6][3], 0.75, 1e-6);
  EXPECT_NEAR(picture[6][4], 1, 1e-6);
  EXPECT_NEAR(picture[6][6], 0.5, 1e-6);
  EXPECT_NEAR(picture[7][5], 0.6, 1e-6);
  EXPECT_EQ(picture[4][4], 0);
  EXPECT_EQ(picture[6][2], 0);
  EXPECT_EQ(picture[6][7], 0);
}

TEST(Coverage, OfAHalfPlaneEdgeIsExact) {
  // The edge x = y / 2 through pixel (2, 4) cuts it in half; pixel (2, 3) has x - 2 < (y - 4) / 2 on a quarter of its area.
  const Picture picture = covered(std::array<ImagePoint, 3>{{{-0.5F, -1.0F}, {9.5F, 19.0F}, {-0.5F, 19.0F}}});
  EXPECT_NEAR(picture[4][2], 0.5, 1e-6);
  EXPECT_NEAR(picture[3][2], 0.0625, 1e-6);
  EXPECT_NEAR(picture[3][1], 0.9375, 1e-6);
}

std::vector<ImagePoint> random_polygon(const RandomStream& random, std::uint64_t index, double reach) {
  std::vector<ImagePoint> polygon;
  const double cx = random.uniform(100 * index, 8, 16);
  const double cy = random.uniform(100 * index + 1, 8, 16);
  for (std::uint64_t corner = 0; corner < 5; ++corner) {
    const double angle = (static_cast<double>(corner) + random.uniform(100 * index + 2 + corner)) * 1.2566;
    const double radius = random.uniform(100 * index + 20 + corner, 0.1, reach);
    polygon.push_back({static_cast<float>(cx + radius * std::cos(angle)), static_cast<float>(cy + radius * std::sin(angle))});
  }
  return polygon;
}

// Any lost or doubled piece of an edge would show in the sum; a shifted one in the centroid.
TEST(Coverage, KeepsAreaAndCentroidOfAnyPolygon) {
  const RandomStream random(7, 1);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const std::vector<ImagePoint> polygon = random_polygon(random, i, i % 2 == 0 ? 7.0 : 0.9);
    const Picture picture = covered(polygon);
    ASSERT_NEAR(total(picture), area(polygon), 2e-4) << i;
    double moment = 0;
    for (std::size_t y = 0; y < kSize; ++y) {
      for (std::size_t x = 0; x < kSize; ++x) moment += picture[y][x] * static_cast<double>(y);
    }
    double exact = 0;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const ImagePoint& a = polygon[k];
      const ImagePoint& b = polygon[(k + 1) % polygon.size()];
      exact += (double{a.y} + double{b.y}) * (double{a.x} * double{b.y} - double{b.x} * double{a.y}) / 6;
    }
    // A pixel's middle stands for all of it: within a row, up to a twelfth of a row's share.
    ASSERT_NEAR(moment / total(picture), std::abs(exact) / area(polygon), 0.35) << i;
  }
}

TEST(Coverage, IsTheShareOfManyPointsInside) {
  const RandomStream random(8, 1);
  for (std::uint64_t i = 0; i < 20; ++i) {
    const std::array<ImagePoint, 3> triangle{
        {{static_cast<float>(random.uniform(10 * i, 2, 20)), static_cast<float>(random.uniform(10 * i + 1, 2, 20))},
         {static_cast<float>(random.uniform(10 * i + 2, 2, 20)), static_cast<float>(random.uniform(10 * i + 3, 2, 20))},
         {static_cast<float>(random.uniform(10 * i + 4, 2, 20)), static_cast<float>(random.uniform(10 * i + 5, 2, 20))}}};
    const Picture picture = covered(triangle);
    constexpr int kFine = 32;
    for (std::size_t y = 0; y < kSize; ++y) {
      for (std::size_t x = 0; x < kSize; ++x) {
        int inside = 0;
        for (int k = 0; k < kFine * kFine; ++k) {
          const int row_of_points = k / kFine;
          const double px = static_cast<double>(x) - 0.5 + (k % kFine + 0.5) / kFine;
          const double py = static_cast<double>(y) - 0.5 + (row_of_points + 0.5) / kFine;
          int sides = 0;
          for (std::size_t c = 0; c < 3; ++c) {
            const ImagePoint& a = triangle.at(c);
            const ImagePoint& b = triangle.at((c + 1) % 3);
            sides += (double{b.x} - double{a.x}) * (py - double{a.y}) - (double{b.y} - double{a.y}) * (px - double{a.x}) > 0
                         ? 1
                         : -1;
          }
          inside += std::abs(sides) == 3 ? 1 : 0;
        }
        ASSERT_NEAR(picture[y][x], inside / double{kFine * kFine}, 0.04) << i << " at " << x << ", " << y;
      }
    }
  }
}

TEST(Coverage, UprightEdgesOnPixelBordersDoNotLeak) {
  for (const float x : {3.4999998F, 3.5F, 3.5000002F, 3.5004F}) {
    const Picture picture = covered(std::array<ImagePoint, 4>{{{x, 2.5F}, {9.5F, 2.5F}, {9.5F, 8.5F}, {3.5F, 8.5F}}});
    EXPECT_NEAR(picture[5][4], 1, 1e-3) << x;
    EXPECT_NEAR(picture[5][3], 0, 1e-3) << x;
    EXPECT_NEAR(picture[5][9], 1, 1e-3) << x;
    EXPECT_NEAR(picture[5][10], 0, 1e-6) << x;
  }
}

TEST(Coverage, NeighboursJoinWithoutASeamAndHolesAreHoles) {
  Coverage coverage(kSize, kSize);
  const std::array<ImagePoint, 4> left{{{2.3F, 2.3F}, {6.7F, 3.1F}, {7.1F, 12.2F}, {2.3F, 12.7F}}};
  const std::array<ImagePoint, 4> right{{{6.7F, 3.1F}, {12.1F, 2.2F}, {12.1F, 12.1F}, {7.1F, 12.2F}}};
  const std::array<ImagePoint, 4> bounds{{{2.3F, 2.2F}, {12.1F, 2.2F}, {12.1F, 12.7F}, {2.3F, 12.7F}}};
  ASSERT_TRUE(coverage.begin(bounds, kAll));
  swept(coverage);
  // Only the two halves: their common edge must not show.
  std::array<ImagePoint, 4> hole = bounds;
  std::ranges::reverse(hole);
  ASSERT_TRUE(coverage.begin(bounds, kAll));
  coverage.add(hole);  // nothing left
  coverage.add(left);
  coverage.add(right);
  const Picture picture = swept(coverage);
  for (std::size_t y = 4; y < 12; ++y) {
    for (std::size_t x = 4; x < 12; ++x) EXPECT_NEAR(picture[y][x], 1, 1e-5) << x << ", " << y;
  }
  EXPECT_NEAR(total(picture), area(left) + area(right), 1e-3);
}

TEST(Coverage, IsCutOffAtTheClip) {
  const std::array<ImagePoint, 3> triangle{{{-40, 5}, {60, -30}, {30, 70}}};
  const Picture whole = covered(triangle);
  const PixelArea band{4, 9, 17, 13};
  const Picture cut = covered(triangle, band);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const bool inside = x >= band.left && x < band.right && y >= band.top && y < band.bottom;
      const auto i = static_cast<std::size_t>(x);
      const auto j = static_cast<std::size_t>(y);
      ASSERT_NEAR(cut[j][i], inside ? whole[j][i] : 0, 1e-5) << x << ", " << y;
    }
  }
  EXPECT_GT(total(cut), 10);
  Coverage coverage(kSize, kSize);
  EXPECT_FALSE(coverage.begin(std::array<ImagePoint, 3>{{{30, 5}, {60, 3}, {35, 9}}}, kAll));
  EXPECT_FALSE(coverage.begin(std::array<ImagePoint, 3>{{{3, -5}, {6, -3}, {5, -0.6F}}}, kAll));
  const float nan = std::nanf("");
  EXPECT_FALSE(coverage.begin(std::array<ImagePoint, 3>{{{nan, nan}, {nan, nan}, {nan, nan}}}, kAll));
}

TEST(Coverage, LeavesNothingBehindForTheNextShape) {
  Coverage coverage(kSize, kSize);
  const RandomStream random(9, 1);
  for (std::uint64_t i = 0; i < 300; ++i) {
    ASSERT_TRUE(coverage.begin(random_polygon(random, i, 14), kAll));
    swept(coverage);
  }
  const std::array<ImagePoint, 4> all{{{-0.5F, -0.5F}, {23.5F, -0.5F}, {23.5F, 23.5F}, {-0.5F, 23.5F}}};
  ASSERT_TRUE(coverage.begin(all, kAll));
  EXPECT_EQ(total(swept(coverage)), kSize * kSize);
}

}  // namespace
}  // namespace roseau::render
