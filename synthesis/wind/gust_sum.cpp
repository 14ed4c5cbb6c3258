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

#if HWY_MAX_BYTES >= 32
constexpr hn::FixedTag<float, 8> kPair;  // two entries in one vector

HWY_INLINE hn::Vec<hn::FixedTag<float, 8>> pair_at(const GustTables::Entry* entry) {
  const auto counts = hn::LoadU(hn::FixedTag<std::int16_t, 8>(), entry->counts.data());
  return hn::ConvertTo(kPair, hn::PromoteTo(hn::FixedTag<std::int32_t, 8>(), counts));
}

HWY_INLINE void sum_one(const GustReading& reading, float* HWY_RESTRICT sum) {
  const hn::FixedTag<float, 4> half;
  const auto& w = reading.weights;
  const auto first_weights = hn::Combine(kPair, hn::Set(half, w[1]), hn::Set(half, w[0]));
  const auto second_weights = hn::Combine(kPair, hn::Set(half, w[3]), hn::Set(half, w[2]));
  auto total = hn::Zero(kPair);
  for (std::uint32_t i = 0; i < reading.terms; ++i) {
    const GustTables::Entry* entries = reading.entries[i];
    const auto first = hn::Mul(pair_at(entries), first_weights);
    const auto second = hn::Mul(pair_at(entries + 2), second_weights);
    total = hn::Add(total, hn::Mul(hn::Add(first, second), hn::Set(kPair, reading.shares[i])));
  }
  hn::StoreU(hn::Add(hn::LowerHalf(half, total), hn::UpperHalf(half, total)), half, sum);
}
#else
constexpr hn::FixedTag<float, 4> kSingle;

HWY_INLINE hn::Vec<hn::FixedTag<float, 4>> single_at(const GustTables::Entry* entry) {
  const auto counts = hn::LoadU(hn::FixedTag<std::int16_t, 4>(), entry->counts.data());
  return hn::ConvertTo(kSingle, hn::PromoteTo(hn::FixedTag<std::int32_t, 4>(), counts));
}

HWY_INLINE void sum_one(const GustReading& reading, float* HWY_RESTRICT sum) {
  const auto w0 = hn::Set(kSingle, reading.weights[0]);
  const auto w1 = hn::Set(kSingle, reading.weights[1]);
  const auto w2 = hn::Set(kSingle, reading.weights[2]);
  const auto w3 = hn::Set(kSingle, reading.weights[3]);
  auto total_low = hn::Zero(kSingle);
  auto total_high = hn::Zero(kSingle);
  for (std::uint32_t i = 0; i < reading.terms; ++i) {
    const GustTables::Entry* entries = reading.entries[i];
    const auto share = hn::Set(kSingle, reading.shares[i]);
    const auto low = hn::Add(hn::Mul(single_at(entries), w0), hn::Mul(single_at(entries + 2), w2));
    const auto high = hn::Add(hn::Mul(single_at(entries + 1), w1), hn::Mul(single_at(entries + 3), w3));
    total_low = hn::Add(total_low, hn::Mul(low, share));
    total_high = hn::Add(total_high, hn::Mul(high, share));
  }
  hn::StoreU(hn::Add(total_low, total_high), kSingle, sum);
}
#endif

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
