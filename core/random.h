// Counter-based random numbers: number i of a stream is a function of (seed, stream, i) and of nothing else. Every user
// draws from streams of its own, so that what one does never changes what another one sees.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace roseau {

/// Finaliser of SplitMix64 (Steele, Lea, Flood 2014): a bijection that scatters every input bit over all output bits.
constexpr std::uint64_t scatter_bits(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15U;
  value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9U;
  value = (value ^ (value >> 27U)) * 0x94D049BB133111EBU;
  return value ^ (value >> 31U);
}

class RandomStream {
 public:
  constexpr RandomStream(std::uint64_t seed, std::uint64_t stream) : key_(scatter_bits(scatter_bits(seed) ^ stream)) {}

  constexpr std::uint64_t bits(std::uint64_t index) const { return scatter_bits(key_ + index * 0xD1B54A32D192ED03U); }

  /// In (0, 1): never 0, so that its logarithm exists.
  constexpr double uniform(std::uint64_t index) const { return (static_cast<double>(bits(index) >> 11U) + 0.5) * 0x1p-53; }
  constexpr double uniform(std::uint64_t index, double low, double high) const { return low + (high - low) * uniform(index); }

  /// Mean 0, standard deviation 1 (Box-Muller; uses the numbers 2 index and 2 index + 1 of this stream).
  double normal(std::uint64_t index) const {
    const double radius = std::sqrt(-2 * std::log(uniform(2 * index)));
    return radius * std::cos(2 * std::numbers::pi * uniform(2 * index + 1));
  }

 private:
  std::uint64_t key_;
};

}  // namespace roseau
