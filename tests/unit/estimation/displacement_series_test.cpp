#include "estimation/displacement_series.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "estimation/state_archive.h"
#include "tests/support/sway_simulation.h"

namespace roseau::estimation {
namespace {

using Added = DisplacementSeries::Added;

HostTime at_ms(double ms) { return host_time_from_ns(std::llround(ms * 1e6)); }

TEST(DisplacementSeries, FindsTheRateThroughJitterAndDrops) {
  testing::GaussianSource random(1);
  DisplacementSeries series(0.5);
  std::size_t taken = 0;
  for (int i = 0; i < 3000; ++i) {
    if (i % 17 == 5) continue;
    const auto added = series.add(at_ms(1000 + i * 1000 / 29.97 + 3 * random.normal()), {1.0 * i, 2});
    if (added != Added::nothing) taken += series.appended_count();
  }
  series.refine_period();
  EXPECT_NEAR(series.period_s(), 1 / 29.97, 5e-6);
  EXPECT_EQ(series.frames().size(), 3000U);
  EXPECT_EQ(taken, 3000U);
  int missing = 0;
  for (const auto& frame : series.frames()) missing += frame.measured ? 0 : 1;
  EXPECT_EQ(missing, 177);
  // A straight line stays one through its holes.
  const auto along = series.along({1, 0}, 500);
  ASSERT_EQ(along.size(), 500U);
  for (std::size_t i = 0; i < along.size(); ++i) EXPECT_NEAR(along[i], 2500.0 + static_cast<double>(i), 1e-9);
}

TEST(DisplacementSeries, HoldsBackUntilTheRateIsKnown) {
  DisplacementSeries series(0.5);
  for (int i = 0; i < 16; ++i) EXPECT_EQ(series.add(at_ms(250 * i), {1, 0}), Added::nothing);
  EXPECT_EQ(series.period_s(), 0);
  EXPECT_EQ(series.add(at_ms(4000), {1, 0}), Added::restarted);
  EXPECT_EQ(series.appended_count(), 17U);
  EXPECT_DOUBLE_EQ(series.period_s(), 0.25);
  EXPECT_EQ(series.add(at_ms(4250), {1, 0}), Added::appended);
}

TEST(DisplacementSeries, DropsWhatIsDoubledOrOutOfOrder) {
  DisplacementSeries series(0.5);
  for (int i = 0; i < 20; ++i) (void)series.add(at_ms(100 * i), {1.0 * i, 0});
  EXPECT_EQ(series.add(at_ms(1900), {7, 0}), Added::nothing);
  EXPECT_EQ(series.add(at_ms(1800), {7, 0}), Added::nothing);
  EXPECT_EQ(series.add(at_ms(1920), {7, 0}), Added::nothing);
  EXPECT_EQ(series.frames().size(), 20U);
  EXPECT_EQ(series.add(at_ms(2003), {20, 0}), Added::appended);
  EXPECT_EQ(series.appended_count(), 1U);
}

TEST(DisplacementSeries, BridgesShortHolesAndBeginsAnewAfterLongOnes) {
  DisplacementSeries series(0.5);
  for (int i = 0; i < 40; ++i) (void)series.add(at_ms(40 * i), {1, 0});
  EXPECT_EQ(series.add(at_ms(40 * 39 + 480), {1, 0}), Added::appended);
  EXPECT_EQ(series.appended_count(), 12U);
  EXPECT_EQ(series.add(at_ms(40 * 39 + 480 + 560), {1, 0}), Added::restarted);
  EXPECT_EQ(series.frames().size(), 1U);
  EXPECT_DOUBLE_EQ(series.period_s(), 0.04);
  // A slow series bridges three of its own steps.
  DisplacementSeries slow(0.5);
  for (int i = 0; i < 40; ++i) (void)slow.add(at_ms(1000 * i), {1, 0});
  EXPECT_EQ(slow.add(at_ms(42000), {1, 0}), Added::appended);
  EXPECT_EQ(slow.appended_count(), 3U);
}

TEST(DisplacementSeries, NoticesANewRate) {
  for (const double new_step_ms : {20.0, 80.0}) {
    DisplacementSeries series(0.5);
    for (int i = 0; i < 100; ++i) (void)series.add(at_ms(40 * i), {1, 0});
    double time_ms = 40 * 99;
    for (int i = 0; i < 60; ++i) (void)series.add(at_ms(time_ms += new_step_ms), {1, 0});
    EXPECT_NEAR(series.period_s(), new_step_ms * 1e-3, 1e-9);
    EXPECT_LT(series.segment_s(), 60 * new_step_ms * 1e-3);
  }
}

TEST(DisplacementSeries, ForgetsTheOldest) {
  DisplacementSeries series(0.5);
  for (int i = 0; i < 1000; ++i) {
    if (i != 899) (void)series.add(at_ms(40 * i), {1.0 * i, 0});
  }
  series.keep_newest(101);
  EXPECT_EQ(series.frames().size(), 102U);  // the frame wanted first is missing: one more is kept
  EXPECT_TRUE(series.frames().front().measured);
  EXPECT_NEAR(series.segment_s(), 40, 1e-9);
  EXPECT_EQ(series.along({1, 0}, 101).front(), 899);
}

TEST(MainAxis, FollowsTheMotionWithAFixedSign) {
  testing::GaussianSource random(3);
  const auto moving = [&](double angle_deg) {
    DisplacementSeries series(0.5);
    for (int i = 0; i < 300; ++i) {
      const double along = 5 * std::sin(0.3 * i);
      const double angle = angle_deg * 3.14159265358979 / 180;
      const double noise = 0.3 * random.normal();
      (void)series.add(at_ms(40 * i), {30 + along * std::cos(angle) + 0.1 * i, along * std::sin(angle) + noise});
    }
    return series;
  };
  const auto slanted = main_axis(moving(150), 300, nullptr);
  EXPECT_NEAR(slanted.x, std::cos(-30 * 3.14159265 / 180), 0.02);
  EXPECT_NEAR(slanted.y, std::sin(-30 * 3.14159265 / 180), 0.03);
  const auto upright = main_axis(moving(-85), 300, nullptr);
  EXPECT_GT(upright.y, 0.9);
  // Once in use, a sign stays.
  const Vec2 previous{-0.9, 0.4};
  const auto kept = main_axis(moving(150), 300, &previous);
  EXPECT_LT(kept.x, -0.8);
  // A series of one component.
  DisplacementSeries single(0.5);
  for (int i = 0; i < 300; ++i) (void)single.add(at_ms(250 * i), {std::sin(0.3 * i), 0});
  EXPECT_EQ(main_axis(single, 300, nullptr).x, 1);
}

TEST(StateArchive, GivesBackWhatWasStoredAndRefusesDamage) {
  DisplacementSeries series(0.5);
  for (int i = 0; i < 50; ++i) {
    if (i % 7 != 3) (void)series.add(at_ms(40 * i), {0.1 * i, -0.2 * i});
  }
  std::vector<std::byte> bytes;
  StateWriter writer(bytes);
  writer(series);
  writer(std::string("target"));
  writer(std::optional<double>());
  writer(std::vector<std::int64_t>{1, -2});

  StateReader reader(bytes);
  DisplacementSeries copy(0.5);
  std::string text;
  std::optional<double> nothing = 3;
  std::vector<std::int64_t> numbers;
  reader(copy), reader(text), reader(nothing), reader(numbers);
  EXPECT_TRUE(reader.ok() && reader.at_end());
  EXPECT_EQ(text, "target");
  EXPECT_FALSE(nothing);
  EXPECT_EQ(numbers, (std::vector<std::int64_t>{1, -2}));
  EXPECT_EQ(copy.along({1, 0}, 40), series.along({1, 0}, 40));
  EXPECT_EQ(copy.add(at_ms(40 * 50), {5, 5}), series.add(at_ms(40 * 50), {5, 5}));

  for (std::size_t size = 0; size < bytes.size(); size += 13) {
    StateReader brief{std::span<const std::byte>(bytes).first(size)};
    DisplacementSeries damaged(0.5);
    brief(damaged), brief(text), brief(nothing), brief(numbers);
    EXPECT_FALSE(brief.ok());
  }
}

}  // namespace
}  // namespace roseau::estimation
