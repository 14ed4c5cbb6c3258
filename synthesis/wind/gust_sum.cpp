// Highway compiles this file once for each kind of CPU.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "synthesis/wind/gust_sum.cpp"  // NOLINT(bugprone-suspicious-include): that is how it works
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "core/check.h"
#include "synthesis/wind/gust_sum.h"

HWY_BEFORE_NAMESPACE();
namespace roseau::synthesis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::FixedTag<float, 4> kOne;  // the components of one entry

// As many of the four entries in a vector as it holds.
constexpr std::size_t kEntries = HWY_MAX_BYTES >= 64 ? 4 : HWY_MAX_BYTES >= 32 ? 2 : 1;
using Tag = hn::FixedTag<float, 4 * kEntries>;

HWY_INLINE hn::Vec<Tag> load(const GustTables::Entry* entries) {
  const auto counts = hn::LoadU(hn::FixedTag<std::int16_t, 4 * kEntries>(), entries->counts.data());
  return hn::ConvertTo(Tag(), hn::PromoteTo(hn::FixedTag<std::int32_t, 4 * kEntries>(), counts));
}

// Sum over the terms for each of the four entries, then over the entries.
HWY_INLINE void sum_one(const GustReading& reading, float* HWY_RESTRICT sum) {
  alignas(64) float totals[16];
  const Tag tag;
#if HWY_MAX_BYTES >= 64
  auto total = hn::Zero(tag);
  for (std::size_t i = 0; i < GustReading::kTerms; ++i) {
    total = hn::Add(total, hn::Mul(load(reading.entries + reading.starts[i]), hn::Set(tag, reading.shares[i])));
  }
  hn::Store(total, tag, totals);
#elif HWY_MAX_BYTES >= 32
  auto early = hn::Zero(tag);
  auto late = hn::Zero(tag);
  for (std::size_t i = 0; i < GustReading::kTerms; ++i) {
    const GustTables::Entry* entries = reading.entries + reading.starts[i];
    const auto share = hn::Set(tag, reading.shares[i]);
    early = hn::Add(early, hn::Mul(load(entries), share));
    late = hn::Add(late, hn::Mul(load(entries + 2), share));
  }
  hn::Store(early, tag, totals);
  hn::Store(late, tag, totals + 8);
#else
  auto total0 = hn::Zero(tag);
  auto total1 = hn::Zero(tag);
  auto total2 = hn::Zero(tag);
  auto total3 = hn::Zero(tag);
  for (std::size_t i = 0; i < GustReading::kTerms; ++i) {
    const GustTables::Entry* entries = reading.entries + reading.starts[i];
    const auto share = hn::Set(tag, reading.shares[i]);
    total0 = hn::Add(total0, hn::Mul(load(entries), share));
    total1 = hn::Add(total1, hn::Mul(load(entries + 1), share));
    total2 = hn::Add(total2, hn::Mul(load(entries + 2), share));
    total3 = hn::Add(total3, hn::Mul(load(entries + 3), share));
  }
  hn::Store(total0, tag, totals);
  hn::Store(total1, tag, totals + 4);
  hn::Store(total2, tag, totals + 8);
  hn::Store(total3, tag, totals + 12);
#endif
  const auto weighted = [&](std::size_t entry) {
    return hn::Mul(hn::Load(kOne, totals + 4 * entry), hn::Set(kOne, reading.weights[entry]));
  };
  hn::StoreU(hn::Add(hn::Add(weighted(0), weighted(1)), hn::Add(weighted(2), weighted(3))), kOne, sum);
}

void sum_all(std::span<const GustReading> readings, std::span<std::array<float, 4>> sums) {
  for (std::size_t i = 0; i < readings.size(); ++i) sum_one(readings[i], sums[i].data());
}

}  // namespace roseau::synthesis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace roseau::synthesis {

HWY_EXPORT(sum_all);

void sum_gusts(std::span<const GustReading> readings, std::span<std::array<float, 4>> sums) {
  ROSEAU_CHECK(readings.size() == sums.size());
  HWY_DYNAMIC_DISPATCH(sum_all)(readings, sums);
}

}  // namespace roseau::synthesis
#endif
