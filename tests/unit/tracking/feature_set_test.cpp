// The lives of a region's points.
#include "tracking/feature_set.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/tracking/scene.h"

namespace roseau::tracking {
namespace {

using Eigen::Vector2d;
using testing::Picture;
using testing::Texture;

const ImageRect kArea{30, 30, 120, 90};

cv::Mat picture_of(std::uint64_t seed) {
  Picture picture(180, 150);
  picture.draw(Texture(seed, 30, 40), {});
  cv::Mat mat(picture.height(), picture.width(), CV_8U);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) mat.at<std::uint8_t>(y, x) = picture.pixel(x, y);
  }
  return mat;
}

class FeatureSetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    flow_.advance(picture_of(41));
    set_.start(flow_, kArea, 40, {}, still_);
    ASSERT_GT(set_.wanted(), 20);
  }

  int count(auto predicate) const { return static_cast<int>(std::ranges::count_if(set_.all(), predicate)); }

  /// A frame in which the points for which `seen` holds were recognised where they were, and the others were not.
  void frame(auto seen, bool region_seen = true) {
    for (Feature& feature : set_.all()) {
      feature.matched = feature.agrees = seen(feature);
      if (feature.matched) feature.position = still_.expected(feature.reference);
    }
    set_.keep_or_drop(still_, region_seen);
  }

  const TrackerOptions options_;
  Flow flow_{options_};
  FeatureSet set_{options_, RegionKind::target};
  Placement still_;
};

bool is_right(const Feature& feature) { return feature.reference.x() >= 90; }
bool is_left(const Feature& feature) { return !is_right(feature); }
bool any(const Feature&) { return true; }
bool none(const Feature&) { return false; }

TEST_F(FeatureSetTest, PointsOfTheReferencePictureAreKeptWhileUnseenAndComeBack) {
  const int all = set_.wanted();
  for (int i = 0; i < 3; ++i) frame(is_left);
  EXPECT_EQ(set_.active_count(), count(is_left));
  EXPECT_EQ(static_cast<int>(set_.all().size()), all);
  // They are looked for, a quarter of them in every frame.
  for (std::uint32_t i = 0; i < 4; ++i) {
    set_.match_inactive(flow_, still_, i);
    set_.keep_or_drop(still_, true);
  }
  EXPECT_EQ(set_.active_count(), all);
}

TEST_F(FeatureSetTest, LostPointsAreReplacedAndTheReplacementsGoWhenTheyComeBack) {
  const int all = set_.wanted();
  for (int i = 0; i < 3; ++i) frame(is_left);
  const int left = set_.active_count();
  ASSERT_LT(left, 0.7 * all);
  // What they saw is gone: another texture is there now, with other corners.
  flow_.advance(picture_of(42));
  set_.replenish(flow_, kArea, {}, still_, 0.01, 3);
  EXPECT_EQ(set_.active_count(), left) << "not before it is due";
  set_.replenish(flow_, kArea, {}, still_, 0.01, 15);
  EXPECT_GT(set_.active_count(), left + 5);
  EXPECT_LE(set_.active_count(), all);
  for (const Feature& feature : set_.all()) {
    if (feature.generation == 0) continue;
    EXPECT_EQ(feature.reference_variance, 0.01);
    EXPECT_LT((feature.reference - feature.position).norm(), 1e-9);
  }
  frame(any);
  EXPECT_EQ(set_.active_count(), all);
  EXPECT_EQ(count([](const Feature& f) { return f.generation == 0; }), all);
}

TEST_F(FeatureSetTest, ReplacementsThatFailAreDroppedUnlessTheWholeRegionIsLost) {
  for (int i = 0; i < 3; ++i) frame(is_left);
  flow_.advance(picture_of(42));
  set_.replenish(flow_, kArea, {}, still_, 0.01, 15);
  const auto is_new = [](const Feature& feature) { return feature.generation > 0; };
  const int fresh = count(is_new);
  ASSERT_GT(fresh, 5);
  for (int i = 0; i < 5; ++i) frame(none, false);
  EXPECT_EQ(count(is_new), fresh) << "it will be found again by them";
  frame(is_left);
  EXPECT_EQ(count([&](const Feature& f) { return is_new(f) && !is_left(f); }), 0);
}

