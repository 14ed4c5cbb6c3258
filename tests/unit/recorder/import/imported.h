// A whole import of one plan, kept in memory.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recorder/tools/import/import_session.h"

namespace roseau::recorder {

struct Imported : SampleSink {
  bool receive(Sample sample) override {
    samples[streams.info(sample.header.stream).topic].push_back(std::move(sample));
    return true;
  }

  /// Empty when all went well.
  std::string run(const ImportPlan& plan) {
    auto import = SessionImport::prepare(plan, streams);
    if (!import) return import.error().message;
    utc_minus_host_time = import->utc_minus_host_time();
    const auto told = import->run(*this);
    if (!told) return told.error().message;
    report = *told;
    return {};
  }

  template <class Payload>
  const Payload& payload(const std::string& topic, std::size_t index) const {
    return std::get<Payload>(samples.at(topic).at(index).payload);
  }
  /// Since 1970.
  Duration civil(const std::string& topic, std::size_t index) const {
    return samples.at(topic).at(index).header.sample_time.time_since_epoch() + *utc_minus_host_time;
  }
  double seconds_after_first(const std::string& topic, std::size_t index) const {
    const auto& of_topic = samples.at(topic);
    return to_seconds(of_topic.at(index).header.sample_time - of_topic.at(0).header.sample_time);
  }
  std::string remarks() const {
    std::string all;
    for (const auto& stream : report.streams) {
      for (const auto& remark : stream.remarks) all += remark + "\n";
    }
    return all;
  }

  StreamTable streams;
  std::map<std::string, std::vector<Sample>> samples;
  std::optional<Duration> utc_minus_host_time;
  ImportReport report;
};

inline ImportPlan sonic_plan(const std::string& path, SonicFormat format = SonicFormat::automatic) {
  ImportPlan plan;
  plan.sonics.push_back({.path = path, .file = {.format = format}});
  return plan;
}

inline ImportPlan tracker_plan(const std::string& path, TrackerFormat format = TrackerFormat::automatic) {
  ImportPlan plan;
  plan.trackers.push_back({.path = path, .file = {.format = format}});
  return plan;
}

}  // namespace roseau::recorder
