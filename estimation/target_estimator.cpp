#include "estimation/target_estimator.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "estimation/fourier.h"
#include "estimation/multitaper.h"
#include "estimation/trust_band.h"

namespace roseau::estimation {

namespace {

constexpr double kEarlyHop_s = 5;          // between attempts until twice the first window has passed
constexpr double kSameFrequency = 3;       // standard deviations
constexpr double kSuddenChange = 0.15;     // of the frequency from one hop to the next: must be seen twice
constexpr double kSameAxisCosine = 0.985;  // 10 degrees
constexpr double kWarm_s = 5;              // of recorded displacement a new filter is run over before it is believed
constexpr double kWarmPeriods = 3;
constexpr double kSlowest_hz = 0.2;  // the force's spread is measured below this, well under the resonance
constexpr double kBelowResonance = 2.5;
constexpr double kUsefulCorrelation = 0.5;  // a calibration that explains less is reported, not used

double square(double x) { return x * x; }

// Standard deviation of a series below a frequency, its mean's neighbourhood included.
double slow_sd(const std::vector<double>& series, double period_s, double cut_hz) {
  const auto factor = static_cast<std::size_t>(std::max(1.0, std::floor(0.1 / (period_s * cut_hz))));
  std::vector<double> slow = decimate(series, factor);
  if (slow.size() < 4) return 0;
  const double mean = std::accumulate(slow.begin(), slow.end(), 0.0) / static_cast<double>(slow.size());
  for (double& value : slow) value -= mean;
  const auto bins = real_fft(slow);
  const auto count = static_cast<double>(slow.size());
  double variance = 0;
  for (std::size_t i = 1; i < bins.size(); ++i) {
    if (static_cast<double>(i) / (count * period_s * static_cast<double>(factor)) > cut_hz) break;
    variance += 2 * std::norm(bins[i]) / (count * count);
  }
  return std::sqrt(variance);
}

Identification to_sample(const OscillatorFit& fit, Vec2 axis) {
  Identification result;
  result.natural_frequency_hz = fit.natural_frequency_hz;
  result.natural_frequency_sd_hz = fit.natural_frequency_sd_hz;
  result.damping_ratio = fit.damping_ratio;
  result.damping_ratio_sd = fit.damping_ratio_sd;
  result.noise_sd = fit.noise_sd;
  result.force_slope = fit.force_slope;
  result.peak_to_floor = fit.peak_to_floor;
  result.axis = axis;
  result.window_s = fit.duration_s;
  result.accepted = fit.accepted;
  return result;
}

}  // namespace

TargetEstimator::TargetEstimator(const EstimationOptions& options)
    : options_(options),
      series_(options.max_gap_s),
      next_identification_s_(options.first_window_s),
      static_displacement_(options.calibration.max_duration_s) {}

double TargetEstimator::window_s() const {
  if (!parameters_) return options_.window_s;
  return std::max(options_.window_s, options_.window_periods / parameters_->natural_frequency_hz);
}

std::size_t TargetEstimator::frames_in(double seconds) const {
  return static_cast<std::size_t>(std::llround(seconds / series_.period_s()));
}

TargetOutput TargetEstimator::add(HostTime time, const Displacement& displacement, const GridSeries& reference,
                                  const std::string& reference_topic) {
  TargetOutput output;
  const Vec2 at{displacement.x, displacement.y};
  if (!displacement.valid || !std::isfinite(at.x) || !std::isfinite(at.y)) return output;
  const auto added = series_.add(time, at);
  if (added == DisplacementSeries::Added::nothing) return output;
  if (added == DisplacementSeries::Added::restarted) restart();

  const std::size_t count = series_.frames().size();
  for (std::size_t i = count - series_.appended_count(); filter_ && i < count; ++i) filter_frame(i, &output);
  if (series_.segment_s() >= next_identification_s_) {
    identify_now(output);
    const bool is_early = series_.segment_s() < 2 * options_.first_window_s;
    next_identification_s_ = series_.segment_s() + (is_early ? std::min(kEarlyHop_s, options_.hop_s) : options_.hop_s);
    series_.keep_newest(frames_in(std::max(options_.damping_window_s, window_s())));
  }
  if (to_ns(time) >= next_calibration_ns_) calibrate_now(to_ns(time), reference, reference_topic, output);
  return output;
}

// After a hole the parameters still hold; everything that depends on what came just before does not.
void TargetEstimator::restart() {
  next_identification_s_ = options_.first_window_s;
  hops_.clear();
  sudden_frequency_hz_.reset();
  filter_.reset();
  if (parameters_) start_filter(0);
}

void TargetEstimator::identify_now(TargetOutput& output) {
  series_.refine_period();
  const std::size_t count = std::min(series_.frames().size(), frames_in(window_s()));
  Vec2 axis = main_axis(series_, count, parameters_ ? &parameters_->axis : nullptr);
  if (parameters_ && axis.x * parameters_->axis.x + axis.y * parameters_->axis.y > kSameAxisCosine) axis = parameters_->axis;

  const auto fit = identify(series_.along(axis, count), series_.period_s(), options_.identification);
  if (!fit) {
    output.identification = Identification{.axis = axis, .window_s = static_cast<double>(count) * series_.period_s()};
    return;
  }
  Identification result = to_sample(*fit, axis);
  output.spectrum = force_spectrum(*fit);
  if (result.accepted && is_sudden(*fit)) result.accepted = false;
  if (result.accepted) {
    const std::int64_t now_ns = series_.frames().back().time_ns;
    hops_.push_back({now_ns, fit->natural_frequency_hz, fit->natural_frequency_sd_hz});
    lengthen_damping(*fit, axis, result);
    adopt(*fit, result);
  }
  output.identification = result;
}

// A frequency far from the one in use is believed when the next hop confirms it: a gust or another branch passing through the
// picture must not throw the filter off.
bool TargetEstimator::is_sudden(const OscillatorFit& fit) {
  const auto is_far = [&](double other_hz) {
    const double spread = 4 * fit.natural_frequency_sd_hz / fit.natural_frequency_hz;
    return std::abs(std::log(fit.natural_frequency_hz / other_hz)) > std::max(kSuddenChange, spread);
  };
  if (!parameters_ || !is_far(parameters_->natural_frequency_hz)) {
    sudden_frequency_hz_.reset();
    return false;
  }
  if (sudden_frequency_hz_ && !is_far(*sudden_frequency_hz_)) {
    sudden_frequency_hz_.reset();
    hops_.clear();
    return false;
  }
  sudden_frequency_hz_ = fit.natural_frequency_hz;
  return true;
}

// Damping needs far more data than frequency: sd(g)/g = sqrt(2/(g D)). It rests on the longest stretch over which the frequency
// has stood still.
void TargetEstimator::lengthen_damping(const OscillatorFit& fit, Vec2 axis, Identification& result) {
  const std::int64_t oldest_ns = hops_.back().time_ns - from_seconds(options_.damping_window_s).count();
  std::erase_if(hops_, [&](const Hop& hop) { return hop.time_ns < oldest_ns; });
  double stable_s = fit.duration_s;
  for (auto hop = hops_.rbegin(); hop != hops_.rend(); ++hop) {
    const double spread = std::hypot(hop->frequency_sd_hz, fit.natural_frequency_sd_hz);
    if (std::abs(hop->frequency_hz - fit.natural_frequency_hz) > kSameFrequency * spread) break;
    stable_s = fit.duration_s + static_cast<double>(hops_.back().time_ns - hop->time_ns) * 1e-9;
  }
  const std::size_t count = std::min(frames_in(std::min(stable_s, options_.damping_window_s)), series_.frames().size());
  if (static_cast<double>(count) * series_.period_s() < 1.5 * fit.duration_s) return;
  IdentifyOptions narrow = options_.identification;
  narrow.min_frequency_hz = fit.natural_frequency_hz / 1.25;
  narrow.max_frequency_hz = fit.natural_frequency_hz * 1.25;
  narrow.start_damping_ratios = {result.damping_ratio};
  const auto longer = identify(series_.along(axis, count), series_.period_s(), narrow);
  if (!longer || !longer->accepted) return;
  if (std::abs(longer->natural_frequency_hz - fit.natural_frequency_hz) > kSameFrequency * fit.natural_frequency_sd_hz) return;
  result.damping_ratio = longer->damping_ratio;
  result.damping_ratio_sd = longer->damping_ratio_sd;
}

void TargetEstimator::adopt(const OscillatorFit& fit, const Identification& result) {
  const auto& newest = series_.frames().back();
  if (parameters_) {
    // A short window after a hole does not replace what a long one found, until that has grown old.
    const double age_s = static_cast<double>(newest.time_ns - parameters_->accepted_ns) * 1e-9;
    if (fit.duration_s < 0.9 * std::min(parameters_->duration_s, window_s()) && age_s < options_.hold_s) return;
  }
  const bool is_new_axis = !parameters_ || result.axis.x != parameters_->axis.x || result.axis.y != parameters_->axis.y;
  const auto along = series_.along(result.axis, series_.frames().size());
  const double cut_hz = std::min(kSlowest_hz, fit.natural_frequency_hz / kBelowResonance);
  Parameters next;
  next.natural_frequency_hz = result.natural_frequency_hz;
  next.natural_frequency_sd_hz = result.natural_frequency_sd_hz;
  next.damping_ratio = result.damping_ratio;
  next.damping_ratio_sd = result.damping_ratio_sd;
  next.noise_sd = result.noise_sd;
  next.static_mean = std::accumulate(along.begin(), along.end(), 0.0) / static_cast<double>(along.size());
  next.static_sd = std::max(slow_sd(along, series_.period_s(), cut_hz), 0.1 * result.noise_sd + 1e-12);
  next.axis = result.axis;
  next.duration_s = fit.duration_s;
  next.accepted_ns = newest.time_ns;
  parameters_ = next;
  if (is_new_axis) static_displacement_.clear();
  if (filter_ && !is_new_axis && lag_samples() == filter_->lag_samples()) {
    filter_->set_model(model());
  } else {
    start_filter(series_.frames().size());
  }
}

LatentForceModel TargetEstimator::model() const {
  LatentForceModel model;
  model.natural_frequency_hz = parameters_->natural_frequency_hz;
  model.damping_ratio = parameters_->damping_ratio;
  model.sample_period_s = series_.period_s();
  model.noise_sd = parameters_->noise_sd;
  model.static_sd = parameters_->static_sd;
  model.static_mean = parameters_->static_mean;
  model.correlation_time_s = options_.correlation_time_s;
  return model;
}

// A quarter period is where more lag stops helping. The lag in use stays until the frequency has moved by a fifth.
std::size_t TargetEstimator::lag_samples() const {
  const auto frames_for = [this](double seconds) {
    return static_cast<std::size_t>(std::ceil(seconds / series_.period_s() - 1e-3));
  };
  if (options_.lag_s) return frames_for(*options_.lag_s);
  const auto lag_for = [&](double hz) { return frames_for(hz >= 1 ? 0.25 : std::max(0.5, 0.25 / hz)); };
  const double hz = parameters_->natural_frequency_hz;
  if (filter_ && filter_->lag_samples() >= lag_for(hz * 1.2) && filter_->lag_samples() <= lag_for(hz / 1.2)) {
    return filter_->lag_samples();
  }
  return lag_for(hz);
}

// A new filter is run over the frames that are there before it is believed: over all of them when calibration has nothing yet,
// so that it can begin with what was seen before the first identification.
void TargetEstimator::start_filter(std::size_t present) {
  filter_.reset();
  const std::size_t lag = lag_samples();
  filter_.emplace(model(), lag);
  const double warm_s = std::max(kWarm_s, kWarmPeriods / parameters_->natural_frequency_hz);
  warm_frames_ = frames_in(warm_s) + lag;
  const bool has_history = static_displacement_.end() > static_displacement_.first();
  std::size_t first = has_history ? present - std::min<std::size_t>(present, warm_frames_) : 0;
  while (!series_.frames()[first].measured) --first;  // the first frame of all is a measured one
  const auto& frame = series_.frames()[first];
  filter_->start(parameters_->axis.x * frame.at.x + parameters_->axis.y * frame.at.y);
  for (std::size_t i = first; i < present; ++i) filter_frame(i, nullptr);
}

// A single missing frame does no harm: the prediction bridges it.
bool TargetEstimator::ends_hole(std::size_t index) const {
  const auto& frames = series_.frames();
  return index >= 2 && !frames[index - 1].measured && !frames[index - 2].measured;
}

void TargetEstimator::filter_frame(std::size_t index, TargetOutput* output) {
  const auto& frame = series_.frames()[index];
  const double along = parameters_->axis.x * frame.at.x + parameters_->axis.y * frame.at.y;
  const auto estimate = filter_->step(frame.measured ? std::optional(along) : std::nullopt);
  // Steady-state gains take the first samples behind a hole for news of the force, where they are news of the state: until
  // that error is gone, no estimate is better than a wrong one.
  if (frame.measured && ends_hole(index)) {
    warm_frames_ = std::max(warm_frames_, filter_->gains().settling_samples + filter_->lag_samples());
  }
  if (warm_frames_ > 0) {
    --warm_frames_;
    return;
  }
  if (!estimate || index < filter_->lag_samples()) return;
  const auto& then = series_.frames()[index - filter_->lag_samples()];
  if (!then.measured) return;
  static_displacement_.add(host_time_from_ns(then.time_ns), {estimate->static_displacement, 0});
  if (output != nullptr) output->winds.push_back({host_time_from_ns(then.time_ns), wind_estimate(*estimate, frame.time_ns)});
}

WindEstimate TargetEstimator::wind_estimate(const LatentForceKalman::Estimate& estimate, std::int64_t now_ns) const {
  const Parameters& used = *parameters_;
  WindEstimate result;
  result.force_per_mass = estimate.force_per_mass;
  result.force_per_mass_sd = estimate.force_per_mass_sd;
  result.lag_s = static_cast<double>(filter_->lag_samples()) * series_.period_s();
  result.accepted = static_cast<double>(now_ns - used.accepted_ns) * 1e-9 <= options_.hold_s;
  result.settling = used.natural_frequency_sd_hz > options_.settled_frequency_sd * used.natural_frequency_hz ||
                    used.damping_ratio_sd > options_.settled_damping_sd * used.damping_ratio ||
                    (calibration_ && calibration_->seconds_used < options_.settled_calibration_s);
  result.scale_known = calibration_.has_value();
  if (calibration_) {
    result.wind_mps = calibration_->wind_mps(estimate.static_displacement);
    result.wind_sd_mps = calibration_->wind_sd_mps(estimate.static_displacement, estimate.sd);
  } else {
    const auto wind = [&](double lean) { return options_.uncalibrated_scale * signed_power(lean, 0.5); };
    result.wind_mps = wind(estimate.static_displacement);
    result.wind_sd_mps =
        (wind(estimate.static_displacement + estimate.sd) - wind(estimate.static_displacement - estimate.sd)) / 2;
  }
  return result;
}

Result<CalibrationFit> TargetEstimator::calibrate(const GridSeries& reference, int bootstrap_replicates) const {
  CalibrationOptions options = options_.calibration;
  options.bootstrap_replicates = bootstrap_replicates;
  return calibrate_wind(static_displacement_, reference, options);
}

std::optional<double> TargetEstimator::direction_deg() const {
  return calibration_ ? std::optional(calibration_->direction_deg) : std::nullopt;
}

void TargetEstimator::calibrate_now(std::int64_t now_ns, const GridSeries& reference, const std::string& topic,
                                    TargetOutput& output) {
  next_calibration_ns_ = now_ns + from_seconds(options_.calibration_interval_s * (calibration_ ? 1 : 0.5)).count();
  if (calibration_ && options_.calibration_final_after_s && calibration_->seconds_used >= *options_.calibration_final_after_s)
    return;
  if (!parameters_ || topic.empty()) return;
  const auto fit = calibrate_wind(static_displacement_, reference, options_.calibration);
  if (!fit) return;
  output.calibration = calibration_sample(*fit, topic);
  if (fit->correlation >= kUsefulCorrelation) calibration_ = *fit;
}

WindCalibration TargetEstimator::calibration_sample(const CalibrationFit& fit, const std::string& topic) const {
  WindCalibration result;
  result.reference = topic;
  // The fit is in static displacement u; force per mass is w0^2 u.
  result.gain = fit.gain / square(2 * std::numbers::pi * parameters_->natural_frequency_hz);
  result.offset = fit.offset;
  result.exponent = fit.exponent;
  result.delay_s = fit.delay_s;
  result.direction_deg = fit.direction_deg;
  result.explained = fit.explained.value_or(kNotMeasured);
  result.correlation = fit.correlation;
  result.rms_mps = fit.rms_mps;
  result.seconds_used = fit.seconds_used;
  return result;
}

template <class Self, class Archive>
void TargetEstimator::archive_parts(Self& self, Archive& a) {
  a(self.series_), a(self.next_identification_s_), a(self.parameters_), a(self.hops_), a(self.sudden_frequency_hz_);
  a(self.warm_frames_), a(self.static_displacement_), a(self.calibration_), a(self.next_calibration_ns_);
}

void TargetEstimator::save(StateWriter& writer) const {
  archive_parts(*this, writer);
  writer(filter_.has_value());
  if (!filter_) return;
  writer(static_cast<std::uint64_t>(filter_->lag_samples()));
  writer(filter_->model());
  writer(filter_->state());
}

bool TargetEstimator::load(StateReader& reader) {
  archive_parts(*this, reader);
  bool has_filter = false;
  reader(has_filter);
  filter_.reset();
  if (!reader.ok() || !has_filter) return reader.ok();
  std::uint64_t lag = 0;
  LatentForceModel model;
  LatentForceKalman::State state;
  reader(lag);
  reader(model);
  reader(state);
  const bool is_sane = reader.ok() && parameters_ && lag < 1'000'000 && model.natural_frequency_hz > 0 &&
                       model.damping_ratio > 0 && model.sample_period_s > 0 && model.static_sd > 0 &&
                       model.correlation_time_s > 0;
  if (!is_sane) return false;
  filter_.emplace(model, lag);
  return filter_->restore(std::move(state));
}

}  // namespace roseau::estimation