TEST_F(FeatureSetTest, APointWhoseLookChangesHandsItsReferenceOn) {
  Placement moved;
  moved.motion.displacement = {3.3, -1.2};
  for (Feature& feature : set_.all()) {
    feature.previous = feature.position = moved.expected(feature.reference) + Vector2d(0.2, 0.1);  // its own way to move
    feature.matched = false;
    feature.followed = feature.moves_along = is_right(feature);
    feature.missed = 1;
    feature.agreed = 7;
  }
  flow_.advance(picture_of(43));
  set_.hand_over(flow_, moved, 0.0025);
  const auto is_heir = [](const Feature& feature) { return feature.generation == 1; };
  const int heirs = count(is_heir);
  EXPECT_GT(heirs, 5);
  EXPECT_EQ(count([](const Feature& f) { return f.generation == 0 && !f.active; }), heirs);
  for (const Feature& heir : set_.all()) {
    if (!is_heir(heir)) continue;
    EXPECT_TRUE(heir.active);
    EXPECT_EQ(heir.agreed, 7) << "no probation";
    EXPECT_EQ(heir.reference_variance, 0.0025);
    EXPECT_EQ(heir.position, heir.cut_at.cast<double>());
    EXPECT_LT((heir.position - moved.expected(heir.reference) - Vector2d(0.2, 0.1)).norm(), 1e-9) << "its own way is kept";
  }
}

TEST_F(FeatureSetTest, NothingIsHandedOnAtTheFirstMissOrByPointsThatGoTheirOwnWay) {
  for (Feature& feature : set_.all()) {
    feature.matched = false;
    feature.followed = true;
    feature.moves_along = is_left(feature);
    feature.missed = is_left(feature) ? 0 : 1;
  }
  set_.hand_over(flow_, still_, 0.0025);
  EXPECT_EQ(count([](const Feature& f) { return f.generation > 0; }), 0);
}

TEST_F(FeatureSetTest, StillPointsGoAndTheirPlacesAreNotTakenAgain) {
  const int all = set_.wanted();
  std::vector<Vector2d> places;
  for (Feature& feature : set_.all()) {
    if (is_left(feature)) continue;
    feature.still = 10;
    places.push_back(feature.reference);
  }
  EXPECT_EQ(set_.drop_still(), static_cast<int>(places.size()));
  ASSERT_EQ(static_cast<int>(set_.all().size()), all - static_cast<int>(places.size()));
  set_.replenish(flow_, kArea, {}, still_, 0.01, 15);
  for (const Feature& feature : set_.all()) {
    if (feature.generation == 0) continue;
    for (const Vector2d& place : places) EXPECT_GT((feature.position - place).norm(), 5);
  }
}

TEST_F(FeatureSetTest, TheLimitKeepsTheMostUseful) {
  for (int i = 0; i < 3; ++i) frame(is_left);
  const int left = count(is_left);
  set_.limit(left);
  EXPECT_EQ(static_cast<int>(set_.all().size()), left);
  EXPECT_EQ(count(is_left), left);
}

TEST_F(FeatureSetTest, TheBackgroundIsRenewedCellByCell) {
  FeatureSet background(options_, RegionKind::background);
  background.start(flow_, {0, 0, 180, 150}, 60, {}, still_);
  for (Feature& feature : background.all()) feature.active = false;
  background.replenish(flow_, {0, 0, 180, 150}, {}, still_, 0, 15);
  const int first = background.active_count();
  EXPECT_GT(first, 0);
  for (const Feature& feature : background.all()) {
    if (!feature.active) continue;
    EXPECT_LT(feature.position.x(), 180 / 4 + 1) << "the first of four by three cells";
    EXPECT_LT(feature.position.y(), 150 / 3 + 1);
  }
}

}  // namespace
}  // namespace roseau::tracking
