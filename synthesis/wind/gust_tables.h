// GustTables: periodic series of turbulence, three components each, made in the frequency domain and read at any time.
//
// The tables hold coefficients of cubic B-splines, 32 a second, made from spectra that are divided by the spline's own: so the
// series read from them have the spectrum that was asked for, up to 12.8 Hz, and not one that interpolation has smoothed.
// Above 12.8 Hz there is what the spline leaves of their images: -14 dB at 19.2 Hz (of 12.8 Hz), -27 dB at 22 Hz (of 10 Hz).
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace roseau::synthesis {

inline constexpr double kGustRateHz = 32;
inline constexpr double kHighestGustHz = 0.4 * kGustRateHz;

class GustTables {
 public:
  enum Component : std::uint8_t { along, across, up };
  static constexpr std::size_t kComponents = 3;

  /// One coefficient of the three components, in steps of 10 sd / 32767: 83 dB below the turbulence is its rounding.
  struct Entry {
    std::array<std::int16_t, 4> counts{};
  };

  /// Size and bytes of one strand's table. The period is lengthened a little to a size that can be transformed fast (of factors
  /// 2, 3 and 5 only): period_s() is the true one.
  static std::size_t size_for(double period_s);
  static std::size_t bytes_per_table(double period_s);

  /// `strands` tables, then `fillers` tables that hold their period twice, so that they can also be read any part of a
  /// period later.
  GustTables(std::size_t strands, std::size_t fillers, double period_s, const std::array<double, kComponents>& sd_mps);

  /// Harmonics of the period, the highest one below kHighestGustHz; number k has the frequency k / period.
  std::size_t harmonics() const { return harmonics_; }
  double period_s() const { return period_s_; }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return entries_.size() * sizeof(Entry); }

  /// Fills one component of tables first, first + 1 ...: `amplitudes` has a row for each, of harmonics() values for the
  /// harmonics 1, 2, ...; harmonic k then is real cos + imaginary sin, in m/s. Not safe to call for one component from two
  /// threads.
  void make(Component component, std::size_t first, std::span<const std::complex<float>> amplitudes);

  /// Table `table` starts so many entries after entries(). Four neighbouring entries, weighted with the cubic B-spline's
  /// weights for `share`, are its value at the first one + share; there is a fourth for each of the size() + 1 first.
  const Entry* entries() const { return entries_.data(); }
  std::uint32_t start(std::size_t table) const { return static_cast<std::uint32_t>(starts_[table]); }
  /// From counts to m/s, by component; the fourth is 0.
  const std::array<float, 4>& to_mps() const { return to_mps_; }

 private:
  std::size_t size_;
  double period_s_;
  std::size_t harmonics_;
  std::array<float, 4> to_mps_{};
  std::vector<float> sharpening_;    // of each harmonic: 1 / what the spline leaves of it
  std::vector<std::size_t> starts_;  // of each table, and where the last one ends
  std::vector<Entry> entries_;
};

}  // namespace roseau::synthesis
