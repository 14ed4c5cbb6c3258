// Complex amplitudes of turbulence on many strands at once: Gaussian, each strand with the stated power, any two of them with
// the stated coherence.
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "synthesis/wind/coherence.h"

namespace roseau::synthesis {

/// One row per place (x lateral, y height; metres): harmonic k = 1, 2, ... has `amplitude[k - 1]` as standard deviation of its
/// real and of its imaginary part. Cholesky factors of the coherence are made on a grid of frequencies, 3 % apart (an error of
/// at most 0.6 % in coherence), until no two strands share anything.
std::vector<std::complex<float>> coherent_amplitudes(std::span<const Vec2> places, const DavenportCoherence& coherence,
                                                     std::span<const float> amplitude, double period_s, std::uint64_t seed);

/// One row, number `row`, independent of all others: what interpolation loses between places that are `separation_s` apart.
std::vector<std::complex<float>> lost_amplitudes(double separation_s, const DavenportCoherence& coherence,
                                                 std::span<const float> amplitude, double period_s, std::uint64_t seed,
                                                 std::uint64_t row);

}  // namespace roseau::synthesis
