#include "estimation/estimation_stage.h"

#include <charconv>
#include <cmath>
#include <utility>

#include "estimation/state_archive.h"

namespace roseau::estimation {

namespace {

constexpr std::string_view kTracked = "/displacement";
constexpr std::string_view kImported = "/displacement/";
constexpr std::string_view kTruth = "/truth/";
constexpr std::uint32_t kStateVersion = 1;

constexpr std::uint16_t kUnusable =
    kStatusDuplicate | kStatusBadChecksum | kStatusMalformed | kStatusDeviceError | kStatusIncomplete;

struct Mounting {
  double north_offset_deg = 0;
  WindAxes axes = WindAxes::gill_spar;
};

Mounting mounting_of(const StreamInfo& info) {
  Mounting mounting;
  if (const auto found = info.metadata.find("north_offset_deg"); found != info.metadata.end()) {
    const std::string& text = found->second;
    std::from_chars(text.data(), text.data() + text.size(), mounting.north_offset_deg);
  }
  if (const auto found = info.metadata.find("axes"); found != info.metadata.end()) {
    if (const auto axes = wind_axes_from_string(found->second)) mounting.axes = *axes;
  }
  return mounting;
}

}  // namespace

bool is_displacement_topic(std::string_view topic) {
  if (topic.starts_with(kTruth)) return false;
  return topic.starts_with(kImported) || (topic.ends_with(kTracked) && topic.size() > kTracked.size());
}

std::string result_topic(std::string_view displacement_topic, std::string_view result) {
  std::string_view base = displacement_topic;
  if (!base.starts_with(kImported)) base.remove_suffix(kTracked.size());
  return std::string(base) + "/" + std::string(result);
}

EstimationStage::EstimationStage(StreamTable& streams, EstimationOptions options)
    : streams_(streams),
      options_(std::move(options)),
      reference_topic_(options_.reference_topic),
      reference_(options_.calibration.max_duration_s) {}

void EstimationStage::process(const Sample& input, SampleSink& out) {
  if (const auto* wind = std::get_if<WindSample>(&input.payload)) {
    take_wind(input, *wind);
  } else if (const auto* displacement = std::get_if<Displacement>(&input.payload)) {
    take_displacement(input, *displacement, out);
  } else if (const auto* action = std::get_if<OperatorAction>(&input.payload)) {
    take_action(*action);
  }
}

void EstimationStage::take_wind(const Sample& input, const WindSample& wind) {
  if (!wind.valid || (input.header.status & kUnusable) != 0) return;
  if (!std::isfinite(wind.u_mps) || !std::isfinite(wind.v_mps)) return;
  const StreamInfo& info = streams_.info(input.header.stream);
  if (reference_topic_.empty() && !info.topic.starts_with(kTruth)) reference_topic_ = info.topic;
  if (info.topic != reference_topic_) return;
  const Mounting mounting = mounting_of(info);
  const double from_deg = wind_direction_deg(wind.u_mps, wind.v_mps, mounting.north_offset_deg, mounting.axes);
  reference_.add(input.header.sample_time, wind_from_components(std::hypot(wind.u_mps, wind.v_mps), from_deg));
}

// A target that is put somewhere else, or taken away, is another target.
void EstimationStage::take_action(const OperatorAction& action) {
  if (action.kind != OperatorAction::Kind::add_target && action.kind != OperatorAction::Kind::remove_target) return;
  const std::string ending = "/target/" + action.text + std::string(kTracked);
  for (auto& [topic, target] : targets_) {
    const bool is_meant = action.camera.empty() ? topic.ends_with(ending) : topic == "/" + action.camera + ending;
    if (!is_meant) continue;
    fusion_.remove(topic);
    target.estimator.emplace(options_);
  }
}

EstimationStage::Output EstimationStage::add_output(const std::string& topic, SampleKind kind, const std::string& device,
                                                    const std::string& source) {
  StreamInfo info;
  info.topic = topic;
  info.kind = to_string(kind);
  info.role = StreamRole::derived;
  info.device = device;
  if (!source.empty()) info.metadata["source"] = source;
  return {streams_.add(std::move(info)), 0};
}

EstimationStage::Target& EstimationStage::target(const std::string& topic) {
  if (const auto found = targets_.find(topic); found != targets_.end()) return found->second;
  Target& added = targets_.try_emplace(topic, options_).first->second;
  const auto source = streams_.find(topic);
  const std::string device = source ? streams_.info(*source).device : "";
  added.identification = add_output(result_topic(topic, "identification"), SampleKind::identification, device, topic);
  added.spectrum = add_output(result_topic(topic, "spectrum"), SampleKind::force_spectrum, device, topic);
  added.wind = add_output(result_topic(topic, "wind"), SampleKind::wind_estimate, device, topic);
  added.calibration = add_output(result_topic(topic, "calibration"), SampleKind::wind_calibration, device, topic);
  return added;
}

void EstimationStage::emit(Output& output, const Sample& input, HostTime sample_time, Payload payload, SampleSink& out) const {
  Sample sample;
  sample.header.stream = output.stream;
  sample.header.sequence = output.sequence++;
  sample.header.arrival_time = input.header.arrival_time;
  sample.header.sample_time = sample_time;
  sample.payload = std::move(payload);
  out.receive(std::move(sample));
}

void EstimationStage::take_displacement(const Sample& input, const Displacement& displacement, SampleSink& out) {
  const std::string& topic = streams_.info(input.header.stream).topic;
  if (!is_displacement_topic(topic) || (input.header.status & kUnusable) != 0) return;
  Target& mine = target(topic);
  const HostTime now = input.header.sample_time;
  const TargetOutput result = mine.estimator->add(now, displacement, reference_, reference_topic_);

  if (result.identification) emit(mine.identification, input, now, *result.identification, out);
  if (result.spectrum) emit(mine.spectrum, input, now, *result.spectrum, out);
  if (result.calibration) emit(mine.calibration, input, now, *result.calibration, out);
  for (const auto& [sample_time, wind] : result.winds) {
    emit(mine.wind, input, sample_time, wind, out);
    const auto direction_deg = mine.estimator->direction_deg();
    if (!options_.fuse_targets || !direction_deg) continue;
    for (const auto& fused : fusion_.add(topic, sample_time, wind, *direction_deg, mine.estimator->period_s())) {
      if (!std::exchange(has_fused_, true))
        fused_.stream = add_output("/wind/estimate", SampleKind::wind_estimate, "", "").stream;
      emit(fused_, input, fused.sample_time, fused.wind, out);
    }
  }
}

std::vector<EstimationStage::TargetCalibration> EstimationStage::calibrations(int bootstrap_replicates) const {
  std::vector<TargetCalibration> result;
  for (const auto& [topic, mine] : targets_) {
    if (const auto fit = mine.estimator->calibrate(reference_, bootstrap_replicates)) result.push_back({topic, *fit});
  }
  return result;
}

void EstimationStage::save(std::vector<std::byte>& out) const {
  StateWriter writer(out);
  writer(kStateVersion);
  writer(reference_topic_);
  writer(reference_);
  writer(fusion_);
  writer(has_fused_);
  writer(fused_.sequence);
  writer(static_cast<std::uint64_t>(targets_.size()));
  for (const auto& [topic, mine] : targets_) {
    writer(topic);
    for (const Output* output : {&mine.identification, &mine.spectrum, &mine.wind, &mine.calibration}) writer(output->sequence);
    mine.estimator->save(writer);
  }
}

void EstimationStage::clear() {
  reference_topic_ = options_.reference_topic;
  reference_.clear();
  targets_.clear();
  fusion_ = {};
  fused_ = {};
  has_fused_ = false;
}

Result<void> EstimationStage::load(std::span<const std::byte> in) {
  clear();
  const auto refuse = [this](const std::string& why) {
    clear();
    return Error{ErrorCode::corrupt, "checkpoint of the estimation: " + why};
  };
  StateReader reader(in);
  std::uint32_t version = 0;
  reader(version);
  if (version != kStateVersion) return refuse("not of this program's version");
  reader(reference_topic_);
  reader(reference_);
  reader(fusion_);
  reader(has_fused_);
  std::uint32_t fused_sequence = 0;
  reader(fused_sequence);
  if (has_fused_) fused_ = add_output("/wind/estimate", SampleKind::wind_estimate, "", "");
  fused_.sequence = fused_sequence;
  std::uint64_t count = 0;
  reader(count);
  for (std::uint64_t i = 0; reader.ok() && i < count; ++i) {
    std::string topic;
    reader(topic);
    if (!reader.ok() || !is_displacement_topic(topic)) return refuse("it names no target where one should be");
    Target& mine = target(topic);
    for (Output* output : {&mine.identification, &mine.spectrum, &mine.wind, &mine.calibration}) reader(output->sequence);
    if (!mine.estimator->load(reader)) return refuse("it ends early or is damaged");
  }
  if (!reader.ok() || !reader.at_end()) return refuse("it ends early or is damaged");
  return {};
}

}  // namespace roseau::estimation
