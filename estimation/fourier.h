// Fourier transforms of real series of any length (Eigen's FFT module behind one door, because its headers are heavy).
#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace roseau::estimation {

/// Bins 0 .. n/2 of sum_t y_t exp(-j 2 pi i t / n), unnormalised. Fast when n has small prime factors.
std::vector<std::complex<double>> real_fft(std::span<const double> series);

/// The real series of `length` samples whose real_fft is `bins` (length/2 + 1 of them).
std::vector<double> inverse_real_fft(std::span<const std::complex<double>> bins, std::size_t length);

/// Largest length <= n with no prime factor above 7; n >= 1.
std::size_t fast_length_at_most(std::size_t n);

/// Smallest length >= n with no prime factor above 7.
std::size_t fast_length_at_least(std::size_t n);

}  // namespace roseau::estimation
