#include "synthesis/wind/gust_sum.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <vector>

namespace roseau::synthesis {
namespace {

std::vector<GustTables::Entry> entries() {
  std::vector<GustTables::Entry> made(64);
  for (std::size_t i = 0; i < made.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      made[i].counts[c] = static_cast<std::int16_t>(static_cast<int>((i * 7919 + c * 104729) % 65535) - 32767);
    }
  }
  return made;
}

struct Readings {
  std::vector<GustReading> all;
  std::vector<std::array<std::uint32_t, GustReading::kTerms>> starts;
};

Readings readings(const std::vector<GustTables::Entry>& table) {
  Readings made{std::vector<GustReading>(20), std::vector<std::array<std::uint32_t, GustReading::kTerms>>(20)};
  for (std::uint32_t i = 0; i < 20; ++i) {
    made.all[i] = {
        .entries = table.data(), .starts = made.starts[i].data(), .weights = cubic_weights(0.05F * static_cast<float>(i))};
    for (std::uint32_t term = 0; term < GustReading::kTerms; ++term) {
      made.starts[i][term] = (i * 3 + term * 11) % 60;
      made.all[i].shares[term] = 0.3F + 0.1F * static_cast<float>(term) - 0.05F * static_cast<float>(i);
    }
  }
  return made;
}

TEST(GustSum, IsTheWeightedSum) {
  const auto table = entries();
  const Readings made = readings(table);
  const auto& all = made.all;
  std::vector<std::array<float, 4>> sums(all.size());
  sum_gusts(all, sums);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      double wanted = 0;
      for (std::size_t term = 0; term < GustReading::kTerms; ++term) {
        for (std::size_t k = 0; k < 4; ++k) {
          wanted += static_cast<double>(all[i].shares[term]) * static_cast<double>(all[i].weights[k]) *
                    all[i].entries[all[i].starts[term] + k].counts[c];
        }
      }
      EXPECT_NEAR(sums[i][c], wanted, 0.05);
    }
  }
}

// A scene gives the same bytes on every CPU, as far as the wind goes.
TEST(GustSum, GivesTheSameBitsWithEveryKindOfVectors) {
  const auto table = entries();
  const Readings made = readings(table);
  const auto& all = made.all;
  std::vector<std::array<float, 4>> widest(all.size());
  sum_gusts(all, widest);
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    std::vector<std::array<float, 4>> sums(all.size());
    sum_gusts(all, sums);
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(sums[i][c], widest[i][c]) << hwy::TargetName(target);
    }
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

TEST(GustSum, CubicWeightsSumToOneAndMeet) {
  for (float share = 0; share <= 1; share += 0.1F) {
    const auto w = cubic_weights(share);
    EXPECT_NEAR(w[0] + w[1] + w[2] + w[3], 1, 1e-6);
    EXPECT_NEAR(-w[0] + w[2] + 2 * w[3], share, 1e-6);  // a straight line stays one
  }
  EXPECT_NEAR(cubic_weights(1)[3], cubic_weights(0)[2], 1e-7);
}

}  // namespace
}  // namespace roseau::synthesis
