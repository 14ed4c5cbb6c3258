#include "estimation/wind_fusion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace roseau::estimation {
namespace {

constexpr double kPeriod_s = 0.04;

HostTime at_ms(std::int64_t ms) { return host_time_from_ns(ms * 1'000'000); }

WindEstimate estimate(double wind_mps, double sd_mps) {
  WindEstimate wind;
  wind.wind_mps = wind_mps;
  wind.wind_sd_mps = sd_mps;
  wind.lag_s = 0.25;
  wind.accepted = true;
  wind.settling = false;
  wind.scale_known = true;
  return wind;
}

TEST(WindFusion, OneTargetPassesThroughAtOnce) {
  WindFusion fusion;
  const auto fused = fusion.add("a", at_ms(1000), estimate(3, 0.2), 90, kPeriod_s);
  ASSERT_EQ(fused.size(), 1U);
  EXPECT_EQ(fused[0].sample_time, at_ms(1000));
  EXPECT_DOUBLE_EQ(fused[0].wind.wind_mps, 3);
  EXPECT_DOUBLE_EQ(fused[0].wind.wind_sd_mps, 0.2);
  EXPECT_FALSE(fused[0].wind.settling);
}

TEST(WindFusion, WeighsByInverseVarianceAndWaitsForTheSlower) {
  WindFusion fusion;
  EXPECT_EQ(fusion.add("a", at_ms(1000), estimate(0, 1), 90, kPeriod_s).size(), 1U);
  // "b" has a longer lag: its estimates of the same times come later.
  EXPECT_EQ(fusion.add("b", at_ms(990), estimate(9, 1), 90, kPeriod_s).size(), 0U);
  EXPECT_EQ(fusion.add("a", at_ms(1040), estimate(3, 0.1), 90, kPeriod_s).size(), 0U);
  EXPECT_EQ(fusion.add("a", at_ms(1080), estimate(5, 0.1), 90, kPeriod_s).size(), 0U);
  WindEstimate settling = estimate(4, 0.2);
  settling.lag_s = 0.5;
  settling.settling = true;
  const auto fused = fusion.add("b", at_ms(1045), settling, 100, kPeriod_s);
  ASSERT_EQ(fused.size(), 1U);
  EXPECT_EQ(fused[0].sample_time, at_ms(1040));
  EXPECT_NEAR(fused[0].wind.wind_mps, (3 / 0.01 + 4 / 0.04) / (1 / 0.01 + 1 / 0.04), 1e-12);
  EXPECT_NEAR(fused[0].wind.wind_sd_mps, (0.1 / 0.01 + 0.2 / 0.04) / (1 / 0.01 + 1 / 0.04), 1e-12);
  EXPECT_EQ(fused[0].wind.lag_s, 0.5);
  EXPECT_FALSE(fused[0].wind.settling);  // one of them has settled
}

TEST(WindFusion, OtherDirectionsAreLeftOut) {
  WindFusion fusion;
  (void)fusion.add("a", at_ms(1000), estimate(0, 1), 350, kPeriod_s);
  (void)fusion.add("b", at_ms(1000), estimate(0, 1), 50, kPeriod_s);
  (void)fusion.add("c", at_ms(1000), estimate(0, 1), 5, kPeriod_s);
  (void)fusion.add("b", at_ms(1040), estimate(100, 0.1), 50, kPeriod_s);
  (void)fusion.add("c", at_ms(1040), estimate(4, 0.1), 5, kPeriod_s);
  const auto fused = fusion.add("a", at_ms(1040), estimate(2, 0.1), 350, kPeriod_s);
  ASSERT_EQ(fused.size(), 1U);
  EXPECT_NEAR(fused[0].wind.wind_mps, 3, 1e-12);
}

TEST(WindFusion, ASilentTargetIsNotWaitedForForever) {
  WindFusion fusion;
  (void)fusion.add("a", at_ms(1000), estimate(1, 1), 90, kPeriod_s);
  (void)fusion.add("b", at_ms(1000), estimate(1, 1), 90, kPeriod_s);
  std::size_t count = 0;
  for (int i = 1; i <= 50; ++i) count += fusion.add("b", at_ms(1000 + 40 * i), estimate(2, 1), 90, kPeriod_s).size();
  // "a" leads but is lost: after a second "b" leads, and what it had saved up comes out.
  EXPECT_GE(count, 49U);
  fusion.remove("a");
  EXPECT_EQ(fusion.add("b", at_ms(3040), estimate(2, 1), 90, kPeriod_s).size(), 1U);
}

TEST(WindFusion, OnlyAcceptedAndCalibratedEstimatesCount) {
  WindFusion fusion;
  WindEstimate wind = estimate(3, 0.2);
  wind.accepted = false;
  EXPECT_TRUE(fusion.add("a", at_ms(1000), wind, 90, kPeriod_s).empty());
  wind = estimate(3, 0.2);
  wind.scale_known = false;
  EXPECT_TRUE(fusion.add("a", at_ms(1040), wind, 90, kPeriod_s).empty());
  EXPECT_TRUE(fusion.add("a", at_ms(1080), estimate(std::nan(""), 0.2), 90, kPeriod_s).empty());
}

}  // namespace
}  // namespace roseau::estimation
