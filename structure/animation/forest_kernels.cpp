#include "structure/animation/forest_kernels.h"

// Vectors without a size known to the compiler cannot be kept in arrays, as the product does; such CPUs run the NEON code.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "structure/animation/forest_kernels.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/cache_control.h>
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace roseau::structure::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, kTile>;
using V = hn::Vec<Floats>;

// Accumulators fill the registers: 4 instances of 6 vectors where there are 32 of them, of 3 where there are 16.
#if HWY_TARGET <= HWY_AVX3 || HWY_ARCH_ARM
constexpr std::size_t kMostVectors = 6;
#else
constexpr std::size_t kMostVectors = 3;
#endif

void compute_drive_of_tile(const float* HWY_RESTRICT wind, const float* HWY_RESTRICT rotation, float* HWY_RESTRICT drive) {
  const Floats d;
  for (std::size_t lane = 0; lane < kTile; lane += hn::Lanes(d)) {
    const V x = hn::Load(d, wind + lane);
    const V y = hn::Load(d, wind + kTile + lane);
    const V z = hn::Load(d, wind + 2 * kTile + lane);
    const V speed = hn::Sqrt(hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float* row = rotation + 3 * axis * kTile + lane;
      const V along =
          hn::MulAdd(hn::Load(d, row), x, hn::MulAdd(hn::Load(d, row + kTile), y, hn::Mul(hn::Load(d, row + 2 * kTile), z)));
      const V wanted = hn::Mul(speed, along);
      float* value = drive + axis * kTile + lane;
      // Finite numbers alone give zero here.
      hn::Store(hn::IfThenElse(hn::Eq(hn::Sub(wanted, wanted), hn::Zero(d)), wanted, hn::Load(d, value)), d, value);
    }
  }
}

V dot3(const Floats d, const float* factors, const V x, const V y, const V z, V sum) {
  sum = hn::MulAdd(hn::Set(d, factors[0]), x, sum);
  sum = hn::MulAdd(hn::Set(d, factors[1]), y, sum);
  return hn::MulAdd(hn::Set(d, factors[2]), z, sum);
}

// A tree at rest in still air would end in numbers too small for the CPU's fast path.
V without_traces(const Floats d, const V value) {
  return hn::IfThenElseZero(hn::Gt(hn::Abs(value), hn::Set(d, 1e-20F)), value);
}

void step_modes_of_tile(const ModeStep* HWY_RESTRICT steps, std::size_t modes, const float* HWY_RESTRICT start,
                        const float* HWY_RESTRICT end, float* HWY_RESTRICT q, float* HWY_RESTRICT rate) {
  const Floats d;
  for (std::size_t lane = 0; lane < kTile; lane += hn::Lanes(d)) {
    const V sx = hn::Load(d, start + lane);
    const V sy = hn::Load(d, start + kTile + lane);
    const V sz = hn::Load(d, start + 2 * kTile + lane);
    const V ex = hn::Load(d, end + lane);
    const V ey = hn::Load(d, end + kTile + lane);
    const V ez = hn::Load(d, end + 2 * kTile + lane);
    for (std::size_t mode = 0; mode < modes; ++mode) {
      const ModeStep& step = steps[mode];
      const std::size_t at = mode * kTile + lane;
      const V q0 = hn::Load(d, q + at);
      const V r0 = hn::Load(d, rate + at);
      V dq = hn::MulAdd(hn::Set(d, step.q_less_one_from_q), q0, hn::Mul(hn::Set(d, step.q_from_rate), r0));
      V dr = hn::MulAdd(hn::Set(d, step.rate_less_one_from_rate), r0, hn::Mul(hn::Set(d, step.rate_from_q), q0));
      dq = dot3(d, step.q_from_start, sx, sy, sz, dq);
      dq = dot3(d, step.q_from_end, ex, ey, ez, dq);
      dr = dot3(d, step.rate_from_start, sx, sy, sz, dr);
      dr = dot3(d, step.rate_from_end, ex, ey, ez, dr);
      hn::Store(without_traces(d, hn::Add(q0, dq)), d, q + at);
      hn::Store(without_traces(d, hn::Add(r0, dr)), d, rate + at);
    }
  }
}

// The library's polynomial takes high powers of its argument, which are too small for the CPU's fast path where motion is
// small, as it mostly is: ten times slower. Small arguments get the series, and the library something harmless.
V arctan(const Floats d, const V x) {
  const V small = hn::Set(d, 0.1F);
  const V square = hn::Mul(x, x);
  V series = hn::MulAdd(square, hn::Set(d, -1.0F / 7), hn::Set(d, 1.0F / 5));
  series = hn::MulAdd(square, series, hn::Set(d, -1.0F / 3));
  series = hn::MulAdd(hn::Mul(square, series), x, x);
  const V magnitude = hn::Abs(x);
  return hn::IfThenElse(hn::Lt(magnitude, small), series, hn::CopySign(hn::Atan(d, hn::Max(magnitude, small)), x));
}

