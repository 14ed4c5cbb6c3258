#include "daemon/truth_judge.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <numeric>

#include "core/wind_geometry.h"
#include "daemon/topic_names.h"

namespace roseau::daemon {

namespace {

constexpr std::string_view kTruth = "/truth";
// A simulated frame and its truth carry the same time; imported truth may be rounded.
constexpr Duration kSameTime = std::chrono::milliseconds(2);
constexpr Duration kKeep = std::chrono::seconds(10);

ErrorFigures figures_of(std::vector<double> errors, bool about_mean) {
  ErrorFigures figures;
  figures.count = errors.size();
  if (errors.empty()) return figures;
  const auto n = static_cast<double>(errors.size());
  const double mean = about_mean ? std::accumulate(errors.begin(), errors.end(), 0.0) / n : 0;
  double squares = 0;
  for (double& error : errors) {
    error = std::abs(error - mean);
    squares += error * error;
  }
  std::ranges::sort(errors);
  figures.rms = std::sqrt(squares / n);
  figures.p95 = errors[static_cast<std::size_t>(0.95 * (n - 1))];
  figures.max = errors.back();
  return figures;
}

double rate_of(const StreamInfo& stream) {
  const auto rate = stream.metadata.find("rate_hz");
  const double rate_hz = rate == stream.metadata.end() ? 0 : std::strtod(rate->second.c_str(), nullptr);
  return rate_hz > 0 ? rate_hz : 20;
}

}  // namespace

void TruthJudge::see(const Sample& sample) {
  const std::string& topic = streams_.info(sample.header.stream).topic;
  see_sample_time(topic, sample);
  if (const auto* displacement = std::get_if<Displacement>(&sample.payload)) {
    see_displacement(topic, sample, *displacement);
  } else if (const auto* identification = std::get_if<Identification>(&sample.payload)) {
    see_identification(topic, *identification);
  } else if (const auto* wind = std::get_if<WindSample>(&sample.payload); wind != nullptr && topic == "/truth/wind") {
    see_truth_wind(sample, *wind);
  } else if (const auto* calibration = std::get_if<WindCalibration>(&sample.payload)) {
    if (const auto target = target_of_topic(topic, "calibration")) wind_direction_deg_[*target] = calibration->direction_deg;
  } else if (const auto* estimate = std::get_if<WindEstimate>(&sample.payload)) {
    see_wind_estimate(topic, sample, *estimate);
  }
}

void TruthJudge::see_sample_time(const std::string& topic, const Sample& sample) {
  const bool is_truth = topic.starts_with(kTruth);
  const std::string_view twin = std::string_view(topic).substr(is_truth ? kTruth.size() : 0);
  // A frame itself is gone by the time that anything is seen here; what was tracked in it has its times.
  const std::string_view ending = sample.kind() == SampleKind::wind ? "/wind" : is_truth ? "/exposure" : "/motion";
  const bool tells =
      sample.kind() == SampleKind::wind || sample.kind() == (is_truth ? SampleKind::clock_state : SampleKind::image_motion);
  if (!tells || !twin.ends_with(ending) || twin.size() <= ending.size()) return;
  const std::string device(twin.substr(1, twin.size() - 1 - ending.size()));
  auto known = sample_times_.find(device);
  if (is_truth && known == sample_times_.end()) {
    const Duration reach = from_seconds(0.5 / rate_of(streams_.info(sample.header.stream)));
    known = sample_times_.try_emplace(device, reach).first;
  }
  if (known == sample_times_.end()) return;
  if (is_truth) {
    known->second.truth(sample.header.sample_time);
  } else {
    known->second.sample(sample.header.sample_time);
  }
}

void TruthJudge::see_displacement(const std::string& topic, const Sample& sample, const Displacement& displacement) {
  const bool is_truth = topic.starts_with(kTruth);
  const auto target = target_of_topic(is_truth ? std::string_view(topic).substr(kTruth.size()) : topic, "displacement");
  if (!target || !displacement.valid) return;
  for (const auto& [axis, value] : {std::pair("x", displacement.x), std::pair("y", displacement.y)}) {
    Pair& pair = pairs_["displacement_" + std::string(axis) + "/" + *target];
    pair.about_mean = true;
    pair.unit = to_string(displacement.unit);
    pair_up(pair, sample.header.sample_time, value, is_truth);
  }
}

void TruthJudge::pair_up(Pair& pair, HostTime time, double value, bool is_truth) {
  auto& mine = is_truth ? pair.truth : pair.estimates;
  auto& theirs = is_truth ? pair.estimates : pair.truth;
  const auto partner = std::ranges::find_if(
      theirs, [time](const TimedValue& other) { return std::chrono::abs(other.time - time) <= kSameTime; });
  if (partner == theirs.end()) {
    mine.push_back({time, value});
  } else {
    pair.errors.push_back(is_truth ? partner->value - value : value - partner->value);
    theirs.erase(partner);
  }
  const auto is_old = [time](const TimedValue& other) { return other.time < time - kKeep; };
  std::erase_if(mine, is_old);
  std::erase_if(theirs, is_old);
}

void TruthJudge::see_identification(const std::string& topic, const Identification& identification) {
  if (constexpr std::string_view kPrefix = "/truth/target/"; topic.starts_with(kPrefix)) {
    const auto name = topic.substr(kPrefix.size());
    true_frequency_hz_[name.substr(0, name.find('/'))] = identification.natural_frequency_hz;
    return;
  }
  const auto target = target_of_topic(topic, "identification");
  if (!target || !identification.accepted) return;
  const auto truth = true_frequency_hz_.find(target->substr(target->find('/') + 1));
  if (truth == true_frequency_hz_.end()) return;
  Pair& pair = pairs_["natural_frequency/" + *target];
  pair.unit = "Hz";
  pair.errors.push_back(identification.natural_frequency_hz - truth->second);
}

void TruthJudge::see_truth_wind(const Sample& sample, const WindSample& wind) {
  const auto& metadata = streams_.info(sample.header.stream).metadata;
  if (const auto offset = metadata.find("north_offset_deg"); offset != metadata.end()) {
    true_wind_north_offset_deg_ = std::strtod(offset->second.c_str(), nullptr);
  }
  true_wind_.push_back({sample.header.sample_time, wind});
  std::erase_if(true_wind_, [&sample](const TimedWind& other) { return other.time < sample.header.sample_time - kKeep; });
}

std::optional<double> TruthJudge::true_wind_at(HostTime time, double direction_deg) const {
  const auto after = std::ranges::find_if(true_wind_, [time](const TimedWind& other) { return other.time >= time; });
  if (after == true_wind_.end() || after == true_wind_.begin()) return std::nullopt;
  const TimedWind& before = *(after - 1);
  const double share = to_seconds(time - before.time) / to_seconds(after->time - before.time);
  const double u = std::lerp(before.wind.u_mps, after->wind.u_mps, share);
  const double v = std::lerp(before.wind.v_mps, after->wind.v_mps, share);
  const double from_deg = wind_direction_deg(u, v, true_wind_north_offset_deg_);
  return std::hypot(u, v) * std::cos((from_deg - direction_deg) * std::numbers::pi / 180);
}

void TruthJudge::see_wind_estimate(const std::string& topic, const Sample& sample, const WindEstimate& estimate) {
  const auto target = target_of_topic(topic, "wind");
  if (!target || !estimate.accepted || !estimate.scale_known) return;
  const auto direction = wind_direction_deg_.find(*target);
  if (direction == wind_direction_deg_.end()) return;
  const auto truth = true_wind_at(sample.header.sample_time, direction->second);
  if (!truth || !std::isfinite(estimate.wind_mps)) return;
  Pair& pair = pairs_["wind/" + *target];
  pair.unit = "m/s";
  pair.errors.push_back(estimate.wind_mps - *truth);
}

std::map<std::string, ErrorFigures> TruthJudge::figures() const {
  std::map<std::string, ErrorFigures> figures;
  for (const auto& [quantity, pair] : pairs_) {
    if (pair.errors.empty()) continue;
    figures[quantity] = figures_of(pair.errors, pair.about_mean);
    figures[quantity].unit = pair.unit;
  }
  for (const auto& [device, times] : sample_times_) {
    if (times.errors_s().empty()) continue;
    figures["clock/" + device] = figures_of(times.errors_s(), false);
    figures["clock/" + device].unit = "s";
  }
  return figures;
}

}  // namespace roseau::daemon
