#include "estimation/fourier.h"

#include <unsupported/Eigen/FFT>

#include "core/check.h"

namespace roseau::estimation {

namespace {

bool is_fast(std::size_t n) {
  for (const std::size_t factor : {2U, 3U, 5U, 7U}) {
    while (n % factor == 0) n /= factor;
  }
  return n == 1;
}

Eigen::FFT<double> half_spectrum_fft() {
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  return fft;
}

}  // namespace

std::vector<std::complex<double>> real_fft(std::span<const double> series) {
  ROSEAU_CHECK(!series.empty());
  std::vector<std::complex<double>> bins(series.size() / 2 + 1);
  half_spectrum_fft().fwd(bins.data(), series.data(), static_cast<Eigen::Index>(series.size()));
  return bins;
}

std::vector<double> inverse_real_fft(std::span<const std::complex<double>> bins, std::size_t length) {
  ROSEAU_CHECK(length > 0 && bins.size() == length / 2 + 1);
  std::vector<double> series(length);
  half_spectrum_fft().inv(series.data(), bins.data(), static_cast<Eigen::Index>(length));
  return series;
}

std::size_t fast_length_at_most(std::size_t n) {
  ROSEAU_CHECK(n >= 1);
  while (!is_fast(n)) --n;
  return n;
}

std::size_t fast_length_at_least(std::size_t n) {
  if (n < 1) return 1;
  while (!is_fast(n)) ++n;
  return n;
}

}  // namespace roseau::estimation
