// Small session files for the tests of the session tools, and what is in a file.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "recorder/format/indexed_reader.h"
#include "recorder/recorder.h"
#include "tests/support/samples.h"

namespace roseau::testing {

/// Written by the real recorder: /sonic/wind at 20 Hz, /camera0/image at 10 Hz, one calibration and one target at the start,
/// and what a test adds.
class SessionFile {
 public:
  explicit SessionFile(HostTime begin = host_time_from_ns(1'000'000'000'000)) : begin_(begin) {}

  recorder::SessionDescription description{
      "0.1.0", "[run]\nrate_hz = 20\n", "[site]\nname = 'Inra'\n", Duration{1'700'000'000'000'000'000}, {{"name", "storm"}}};
  StreamTable streams;

  HostTime at(double seconds) const { return begin_ + from_seconds(seconds); }

  StreamId stream(const std::string& topic, SampleKind kind, std::map<std::string, std::string> metadata = {}) {
    const std::string device = topic.substr(1, topic.find('/', 1) - 1);
    return streams.add({.topic = topic,
                        .kind = std::string(to_string(kind)),
                        .role = kind == SampleKind::wind_estimate ? StreamRole::derived : StreamRole::raw,
                        .device = device,
                        .metadata = std::move(metadata)});
  }

  void open(const std::filesystem::path& path) {
    const auto opened = recorder_.open(path, description);
    ASSERT_TRUE(opened) << opened.error().message;
  }
  void add(const std::string& topic, double seconds, std::uint32_t sequence, Payload payload,
           std::uint16_t status = kStatusOk) {
    Sample sample;
    sample.payload = std::move(payload);
    sample.header = {.stream = stream(topic, sample.kind()),
                     .status = status,
                     .sequence = sequence,
                     .arrival_time = at(seconds),
                     .sample_time = at(seconds) - Duration{1'000'000}};
    recorder_.receive(std::move(sample));
  }
  void close() { ASSERT_TRUE(recorder_.close()); }

  static WindSample wind(double u_mps) {
    return {.u_mps = u_mps, .v_mps = -1, .w_mps = 0.25, .sonic_temperature_celsius = 20, .speed_of_sound_mps = 343};
  }

  /// `seconds` of the usual streams.
  void write(const std::filesystem::path& path, double seconds) {
    open(path);
    stream("/sonic/wind", SampleKind::wind, {{"axes", "gill_spar"}, {"north_offset_deg", "30"}});
    add("/camera0/calibration", 0, 0, CameraCalibration{.width = 640, .height = 480, .fx_px = 700, .fy_px = 700});
    OperatorAction target{.kind = OperatorAction::Kind::add_target, .text = "branch", .camera = "camera0"};
    target.region = {10, 20, 30, 40};
    add("/roseau/operator", 0, 0, target);
    const auto slots = static_cast<std::uint32_t>(seconds * 20);
    for (std::uint32_t i = 0; i < slots; ++i) {
      add("/sonic/wind", 0.05 * i, i, wind(i * 0.1));
      if (i % 2 == 0) add("/camera0/image", 0.05 * i, i / 2, frame());
    }
    close();
  }

  /// 100 x 50 pixels. Waits until the recorder has let go of an earlier one.
  Frame frame() {
    while (pool_.free_count() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return filled_frame(pool_, 100, 50, 100);
  }

 private:
  HostTime begin_;
  FramePool pool_{32, 5000};
  recorder::Recorder recorder_{streams, {.wait_when_full = true, .reproducible = true}};
};

struct HeldMessage {
  std::string topic;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0;
  std::uint64_t publish_time_ns = 0;
  std::vector<std::byte> data;
  bool operator==(const HeldMessage&) const = default;
};

inline std::unique_ptr<mcap::IndexedReader> open_session(const std::filesystem::path& path) {
  auto reader = mcap::IndexedReader::open(path);
  EXPECT_TRUE(reader) << (reader ? "" : reader.error().message);
  return reader ? std::move(*reader) : nullptr;
}

/// All messages in order of time; those of one topic where it is given.
inline std::vector<HeldMessage> messages_of(const std::filesystem::path& path, const std::string& topic = "") {
  std::vector<HeldMessage> held;
  const auto reader = open_session(path);
  if (reader == nullptr) return held;
  auto messages = reader->messages();
  for (auto message = messages.next(); !message || *message; message = messages.next()) {
    if (!message) {
      ADD_FAILURE() << message.error().message;
      continue;
    }
    const auto& [channel, record] = **message;
    if (!topic.empty() && channel->topic != topic) continue;
    held.push_back({channel->topic, record.sequence, record.log_time_ns, record.publish_time_ns,
                    std::vector<std::byte>(record.data.begin(), record.data.end())});
  }
  return held;
}

}  // namespace roseau::testing
