// SessionSource: a recorded session as a SampleSource. Gives the inputs (raw streams) in the recorded order, at a speed;
// recorded results are left aside, because they are made again.
#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/frame.h"
#include "core/source.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/format/topics.h"
#include "replay/pacer.h"

namespace roseau::replay {

struct ReplayOptions {
  double speed = 1;  // recorded seconds per second; infinity: as fast as possible
  bool loop = false;
  Pacer::Clock now;  // the host's monotonic clock: paces only, never stamps
};

class SessionSource final : public SampleSource {
 public:
  /// Reads the file's index and what travels with the session. Errors name the file and say what to do: not found, not a
  /// session, written by a newer program, without any inputs.
  static Result<std::unique_ptr<SessionSource>> open_file(const std::filesystem::path& path, ReplayOptions options);
  ~SessionSource() override;

  const std::string& name() const override { return name_; }
  bool is_live() const override { return false; }
  Result<void> open(StreamTable& streams) override;
  Result<ReadStatus> read(SampleSink& sink, std::chrono::milliseconds timeout) override;
  void close() override {}

  /// Play, pause, speed, position. Thread-safe; valid for the source's life.
  PlayerControl& player() { return *pacer_; }

  const std::string& config_text() const { return config_text_; }  // empty: none recorded
  const std::string& site_text() const { return site_text_; }
  const mcap::SessionInfo& info() const { return info_; }
  /// Frames that were skipped when this was recorded: (topic, sequence).
  const std::set<std::pair<std::string, std::uint32_t>>& skips() const { return skips_; }
  Duration duration() const { return end_ - begin_; }
  /// Camera devices in the session, in order of their topics.
  std::vector<std::string> cameras() const;
  /// What is wrong with the file, in words; empty when it is whole.
  const std::vector<std::string>& damage() const { return reader_->index().damage; }

 private:
  struct Input {
    SampleKind kind;
    StreamInfo info;
    StreamId stream = 0;
  };
  SessionSource(std::string name, std::unique_ptr<mcap::IndexedReader> reader, ReplayOptions options);
  Result<void> read_session();
  Result<void> read_texts();
  Result<void> read_skips();
  void restart_messages();
  Result<Sample> parse_waiting(const Input& input, const mcap::Message& message);
  void shift(SampleHeader& header) const;

  const std::string name_;
  std::unique_ptr<mcap::IndexedReader> reader_;
  ReplayOptions options_;
  std::unique_ptr<Pacer> pacer_;
  mcap::SessionInfo info_;
  std::string config_text_;
  std::string site_text_;
  std::set<std::pair<std::string, std::uint32_t>> skips_;
  std::map<std::uint16_t, Input> inputs_;  // by channel id
  HostTime begin_;
  HostTime end_;

  StreamTable* streams_ = nullptr;
  std::optional<mcap::MessageCursor> messages_;
  std::optional<mcap::ReadMessage> next_;  // read, not yet due
  std::unique_ptr<FramePool> frames_;
  Duration loop_shift_{0};  // added to every time: what earlier rounds took
};

}  // namespace roseau::replay
