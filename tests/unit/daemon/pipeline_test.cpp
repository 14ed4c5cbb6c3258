#include "daemon/pipeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <thread>

namespace roseau::daemon {
namespace {

using std::chrono::milliseconds;

/// Two cameras' frames as one recording.
class TwoCameras : public SampleSource {
 public:
  TwoCameras(int frames, bool live) : frames_(frames), live_(live) {}
  const std::string& name() const override { return name_; }
  bool is_live() const override { return live_; }
  Result<void> open(StreamTable& streams) override {
    for (std::size_t i = 0; i < 2; ++i) {
      const auto device = "camera" + std::to_string(i);
      ids_[i] = streams.add({.topic = "/" + device + "/image", .kind = "frame", .device = device});
    }
    return {};
  }
  Result<ReadStatus> read(SampleSink& sink, milliseconds) override {
    if (next_ == frames_) return ReadStatus::finished;
    for (const StreamId id : ids_) {
      Sample frame;
      frame.header = {.stream = id,
                      .sequence = static_cast<std::uint32_t>(next_),
                      .arrival_time = HostTime{milliseconds(33 * next_)},
                      .sample_time = HostTime{milliseconds(33 * next_ - 5)}};
      frame.payload = Frame{};
      sink.receive(std::move(frame));
    }
    ++next_;
    return ReadStatus::more;
  }
  void close() override {}

 protected:
  void rewind() { next_ = 0; }

 private:
  std::string name_ = "recording";
  int frames_;
  bool live_;
  int next_ = 0;
  std::array<StreamId, 2> ids_{};
};

class FrameEcho : public Stage {
 public:
  FrameEcho(StreamTable& streams, const std::string& device, milliseconds pause)
      : out_(streams.add({.topic = "/" + device + "/target/a/displacement",
                          .kind = "displacement",
                          .role = StreamRole::derived,
                          .device = device})),
        pause_(pause) {}
  void process(const Sample& input, SampleSink& out) override {
    if (input.kind() != SampleKind::frame) return;
    std::this_thread::sleep_for(pause_);
    Sample result;
    result.header = input.header;
    result.header.stream = out_;
    result.payload = Displacement{};
    out.receive(std::move(result));
  }

 private:
  StreamId out_;
  milliseconds pause_;
};

class Silent : public Stage {
 public:
  void process(const Sample&, SampleSink&) override {}
};

struct Outcome {
  std::vector<std::pair<std::string, std::uint32_t>> analysed;
  std::vector<std::pair<std::string, std::uint32_t>> skipped;
  std::size_t inputs = 0;
  std::size_t frames = 0;
};

Outcome run(Pipeline::Options options, int frames, bool live, milliseconds pause) {
  StreamTable streams;
  Outcome outcome;
  const auto make_stages = [&] {
    Pipeline::Stages stages{.trackers = {}, .estimation = std::make_unique<Silent>()};
    for (const std::string device : {"camera0", "camera1"}) {
      stages.trackers.push_back({device, std::make_unique<FrameEcho>(streams, device, pause)});
    }
    return stages;
  };
  Pipeline::Hooks hooks;
  hooks.input = [&](const Sample& sample, HostTime) {
    ++outcome.inputs;
    if (const auto* skip = std::get_if<Skip>(&sample.payload)) {
      outcome.skipped.emplace_back(streams.info(skip->stream).topic, skip->sequence);
    }
  };
  hooks.frame = [&](const Sample&, HostTime) { ++outcome.frames; };
  hooks.analysed = [&](const Sample& sample, HostTime) {
    if (sample.kind() == SampleKind::displacement) {
      outcome.analysed.emplace_back(streams.info(sample.header.stream).topic, sample.header.sequence);
    }
  };
  Pipeline pipeline(
      std::move(options), streams, [](const StreamInfo&, StreamTable&) { return nullptr; }, make_stages, std::move(hooks));
  pipeline.add_source(std::make_unique<TwoCameras>(frames, live));
  pipeline.run({});
  return outcome;
}

TEST(Pipeline, NothingIsSkippedWhenItMayWait) {
  const auto outcome = run({.ring_capacity = 4, .skip_after_frames = 0}, 50, false, milliseconds(0));
  EXPECT_EQ(outcome.frames, 100U);
  EXPECT_EQ(outcome.analysed.size(), 100U);
  EXPECT_TRUE(outcome.skipped.empty());
}

TEST(Pipeline, LiveSkipsStereoPairsWholeAndSaysSoAsInputs) {
  const auto outcome = run({.ring_capacity = 256, .skip_after_frames = 3}, 60, true, milliseconds(2));
  EXPECT_EQ(outcome.frames, 120U) << "skipped frames are still shown and recorded";
  EXPECT_GT(outcome.skipped.size(), 0U);
  EXPECT_EQ(outcome.analysed.size() + outcome.skipped.size(), 120U);
  std::map<std::uint32_t, int> by_number;
  for (const auto& [topic, sequence] : outcome.skipped) ++by_number[sequence];
  for (const auto& [sequence, count] : by_number) {
    // The frame that tips the scale may be the pair's second: then its partner is already under way.
    EXPECT_LE(count, 2);
  }
}

TEST(Pipeline, LiveSkipsNothingWhileTrackingKeepsUp) {
  const auto outcome = run({.ring_capacity = 256, .skip_after_frames = 64}, 20, true, milliseconds(0));
  EXPECT_TRUE(outcome.skipped.empty());
  EXPECT_EQ(outcome.analysed.size(), 40U);
}

TEST(Pipeline, ReplayObeysRecordedSkips) {
  Pipeline::Options options{.ring_capacity = 8, .skip_after_frames = 0};
  options.recorded_skips = {{"/camera0/image", 3}, {"/camera1/image", 3}, {"/camera1/image", 7}};
  const auto outcome = run(options, 10, false, milliseconds(0));
  EXPECT_EQ(outcome.analysed.size(), 17U);
  EXPECT_EQ(std::ranges::count(outcome.analysed, std::pair<std::string, std::uint32_t>("/camera1/target/a/displacement", 7U)),
            0);
}

TEST(Pipeline, OperatorActionsAreInputs) {
  StreamTable streams;
  std::vector<std::string> marks;
  Pipeline::Hooks hooks;
  hooks.input = [&](const Sample& sample, HostTime) {
    if (const auto* action = std::get_if<OperatorAction>(&sample.payload)) marks.push_back(action->text);
  };
  Pipeline pipeline(
      {}, streams, [](const StreamInfo&, StreamTable&) { return nullptr; },
      [] { return Pipeline::Stages{.trackers = {}, .estimation = std::make_unique<Silent>()}; }, std::move(hooks));
  pipeline.act({.kind = OperatorAction::Kind::mark, .text = "gust"}, HostTime{});
  pipeline.add_source(std::make_unique<TwoCameras>(1, false));
  pipeline.run({});
  EXPECT_EQ(marks, std::vector<std::string>{"gust"});
}

/// A recording of two cameras, told what to do: frames up to a number, then a jump back to the begin, and so on.
class Jumping : public TwoCameras {
 public:
  struct Round {
    int frames = 0;
    ReadStatus ends_with = ReadStatus::finished;
  };
  explicit Jumping(std::vector<Round> rounds) : TwoCameras(1'000'000, false), rounds_(std::move(rounds)) {}
  Result<ReadStatus> read(SampleSink& sink, milliseconds timeout) override {
    const Round& round = rounds_.at(round_);
    if (given_ < round.frames) {
      ++given_;
      return TwoCameras::read(sink, timeout);
    }
    given_ = 0;
    ++round_;
    rewind();
    return round.ends_with;
  }

