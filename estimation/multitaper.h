// Multitaper power spectra with sine tapers (Riedel and Sidorenko, IEEE Trans. Signal Processing 43, 1995).
//
// A plain periodogram of a swaying tree is useless for damping: a random force gives every line exponential scatter, and the
// steep gust spectrum leaks over the resonance. Tapers cure the leakage, and averaging kTaperCount of them most of the scatter.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace roseau::estimation {

inline constexpr int kTaperCount = 4;

/// Two-sided power per bin: mean over the tapers of |DFT(taper * series)|^2 with tapers of unit energy, so that white noise of
/// variance s^2 gives s^2 in every bin. Bins 0 .. samples/2.
struct Spectrum {
  std::vector<double> power;
  std::size_t samples = 0;
  double sample_period_s = 0;

  double bin_hz() const { return 1.0 / (static_cast<double>(samples) * sample_period_s); }
  double duration_s() const { return static_cast<double>(samples) * sample_period_s; }
  /// One-sided density in unit^2 / Hz; white noise of variance s^2 has 2 T s^2.
  double density(std::size_t bin) const { return 2 * sample_period_s * power[bin]; }
};

/// Spectrum of the series as given (detrend first). At least 8 samples.
Spectrum multitaper_spectrum(std::span<const double> series, double sample_period_s, int tapers = kTaperCount);

/// What one sharp line looks like in that spectrum: the mean spectral window of the tapers at offsets of 1/oversampling bin,
/// from -half_width_bins to +half_width_bins, scaled to sum 1.
std::vector<double> taper_window(std::size_t samples, int half_width_bins, int oversampling, int tapers = kTaperCount);

/// Mean of each `factor` consecutive samples; samples left over at the START are not used, so that the newest always are.
std::vector<double> decimate(std::span<const double> series, std::size_t factor);

/// What decimate() by `factor` does to a component of angular frequency `radians_per_output_sample`: power gain.
double decimation_power_gain(std::size_t factor, double radians_per_output_sample);

/// The series without its mean and linear trend (least squares).
std::vector<double> detrend(std::span<const double> series);

}  // namespace roseau::estimation
