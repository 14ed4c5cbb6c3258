#include "estimation/trust_band.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roseau::estimation {

namespace {

constexpr std::size_t kLowestLine = 3;  // below it the trend that was taken out is missing

double smoothed_density(const Spectrum& spectrum, std::size_t line) {
  const std::size_t first = line < 2 ? 0 : line - 2;
  const std::size_t last = std::min(line + 2, spectrum.power.size() - 1);
  double sum = 0;
  for (std::size_t i = first; i <= last; ++i) sum += spectrum.density(i);
  return sum / static_cast<double>(last - first + 1);
}

}  // namespace

double squared_response(double natural_frequency_hz, double damping_ratio, double frequency_hz) {
  const double w0 = 2 * std::numbers::pi * natural_frequency_hz;
  const double w = 2 * std::numbers::pi * frequency_hz;
  const double detuning = w0 * w0 - w * w;
  const double gamma = 2 * damping_ratio * w0;
  return 1 / (detuning * detuning + gamma * gamma * w * w);
}

double white_noise_force_density(double noise_sd, double sample_period_s, double natural_frequency_hz, double damping_ratio,
                                 double frequency_hz) {
  return 2 * sample_period_s * noise_sd * noise_sd / squared_response(natural_frequency_hz, damping_ratio, frequency_hz);
}

TrustBand trust_band(const OscillatorFit& fit, double ratio) {
  const Spectrum& spectrum = fit.spectrum;
  const double wanted = ratio * fit.noise_density();
  const auto trusted = [&](std::size_t line) { return smoothed_density(spectrum, line) >= wanted; };
  const auto resonance = static_cast<std::size_t>(std::lround(fit.natural_frequency_hz / spectrum.bin_hz()));
  if (resonance >= spectrum.power.size() || !trusted(resonance)) return {};
  std::size_t low = resonance;
  while (low > kLowestLine && trusted(low - 1)) --low;
  std::size_t high = resonance;
  while (high + 1 < spectrum.power.size() && trusted(high + 1)) ++high;
  return {low <= kLowestLine ? 0 : static_cast<double>(low) * spectrum.bin_hz(), static_cast<double>(high) * spectrum.bin_hz()};
}

ForceSpectrum force_spectrum(const OscillatorFit& fit, double ratio) {
  ForceSpectrum result;
  const TrustBand band = trust_band(fit, ratio);
  result.trust_low_hz = static_cast<float>(band.low_hz);
  result.trust_high_hz = static_cast<float>(band.high_hz);
  for (std::size_t line = 1; line < fit.spectrum.power.size(); ++line) {
    const double hz = static_cast<double>(line) * fit.spectrum.bin_hz();
    const double response = squared_response(fit.natural_frequency_hz, fit.damping_ratio, hz);
    result.frequency_hz.push_back(static_cast<float>(hz));
    result.displacement_power.push_back(static_cast<float>(fit.spectrum.density(line)));
    result.model_power.push_back(static_cast<float>(fit.model_density(hz)));
    result.force_power.push_back(static_cast<float>(fit.spectrum.density(line) / response));
    result.force_noise_power.push_back(static_cast<float>(fit.noise_density() / response));
  }
  return result;
}

}  // namespace roseau::estimation