 private:
  std::vector<Round> rounds_;
  std::size_t round_ = 0;
  int given_ = 0;
};

/// Everything that came out of each place, between jumps, and whether the place came out whole.
struct Places {
  struct Place {
    std::vector<std::pair<std::string, std::uint32_t>> analysed;
    bool whole = true;
  };
  std::vector<Place> places{1};
};

Places run_jumping(std::vector<Jumping::Round> rounds, milliseconds pause) {
  StreamTable streams;
  Places result;
  Pipeline::Hooks hooks;
  hooks.analysed = [&](const Sample& sample, HostTime) {
    EXPECT_EQ(sample.header.status & kStatusLate, 0) << "no sequencer ever sees time go back";
    result.places.back().analysed.emplace_back(streams.info(sample.header.stream).topic, sample.header.sequence);
  };
  hooks.restarted = [&](bool whole) {
    result.places.back().whole = whole;
    result.places.emplace_back();
  };
  Pipeline pipeline(
      {.ring_capacity = 8, .skip_after_frames = 0}, streams, [](const StreamInfo&, StreamTable&) { return nullptr; },
      [&] {
        Pipeline::Stages stages{.trackers = {}, .estimation = std::make_unique<Silent>()};
        for (const std::string device : {"camera0", "camera1"}) {
          stages.trackers.push_back({device, std::make_unique<FrameEcho>(streams, device, pause)});
        }
        return stages;
      },
      std::move(hooks));
  pipeline.add_source(std::make_unique<Jumping>(std::move(rounds)));
  pipeline.run({});
  return result;
}

TEST(Pipeline, EveryRoundOfALoopComesOutWholeAndTheSame) {
  const auto places =
      run_jumping({{20, ReadStatus::round_ended}, {20, ReadStatus::round_ended}, {20, ReadStatus::finished}}, milliseconds(0))
          .places;
  ASSERT_EQ(places.size(), 3U);
  EXPECT_EQ(places[0].analysed.size(), 40U);
  for (const auto& place : places) {
    EXPECT_TRUE(place.whole);
    EXPECT_EQ(place.analysed, places[0].analysed);
  }
}

TEST(Pipeline, AJumpThrowsAwayWhatIsUnderWayAndStartsAnew) {
  const auto fresh = run_jumping({{20, ReadStatus::finished}}, milliseconds(0));
  const auto places = run_jumping({{60, ReadStatus::jumped}, {20, ReadStatus::finished}}, milliseconds(3)).places;
  ASSERT_EQ(places.size(), 2U);
  EXPECT_FALSE(places[0].whole);
  EXPECT_LT(places[0].analysed.size(), 120U) << "tracking was far behind: nobody waits for it";
  EXPECT_EQ(places[1].analysed, fresh.places[0].analysed);
}

TEST(Pipeline, ManyJumpsInARow) {
  std::vector<Jumping::Round> rounds(50, {3, ReadStatus::jumped});
  rounds.push_back({5, ReadStatus::finished});
  const auto result = run_jumping(rounds, milliseconds(0));
  ASSERT_EQ(result.places.size(), 51U);
  EXPECT_EQ(result.places.back().analysed.size(), 10U);
}

}  // namespace
}  // namespace roseau::daemon