void correct_modes_of_tile(const ModeStep* HWY_RESTRICT steps, std::size_t modes, const float* HWY_RESTRICT q,
                           float* HWY_RESTRICT functions) {
  const Floats d;
  for (std::size_t mode = 0; mode < modes; ++mode) {
    const float b = steps[mode].b;
    float* out = functions + 2 * mode * kTile;
    for (std::size_t lane = 0; lane < kTile; lane += hn::Lanes(d)) {
      V s = hn::Load(d, q + mode * kTile + lane);
      if (b > 0) s = hn::Mul(arctan(d, hn::Mul(s, hn::Set(d, b))), hn::Set(d, 1 / b));
      hn::Store(s, d, out + lane);
      hn::Store(hn::Mul(s, s), d, out + kTile + lane);
    }
  }
}

// The product's heart: kVectors vectors of rows by kInstanceBlock instances.
template <std::size_t kVectors, bool kStreaming>
void multiply_block(const float* HWY_RESTRICT shapes, std::size_t shape_stride, const float* HWY_RESTRICT functions,
                    std::size_t function_count, float* HWY_RESTRICT out, std::size_t stride) {
  const Floats d;
  V sums[kInstanceBlock][kVectors];
#pragma GCC unroll 8
  for (auto& instance : sums) {
#pragma GCC unroll 8
    for (auto& sum : instance) sum = hn::Zero(d);
  }
  for (std::size_t f = 0; f < function_count; ++f, shapes += shape_stride, functions += kTile) {
    V rows[kVectors];
#pragma GCC unroll 8
    for (std::size_t v = 0; v < kVectors; ++v) rows[v] = hn::Load(d, shapes + v * hn::Lanes(d));
#pragma GCC unroll 8
    for (std::size_t i = 0; i < kInstanceBlock; ++i) {
      const V factor = hn::Set(d, functions[i]);
#pragma GCC unroll 8
      for (std::size_t v = 0; v < kVectors; ++v) sums[i][v] = hn::MulAdd(rows[v], factor, sums[i][v]);
    }
  }
#pragma GCC unroll 8
  for (std::size_t i = 0; i < kInstanceBlock; ++i) {
#pragma GCC unroll 8
    for (std::size_t v = 0; v < kVectors; ++v) {
      float* to = out + i * stride + v * hn::Lanes(d);
      if constexpr (kStreaming) {
        hn::Stream(sums[i][v], d, to);
      } else {
        hn::Store(sums[i][v], d, to);
      }
    }
  }
}

template <std::size_t kVectors, bool kStreaming>
void multiply_rows(const ShapePanel& panel, std::size_t row, std::size_t function_count, const TileRun& run,
                   float* HWY_RESTRICT out, std::size_t stride) {
  const float* functions = run.functions;
  for (std::size_t tile = 0; tile < run.tiles; ++tile, functions += function_count * kTile) {
    for (std::size_t i = 0; i < run.counts[tile]; i += kInstanceBlock) {
      multiply_block<kVectors, kStreaming>(panel.shapes + row, panel.rows, functions + i, function_count,
                                           out + i * stride + panel.first_row + row, stride);
    }
    out += run.counts[tile] * stride;
  }
}

template <bool kStreaming, std::size_t kVectors = kMostVectors>
void multiply_rows_of(std::size_t vectors, const ShapePanel& panel, std::size_t row, std::size_t function_count,
                      const TileRun& run, float* out, std::size_t stride) {
  if constexpr (kVectors > 0) {
    if (vectors == kVectors) return multiply_rows<kVectors, kStreaming>(panel, row, function_count, run, out, stride);
    multiply_rows_of<kStreaming, kVectors - 1>(vectors, panel, row, function_count, run, out, stride);
  }
}

void multiply_one_panel(const ShapePanel& panel, std::size_t function_count, const TileRun& run, float* out, std::size_t stride,
                        bool streaming) {
  const std::size_t lanes = hn::Lanes(Floats());
  for (std::size_t row = 0; row < panel.rows;) {
    const std::size_t left = (panel.rows - row) / lanes;
    const std::size_t vectors = left < kMostVectors ? left : kMostVectors;
    if (streaming) {
      multiply_rows_of<true>(vectors, panel, row, function_count, run, out, stride);
    } else {
      multiply_rows_of<false>(vectors, panel, row, function_count, run, out, stride);
    }
    row += vectors * lanes;
  }
}

