// One target, on line: displacement in; identification, spectrum, wind and calibration out. Pure: what comes out follows from
// what went in, sample by sample. Identification runs inside add() (some milliseconds every hop), so that its result takes
// effect at a stated sample: the next one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/time.h"
#include "estimation/displacement_series.h"
#include "estimation/identify.h"
#include "estimation/latent_force_kalman.h"
#include "estimation/options.h"
#include "estimation/state_archive.h"
#include "estimation/wind_calibration.h"

namespace roseau::estimation {

/// Everything one displacement sample brought about. Identification, spectrum and calibration are as of that sample.
struct TargetOutput {
  struct TimedWind {
    HostTime sample_time;  // of the displacement sample `lag` earlier
    WindEstimate wind;
  };
  std::optional<Identification> identification;
  std::optional<ForceSpectrum> spectrum;
  std::optional<WindCalibration> calibration;
  std::vector<TimedWind> winds;
};

namespace detail {

// What the filter runs on: the last accepted identification.
struct TargetParameters {
  double natural_frequency_hz = 0;
  double natural_frequency_sd_hz = 0;
  double damping_ratio = 0;
  double damping_ratio_sd = 0;
  double noise_sd = 0;
  double static_sd = 0;
  double static_mean = 0;
  Vec2 axis;
  double duration_s = 0;
  std::int64_t accepted_ns = 0;

  template <class Archive>
  void archive(Archive& a) {
    a(natural_frequency_hz), a(natural_frequency_sd_hz), a(damping_ratio), a(damping_ratio_sd), a(noise_sd), a(static_sd);
    a(static_mean), a(axis.x), a(axis.y), a(duration_s), a(accepted_ns);
  }
};
// One accepted identification, for judging whether the frequency has stood still.
struct Hop {
  std::int64_t time_ns = 0;
  double frequency_hz = 0;
  double frequency_sd_hz = 0;

  template <class Archive>
  void archive(Archive& a) {
    a(time_ns), a(frequency_hz), a(frequency_sd_hz);
  }
};

}  // namespace detail

class TargetEstimator {
 public:
  /// `options` must outlive the estimator.
  explicit TargetEstimator(const EstimationOptions& options);

  /// One displacement sample, in order of time. Invalid ones count as missing: nothing is estimated from them. `reference` is
  /// the wind so far on `reference_topic`, or empty.
  TargetOutput add(HostTime time, const Displacement& displacement, const GridSeries& reference,
                   const std::string& reference_topic);

  double period_s() const { return series_.period_s(); }
  /// Calibration on everything so far, with confidence intervals from that many bootstrap replicates.
  Result<CalibrationFit> calibrate(const GridSeries& reference, int bootstrap_replicates) const;
  /// Direction the calibration in use is about; nothing while there is none.
  std::optional<double> direction_deg() const;

  void save(StateWriter& writer) const;
  /// False when the bytes are not what save() wrote; the estimator is then of no use.
  [[nodiscard]] bool load(StateReader& reader);

 private:
  using Parameters = detail::TargetParameters;
  using Hop = detail::Hop;

  template <class Self, class Archive>
  static void archive_parts(Self& self, Archive& a);
  double window_s() const;
  std::size_t frames_in(double seconds) const;
  void restart();
  void identify_now(TargetOutput& output);
  bool is_sudden(const OscillatorFit& fit);
  void lengthen_damping(const OscillatorFit& fit, Vec2 axis, Identification& result);
  void adopt(const OscillatorFit& fit, const Identification& result);
  LatentForceModel model() const;
  std::size_t lag_samples() const;
  void start_filter(std::size_t present);
  bool ends_hole(std::size_t index) const;
  void filter_frame(std::size_t index, TargetOutput* output);
  WindEstimate wind_estimate(const LatentForceKalman::Estimate& estimate, std::int64_t now_ns) const;
  void calibrate_now(std::int64_t now_ns, const GridSeries& reference, const std::string& topic, TargetOutput& output);
  WindCalibration calibration_sample(const CalibrationFit& fit, const std::string& topic) const;

  const EstimationOptions& options_;
  DisplacementSeries series_;
  double next_identification_s_;  // in the segment's own time
  std::optional<Parameters> parameters_;
  std::vector<Hop> hops_;
  std::optional<double> sudden_frequency_hz_;  // far from the one in use, seen once
  std::optional<LatentForceKalman> filter_;
  std::uint64_t warm_frames_ = 0;  // still to pass before the filter is believed
  GridSeries static_displacement_;
  std::optional<CalibrationFit> calibration_;
  std::int64_t next_calibration_ns_ = 0;
};

}  // namespace roseau::estimation
