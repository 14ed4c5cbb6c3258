#include "daemon/health.h"

#include <algorithm>

namespace roseau::daemon {

HealthReporter::HealthReporter(StreamTable& streams, sync::CounterTable& counters, const Supervisor& supervisor,
                               const recorder::Recorder& recorder)
    : streams_(streams),
      counters_(counters),
      supervisor_(supervisor),
      recorder_(recorder),
      stream_(streams.add({.topic = "/roseau/health", .kind = "health", .role = StreamRole::health})),
      drop_stream_(streams.add({.topic = "/roseau/drops", .kind = "drop", .role = StreamRole::health})) {}

std::vector<Sample> HealthReporter::new_drops(HostTime now) {
  std::vector<Sample> drops;
  for (const auto& [topic, counters] : upstream_counters()) {
    std::uint64_t& reported = reported_drops_[topic];
    if (counters.dropped == reported) continue;
    Sample sample;
    sample.header = {.stream = drop_stream_, .sequence = drop_sequence_++, .arrival_time = now, .sample_time = now};
    sample.payload = Drop{.topic = topic, .stage = "sequencer", .count = counters.dropped - reported};
    reported = counters.dropped;
    drops.push_back(std::move(sample));
  }
  return drops;
}

std::map<std::string, StreamCounters> HealthReporter::upstream_counters() const {
  std::map<std::string, StreamCounters> by_topic;
  for (std::size_t id = 0; id < streams_.size(); ++id) {
    const auto stream = static_cast<StreamId>(id);
    const StreamCounters counters = counters_.of(stream).snapshot();
    if (counters.received > 0 || counters.dropped > 0) by_topic[streams_.info(stream).topic] = counters;
  }
  return by_topic;
}

std::map<std::string, StreamCounters> HealthReporter::counters() const {
  auto by_topic = upstream_counters();
  for (const auto& [topic, recorded] : recorder_.state().streams) {
    StreamCounters& counters = by_topic[topic];
    counters.recorded = recorded.recorded;
    counters.dropped += recorded.dropped;
  }
  return by_topic;
}

Sample HealthReporter::sample(HostTime now) {
  Health health;
  const double interval_s = to_seconds(now - last_);
  for (const auto& [topic, counters] : counters()) {
    const auto stream = streams_.find(topic);
    const std::int64_t last_arrival_ns = counters_.of(*stream).last_arrival_ns.load(std::memory_order_relaxed);
    if (last_arrival_ns == 0) continue;  // a result: its inputs tell how alive it is
    const std::uint64_t before = last_received_[topic];
    last_received_[topic] = counters.received;
    const double rate_hz = sequence_ == 0 || interval_s <= 0 ? 0 : static_cast<double>(counters.received - before) / interval_s;
    health.streams.push_back({topic, counters, rate_hz, std::max(0.0, to_seconds(now - host_time_from_ns(last_arrival_ns)))});
  }
  health.devices = supervisor_.devices();
  const auto recorder = recorder_.state();
  health.recorder = recorder.state;
  health.recorder_message = recorder.message;
  if (recorder.recording) {
    health.recording_path = recorder.path;
    health.recording_s = recorder.seconds;
  }
  health.recorded_bytes = recorder.bytes;
  health.disk_free_bytes = recorder.disk_free_bytes;
  last_ = now;
  Sample sample;
  sample.header = {.stream = stream_, .sequence = sequence_++, .arrival_time = now, .sample_time = now};
  sample.payload = std::move(health);
  return sample;
}

}  // namespace roseau::daemon