void sum_gusts_of_points(const GustPhase* HWY_RESTRICT gusts, std::size_t gust_count, const float* HWY_RESTRICT east_m,
                         const float* HWY_RESTRICT north_m, std::size_t count, float* HWY_RESTRICT along,
                         float* HWY_RESTRICT across) {
  const Floats d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const V east = hn::Load(d, east_m + i);
    const V north = hn::Load(d, north_m + i);
    V sum_along = hn::Zero(d);
    V sum_across = hn::Zero(d);
    for (std::size_t g = 0; g < gust_count; ++g) {
      const GustPhase& gust = gusts[g];
      const V phase = hn::MulAdd(hn::Set(d, gust.east_per_m), east,
                                 hn::MulAdd(hn::Set(d, gust.north_per_m), north, hn::Set(d, gust.phase)));
      const V wave = hn::Sin(d, phase);
      sum_along = hn::MulAdd(hn::Set(d, gust.along), wave, sum_along);
      sum_across = hn::MulAdd(hn::Set(d, gust.across), wave, sum_across);
    }
    hn::Store(sum_along, d, along + i);
    hn::Store(sum_across, d, across + i);
  }
}

constexpr std::size_t kBurning = 4 * kMostVectors;  // as many accumulators as the product has

std::uint64_t burn_all(std::uint64_t rounds, float* sink) {
  const Floats d;
  V sums[kBurning];
  // Each starts elsewhere: the compiler would compute equal ones once.
#pragma GCC unroll 24
  for (std::size_t i = 0; i < kBurning; ++i) sums[i] = hn::Set(d, *sink + static_cast<float>(i));
  const V factor = hn::Set(d, 0.999F);
  for (std::uint64_t round = 0; round < rounds; ++round) {
#pragma GCC unroll 24
    for (auto& sum : sums) sum = hn::MulAdd(sum, factor, factor);
  }
  V total = hn::Zero(d);
  for (auto& sum : sums) total = hn::Add(total, sum);
  *sink = hn::GetLane(hn::SumOfLanes(d, total));
  return rounds * kBurning * hn::Lanes(d) * 2;
}

void fill_all(float* data, std::size_t count, float value, bool streaming) {
  const Floats d;
  const V values = hn::Set(d, value);
  if (streaming) {
    for (std::size_t i = 0; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) hn::Stream(values, d, data + i);
  } else {
    for (std::size_t i = 0; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) hn::Store(values, d, data + i);
  }
  hwy::FlushStream();
}

const char* name_of_target() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace roseau::structure::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace roseau::structure {

namespace {

HWY_EXPORT(compute_drive_of_tile);
HWY_EXPORT(step_modes_of_tile);
HWY_EXPORT(correct_modes_of_tile);
HWY_EXPORT(multiply_one_panel);
HWY_EXPORT(sum_gusts_of_points);
HWY_EXPORT(burn_all);
HWY_EXPORT(fill_all);
HWY_EXPORT(name_of_target);

}  // namespace

void compute_drive(const float* wind_mps, const float* tree_from_world, float* drive) {
  HWY_DYNAMIC_DISPATCH(compute_drive_of_tile)(wind_mps, tree_from_world, drive);
}

void step_modes(const ModeStep* steps, std::size_t modes, const float* start, const float* end, float* q, float* rate) {
  HWY_DYNAMIC_DISPATCH(step_modes_of_tile)(steps, modes, start, end, q, rate);
}

void correct_modes(const ModeStep* steps, std::size_t modes, const float* q, float* functions) {
  HWY_DYNAMIC_DISPATCH(correct_modes_of_tile)(steps, modes, q, functions);
}

void multiply_panel(const ShapePanel& panel, std::size_t function_count, const TileRun& run, float* out, std::size_t stride,
                    bool streaming) {
  HWY_DYNAMIC_DISPATCH(multiply_one_panel)(panel, function_count, run, out, stride, streaming);
}

void drain_streams() { hwy::FlushStream(); }

void sum_gusts(const GustPhase* gusts, std::size_t gust_count, const float* east_m, const float* north_m, std::size_t count,
               float* along, float* across) {
  HWY_DYNAMIC_DISPATCH(sum_gusts_of_points)(gusts, gust_count, east_m, north_m, count, along, across);
}

std::uint64_t burn_multiply_adds(std::uint64_t rounds, float* sink) { return HWY_DYNAMIC_DISPATCH(burn_all)(rounds, sink); }

void fill_memory(float* data, std::size_t count, float value, bool streaming) {
  HWY_DYNAMIC_DISPATCH(fill_all)(data, count, value, streaming);
}

const char* instruction_set() { return HWY_DYNAMIC_DISPATCH(name_of_target)(); }

}  // namespace roseau::structure
#endif
