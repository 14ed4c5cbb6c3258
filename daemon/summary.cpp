#include "daemon/summary.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/topic_names.h"

namespace roseau::daemon {

namespace {

// Ordered: people read it too, and tests compare text.
using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json stream_json(const StreamCounters& counters) {
  return {{"received", counters.received}, {"recorded", counters.recorded}, {"dropped", counters.dropped},
          {"gaps", counters.gaps},         {"bad", counters.bad},           {"late", counters.late}};
}

Json target_json(const ResultCollector::Target& target) {
  const auto& found = target.last_accepted;
  return {{"natural_frequency_hz", number(found.natural_frequency_hz)},
          {"damping_ratio", number(found.damping_ratio)},
          {"natural_frequency_sd_hz", number(found.natural_frequency_sd_hz)},
          {"damping_ratio_sd", number(found.damping_ratio_sd)},
          {"identifications", target.identifications},
          {"estimates", target.estimates}};
}

Json wind_json(const WindCalibration& calibration) {
  return {{"reference", calibration.reference},      {"correlation", number(calibration.correlation)},
          {"rms_mps", number(calibration.rms_mps)},  {"skill", number(calibration.explained)},
          {"lag_s", number(calibration.delay_s)},    {"direction_deg", number(calibration.direction_deg)},
          {"exponent", number(calibration.exponent)}};
}

}  // namespace

void ResultCollector::see(const Sample& sample) {
  judge_.see(sample);
  const std::string& topic = streams_.info(sample.header.stream).topic;
  if (const auto* found = std::get_if<Identification>(&sample.payload)) {
    const auto name = target_of_topic(topic, "identification");
    if (!name || topic.starts_with("/truth")) return;
    Target& target = targets_[*name];
    if (!found->accepted) return;
    target.last_accepted = *found;
    ++target.identifications;
  } else if (const auto* estimate = std::get_if<WindEstimate>(&sample.payload)) {
    if (const auto name = target_of_topic(topic, "wind"); name && estimate->accepted) ++targets_[*name].estimates;
  } else if (const auto* calibration = std::get_if<WindCalibration>(&sample.payload)) {
    if (const auto name = target_of_topic(topic, "calibration")) targets_[*name].calibration = *calibration;
  }
}

const WindCalibration* ResultCollector::best_calibration() const {
  const WindCalibration* best = nullptr;
  for (const auto& [name, target] : targets_) {
    if (target.calibration.reference.empty()) continue;
    const bool better = best == nullptr || !std::isfinite(best->explained) || target.calibration.explained > best->explained;
    if (better) best = &target.calibration;
  }
  return best;
}

std::string summary_json(const RunFacts& facts, const ResultCollector& results) {
  Json json;
  json["session"] = {{"duration_s", facts.duration_s},
                     {"speed_ratio", number(facts.duration_s / facts.wall_s)},
                     {"wall_s", facts.wall_s},
                     {"recording", facts.recording}};
  json["streams"] = Json::object();
  for (const auto& [topic, counters] : facts.streams) json["streams"][topic] = stream_json(counters);
  json["clocks"] = Json::object();
  for (const auto& clock : facts.clocks) {
    json["clocks"][clock.device] = {{"offset_s", clock.offset_s},
                                    {"offset_sd_s", clock.offset_sd_s},
                                    {"frequency_offset_ppm", clock.frequency_offset_ppm},
                                    {"jitter_s", clock.jitter_s},
                                    {"resets", clock.resets}};
  }
  json["targets"] = Json::object();
  for (const auto& [name, target] : results.targets()) json["targets"][name] = target_json(target);
  if (const auto* calibration = results.best_calibration()) json["wind"] = wind_json(*calibration);
  const auto truth = results.truth();
  for (const auto& [quantity, figures] : truth) {
    json["truth"][quantity] = {
        {"rms", figures.rms}, {"p95", figures.p95}, {"max", figures.max}, {"unit", figures.unit}, {"count", figures.count}};
  }
  json["cpu_s"] = Json::object();
  for (const auto& [part, seconds] : facts.cpu_s) json["cpu_s"][part] = seconds;
  json["display_dropped"] = facts.display_dropped;
  json["digest"] = facts.digest;
  return json.dump(2);
}

std::string summary_text(const RunFacts& facts, const ResultCollector& results) {
  std::string text = fmt::format("\n{:.1f} s of session in {:.1f} s ({:.2f} x)\n", facts.duration_s, facts.wall_s,
                                 facts.duration_s / facts.wall_s);
  text += fmt::format("{:<44} {:>9} {:>9} {:>8} {:>6} {:>6}\n", "stream", "received", "recorded", "dropped", "gaps", "bad");
  for (const auto& [topic, counters] : facts.streams) {
    text += fmt::format("{:<44} {:>9} {:>9} {:>8} {:>6} {:>6}\n", topic, counters.received, counters.recorded, counters.dropped,
                        counters.gaps, counters.bad);
  }
  for (const auto& [name, target] : results.targets()) {
    const auto& found = target.last_accepted;
    if (target.identifications == 0) {
      text += fmt::format("target {}: no oscillation could be identified\n", name);
      continue;
    }
    text += fmt::format("target {}: natural frequency {:.3f} +- {:.3f} Hz, damping ratio {:.3f} +- {:.3f}\n", name,
                        found.natural_frequency_hz, found.natural_frequency_sd_hz, found.damping_ratio, found.damping_ratio_sd);
  }
  if (const auto* wind = results.best_calibration(); wind != nullptr && std::isfinite(wind->correlation)) {
    text += fmt::format("wind against {}: r {:.3f}, RMS {:.2f} m/s\n", wind->reference, wind->correlation, wind->rms_mps);
  }
  for (const auto& [quantity, figures] : results.truth()) {
    text += fmt::format("truth {}: RMS {:.4g}, p95 {:.4g}, max {:.4g} {}\n", quantity, figures.rms, figures.p95, figures.max,
                        figures.unit);
  }
  if (!facts.recording.empty()) text += fmt::format("recorded: {}\n", facts.recording);
  return text + fmt::format("digest {}\n", facts.digest);
}

}  // namespace roseau::daemon
