// Streams, a recorder that writes files into a folder, and what those files hold.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "recorder/control/recording_control.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/recorder.h"
#include "schema/conversion.h"
#include "tests/support/temporary_folder.h"

namespace roseau::recorder::testing {

using namespace std::chrono_literals;

inline HostTime at_ms(std::int64_t time_ms) { return host_time_from_ns(time_ms * 1'000'000); }
inline std::int64_t to_ms(HostTime time) { return to_ns(time) / 1'000'000; }

/// Log times in a file, milliseconds, by topic, in the order of the file.
using LogTimes = std::map<std::string, std::vector<std::int64_t>>;

class ControlTest : public ::testing::Test {
 protected:
  void make(ControlOptions options) {
    ControlCallbacks callbacks;
    callbacks.open = [this](const std::string& cause) {
      causes.push_back(cause);
      return recorder.open(file(causes.size()), {});
    };
    control = std::make_unique<RecordingControl>(recorder, options, callbacks);
  }
  std::filesystem::path file(std::size_t number) const { return folder.path() / (std::to_string(number) + ".mcap"); }

  static Sample wind_sample(StreamId stream, HostTime time, double u_mps = 1) {
    return {{.stream = stream, .sequence = static_cast<std::uint32_t>(to_ms(time)), .arrival_time = time, .sample_time = time},
            WindSample{.u_mps = u_mps, .v_mps = 0, .w_mps = 0}};
  }
  /// A picture whose every pixel says when it was taken. Empty lease: the pool is empty.
  Sample picture(HostTime time) {
    Frame frame{.pixels = pool.acquire(), .width = 32, .height = 32, .stride = 32};
    if (frame.pixels) std::memset(frame.pixels.writable_bytes().data(), static_cast<int>(to_ms(time) / 20 % 251), 1024);
    return {
        {.stream = camera, .sequence = static_cast<std::uint32_t>(to_ms(time) / 20), .arrival_time = time, .sample_time = time},
        std::move(frame)};
  }
  /// 100 Hz wind, and 50 Hz pictures, from..to, both included.
  void play(std::int64_t from_ms, std::int64_t to_ms, bool with_pictures = false) {
    for (std::int64_t time_ms = from_ms; time_ms <= to_ms; time_ms += 10) {
      control->take(wind_sample(wind, at_ms(time_ms)), at_ms(time_ms));
      if (with_pictures && time_ms % 20 == 0) control->take(picture(at_ms(time_ms)), at_ms(time_ms) + 1us);
    }
  }
  LogTimes read(std::size_t number) {
    LogTimes times;
    auto reader = mcap::IndexedReader::open(file(number));
    EXPECT_TRUE(reader) << (reader ? "" : reader.error().message);
    if (!reader) return times;
    EXPECT_TRUE((*reader)->index().complete);
    auto cursor = (*reader)->messages();
    for (auto message = cursor.next(); message && *message; message = cursor.next()) {
      const auto& read = **message;
      times[read.channel->topic].push_back(static_cast<std::int64_t>(read.message.log_time_ns / 1'000'000));
      if (read.channel->topic != "/camera0/image") continue;
      const auto view = schema::parse_frame(read.message.data, {});
      EXPECT_TRUE(view);
      const auto expected = static_cast<std::byte>(read.message.log_time_ns / 20'000'000 % 251);
      EXPECT_THAT(view->pixels, ::testing::Each(expected)) << "at " << times[read.channel->topic].back();
    }
    return times;
  }
  static std::vector<std::int64_t> steps(std::int64_t from_ms, std::int64_t to_ms, std::int64_t step_ms = 10) {
    std::vector<std::int64_t> times;
    for (std::int64_t time_ms = from_ms; time_ms <= to_ms; time_ms += step_ms) times.push_back(time_ms);
    return times;
  }

  const roseau::testing::TemporaryFolder folder;
  StreamTable streams;
  StreamId wind = streams.add({.topic = "/sonic/wind", .kind = "wind", .role = StreamRole::derived, .device = "sonic"});
  StreamId camera = streams.add({.topic = "/camera0/image", .kind = "frame", .device = "camera0"});
  FramePool pool{8, 1024};
  Recorder recorder{streams};
  std::vector<std::string> causes;
  std::unique_ptr<RecordingControl> control;
};

}  // namespace roseau::recorder::testing
