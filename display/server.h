// DisplayServer: the live view. One port serves the page, a small JSON API (http_api.h) and the Foxglove WebSocket protocol.
//
// It never holds up the pipeline: handing a sample over is a push into a bounded inbox (inbox.h). One thread of its own turns
// samples into messages and pictures into JPEGs, only what somebody watches; a second one serves. Slow viewers lose pictures
// and nothing else, until a bounded amount of other messages waits for them and they are let go (outbox.h).
//
// Topics: every stream of the table under its own topic; each camera also as `<topic>/preview` (foxglove.CompressedImage,
// JPEG); `/display/state`.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/player_control.h"
#include "core/result.h"
#include "core/sample.h"
#include "core/source.h"
#include "core/stream.h"
#include "display/static_files.h"

namespace roseau::display {

struct DisplayOptions {
  std::string address = "127.0.0.1";  // loopback: this machine only; "0.0.0.0": the network too
  std::uint16_t port = 8420;          // 0: any free port
  std::filesystem::path web_root = default_web_root();

  std::string session_name;
  std::string mode = "live";  // "live", "replay" or "demo": a word the page shows
  std::string version;
  Duration civil_from_host{0};  // added to a host time gives civil time (ns since 1970, UTC); 0: unknown

  std::uint32_t preview_width_px = 960;
  int preview_quality = 80;                   // JPEG
  double preview_rate_hz = 30;                // at most, per camera, in wall time
  std::size_t inbox_capacity = 8192;          // small messages waiting for the display's thread
  std::size_t client_budget_bytes = 8 << 20;  // small messages waiting for one viewer

  std::vector<RecordedMark> marks;  // replay: shown on the slider of time

  /// Hosted viewers that may watch from a browser (Origin), beside the page itself, loopback and desktop programs.
  std::vector<std::string> viewer_origins = {"https://app.foxglove.dev"};
};

/// What the page may ask for. Called in the server's thread: hand the wish on and return. An Error's message is shown to the
/// operator as it is.
struct DisplayCallbacks {
  std::function<Result<void>(const OperatorAction&)> on_action;
};

class DisplayServer final : public SampleSink {
 public:
  /// `streams` and `player` (null unless replaying) outlive the server.
  DisplayServer(DisplayOptions options, const StreamTable& streams, DisplayCallbacks callbacks,
                PlayerControl* player = nullptr);
  ~DisplayServer() override;
  DisplayServer(const DisplayServer&) = delete;
  DisplayServer& operator=(const DisplayServer&) = delete;

  /// Starts listening and serving; returns the port. `busy` when it is taken. A missing page is logged and served as words:
  /// the protocol works without it.
  Result<std::uint16_t> start();

  /// Ends all connections and both threads, within about a second. Also done by the destructor.
  void stop();

  /// Shows a sample. Thread-safe, never blocks. `log_time`: as recorded (arrival time made strictly increasing). False: the
  /// inbox was full, the sample is not shown and counted in dropped().
  bool publish(const Sample& sample, HostTime log_time);

  /// publish() with the sample's arrival time, without a copy.
  bool receive(Sample sample) override;

  /// What is published from now on tells of the place that the player has just jumped to: nothing published before is shown any
  /// more, and nothing of it is kept. Call it between the last sample of the one place and the first of the other.
  void restart();

  /// Connections of pages and other viewers, as of a quarter of a second ago. Thread-safe.
  std::size_t viewers() const;

  /// Samples not shown, or pictures replaced by newer ones before they were shown, per topic since the start. Thread-safe.
  std::map<std::string, std::uint64_t> dropped() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace roseau::display
