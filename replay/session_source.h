// SessionSource: a recorded session as a SampleSource. Gives the inputs (raw streams) in the recorded order, at a speed;
// recorded results are left aside, because they are made again.
//
// A seek starts the inputs anew, by the file's index, so that the place sought can be shown at once: with the last frame of
// each camera up to it, with the last two seconds of everything smaller, and before these with what the operator did until
// then (which targets there are). Sought from the begin, everything comes as in a fresh replay.
#pragma once

#include <atomic>
#include <deque>
#include <filesystem>
#include <functional>
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
  /// What Pacer::set_lookahead says. Before open().
  void set_lookahead(Duration lookahead) { pacer_->set_lookahead(lookahead); }
  /// Whether the end of the session is the end of the source, or waits for a seek (then everything until there is flushed).
  /// Thread-safe, at any time.
  void stay_at_end(bool stay) { stay_at_end_ = stay; }

  const std::string& config_text() const { return config_text_; }  // empty: none recorded
  const std::string& site_text() const { return site_text_; }
  const mcap::SessionInfo& info() const { return info_; }
  /// Frames that were skipped when this was recorded: (topic, sequence).
  const std::set<std::pair<std::string, std::uint32_t>>& skips() const { return skips_; }
  /// In their order.
  const std::vector<RecordedMark>& marks() const { return marks_; }
  Duration duration() const { return end_ - begin_; }
  /// The streams played.
  std::vector<StreamInfo> inputs() const;
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
  Result<void> read_marks();
  Result<void> read_all(SampleKind kind, const std::function<void(const Sample&, const StreamTable&)>& take);
  void start_at(HostTime place);
  void add_stretch(const std::vector<std::uint16_t>& channels, HostTime begin, HostTime end);
  std::map<std::uint16_t, HostTime> last_frames_until(HostTime place);
  std::vector<std::uint16_t> channels_of(const std::function<bool(SampleKind)>& wanted) const;
  bool read_next();
  Result<ReadStatus> at_end(SampleSink& sink, std::chrono::milliseconds timeout);
  void hand_over(SampleSink& sink);
  static void wait_for_buffer(std::unique_ptr<FramePool>& pool, std::size_t bytes);
  Result<Sample> parse_waiting(const Input& input, const mcap::Message& message);

  const std::string name_;
  std::unique_ptr<mcap::IndexedReader> reader_;
  ReplayOptions options_;
  std::unique_ptr<Pacer> pacer_;
  mcap::SessionInfo info_;
  std::string config_text_;
  std::string site_text_;
  std::set<std::pair<std::string, std::uint32_t>> skips_;
  std::vector<RecordedMark> marks_;
  std::map<std::uint16_t, Input> inputs_;  // by channel id
  HostTime begin_;
  HostTime end_;

  StreamTable* streams_ = nullptr;
  std::deque<mcap::MessageQuery> stretches_;     // of the file, still to be read
  std::map<std::uint16_t, HostTime> starts_;     // by channel: earlier messages are left out
  std::optional<mcap::MessageCursor> messages_;  // of the present stretch
  std::optional<mcap::ReadMessage> next_;        // read, not yet due
  std::unique_ptr<FramePool> frames_;
  std::unique_ptr<FramePool> stored_;  // for frames in their stored form
  std::atomic<bool> stay_at_end_{false};
  bool flushed_ = false;  // at the end, waiting
};

}  // namespace roseau::replay
