#include "replay/session_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "recorder/recorder.h"
#include "tests/support/temporary_folder.h"

namespace roseau::replay {
namespace {

using namespace std::chrono_literals;

/// "topic number": what came, in its order.
struct Collector : SampleSink {
  explicit Collector(const StreamTable& table) : streams(table) {}
  bool receive(Sample sample) override {
    items.push_back(streams.info(sample.header.stream).topic + " " + std::to_string(sample.header.sequence));
    arrivals.push_back(sample.header.arrival_time);
    return true;
  }
  void flush() override { ++flushes; }
  std::string last_of(const std::string& topic) const {
    const auto found =
        std::find_if(items.rbegin(), items.rend(), [&](const auto& item) { return item.starts_with(topic + " "); });
    return found == items.rend() ? "" : *found;
  }
  std::string first_of(const std::string& topic) const {
    const auto found = std::ranges::find_if(items, [&](const auto& item) { return item.starts_with(topic + " "); });
    return found == items.end() ? "" : *found;
  }
  void clear() {
    items.clear();
    arrivals.clear();
  }
  const StreamTable& streams;
  std::vector<std::string> items;
  std::vector<HostTime> arrivals;
  int flushes = 0;
};

constexpr HostTime kBegin{100s};

/// 20 s: a camera every 100 ms (number n at begin + n * 100 ms), another every 5 s, wind every 20 ms, and a target chosen at
/// the begin.
class SessionSourceTest : public ::testing::Test {
 protected:
  SessionSourceTest() {
    StreamTable streams;
    const StreamId operators = streams.add({.topic = "/roseau/operator", .kind = "operator_action"});
    const StreamId camera = streams.add({.topic = "/camera0/image", .kind = "frame", .device = "camera0"});
    const StreamId slow = streams.add({.topic = "/camera1/image", .kind = "frame", .device = "camera1"});
    const StreamId wind = streams.add({.topic = "/sonic/wind", .kind = "wind", .device = "sonic"});
    recorder::Recorder recorder(streams, {.wait_when_full = true, .reproducible = true});
    EXPECT_TRUE(recorder.open(file_, {}));
    const auto record = [&recorder](StreamId stream, std::uint32_t number, HostTime time, Payload payload) {
      Sample sample;
      sample.header = {.stream = stream, .sequence = number, .arrival_time = time, .sample_time = time};
      sample.payload = std::move(payload);
      recorder.receive(std::move(sample));
    };
    FramePool pool(8, 64);
    record(
        operators, 0, kBegin,
        OperatorAction{.kind = OperatorAction::Kind::add_target, .text = "twig", .camera = "camera0", .region = {1, 1, 4, 4}});
    for (std::uint32_t n = 0; n < 1000; ++n) {
      const HostTime time = kBegin + n * 20ms;
      for (const auto& [stream, every] : {std::pair(camera, 5U), std::pair(slow, 250U)}) {
        if (n % every != 0) continue;
        Frame frame{.pixels = pool.acquire(), .width = 8, .height = 8, .stride = 8};
        while (!frame.pixels) frame.pixels = pool.acquire();
        record(stream, n / every, time + 1ms, std::move(frame));
      }
      record(wind, n, time + 2ms, WindSample{.u_mps = 1});
    }
    EXPECT_TRUE(recorder.close());
  }

  std::unique_ptr<SessionSource> open(ReplayOptions options = {}) {
    options.now = [this] { return now_; };
    auto source = SessionSource::open_file(file_, options);
    EXPECT_TRUE(source) << source.error().message;
    EXPECT_TRUE((*source)->open(streams_));
    return std::move(*source);
  }

  /// Until it waits, ends, or starts anew.
  ReadStatus read(SessionSource& source) {
    for (int i = 0; i < 10'000; ++i) {
      const auto status = source.read(sink_, 0ms);
      EXPECT_TRUE(status);
      if (*status != ReadStatus::more) return *status;
    }
    ADD_FAILURE() << "no end";
    return ReadStatus::idle;
  }
  void seek(SessionSource& source, HostTime time) {
    source.player().seek(time);
    EXPECT_EQ(read(source), ReadStatus::jumped);
    sink_.clear();
  }

  const testing::TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "s.mcap";
  StreamTable streams_;
  Collector sink_{streams_};
  HostTime now_{5s};
};

constexpr double kMax = std::numeric_limits<double>::infinity();

TEST_F(SessionSourceTest, PlaysEverythingInItsOrder) {
  auto source = open({.speed = kMax});
  EXPECT_EQ(read(*source), ReadStatus::finished);
  EXPECT_EQ(sink_.items.size(), 1U + 200 + 4 + 1000);
  EXPECT_TRUE(std::ranges::is_sorted(sink_.arrivals));
}

TEST_F(SessionSourceTest, ASeekStartsWithTheLastFramesAndTwoSecondsOfTheRest) {
  auto source = open();
  // Between frames 123 (at 12.301 s) and 124; the slow camera's number 2 came at 10.001 s, wind 516 at 10.322 s.
  seek(*source, kBegin + 12320ms);
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_EQ(sink_.items.front(), "/roseau/operator 0") << "targets chosen before stand";
  EXPECT_EQ(sink_.first_of("/camera0/image"), "/camera0/image 123");
  EXPECT_EQ(sink_.last_of("/camera0/image"), "/camera0/image 123") << "later ones are not due yet";
  EXPECT_EQ(sink_.first_of("/camera1/image"), "/camera1/image 2");
  EXPECT_EQ(sink_.first_of("/sonic/wind"), "/sonic/wind 516");
  EXPECT_EQ(sink_.last_of("/sonic/wind"), "/sonic/wind 615");
  EXPECT_TRUE(std::ranges::is_sorted(sink_.arrivals));
  EXPECT_EQ(source->player().state().position, kBegin + 12320ms);

  sink_.clear();
  now_ += 100ms;
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_EQ(sink_.first_of("/camera0/image"), "/camera0/image 124");
  EXPECT_EQ(sink_.first_of("/sonic/wind"), "/sonic/wind 616") << "goes on from there, nothing missing";
}

TEST_F(SessionSourceTest, AFrameAtTheVeryTimeIsThatTimesFrame) {
  auto source = open();
  seek(*source, kBegin + 12301ms);
  read(*source);
  EXPECT_EQ(sink_.last_of("/camera0/image"), "/camera0/image 123");
  seek(*source, kBegin + 12301ms - 1ns);
  read(*source);
  EXPECT_EQ(sink_.last_of("/camera0/image"), "/camera0/image 122");
}

TEST_F(SessionSourceTest, SoughtFromTheBeginEverythingComesAgain) {
  auto source = open({.speed = kMax});
  EXPECT_EQ(read(*source), ReadStatus::finished);
  const auto fresh = sink_.items;
  for (const HostTime place : {kBegin, HostTime{0s}}) {
    seek(*source, place);
    EXPECT_EQ(source->player().state().position, kBegin);
    EXPECT_EQ(read(*source), ReadStatus::finished);
    EXPECT_EQ(sink_.items, fresh);
  }
}

TEST_F(SessionSourceTest, BehindTheEndTheLastFrameIsShownAndItEnds) {
  auto source = open({.speed = kMax});
  seek(*source, HostTime{9999s});
  EXPECT_EQ(source->player().state().position, source->player().state().end);
  EXPECT_EQ(read(*source), ReadStatus::finished);
  EXPECT_EQ(sink_.last_of("/camera0/image"), "/camera0/image 199");
  EXPECT_EQ(sink_.last_of("/sonic/wind"), "/sonic/wind 999");
  EXPECT_TRUE(source->player().state().ended);
}

TEST_F(SessionSourceTest, PausedItShowsThePlaceAndAsLittleMoreAsTheAnalysisNeeds) {
  auto source = open();
  source->set_lookahead(40ms);
  source->player().pause();
  seek(*source, kBegin + 5s);
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_EQ(sink_.last_of("/camera0/image"), "/camera0/image 50") << "at 5.001 s, within what is looked ahead";
  EXPECT_EQ(sink_.last_of("/sonic/wind"), "/sonic/wind 252") << "the first at 5.040 s or later";
  EXPECT_EQ(source->player().state().position, kBegin + 5s);
  now_ += 60s;
  sink_.clear();
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_TRUE(sink_.items.empty()) << "paused";
  source->player().play();
  now_ += 50ms;
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_TRUE(sink_.items.empty());
  now_ += 20ms;
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_EQ(sink_.items, std::vector<std::string>{"/sonic/wind 253"});
}

TEST_F(SessionSourceTest, OfManySeeksOnlyTheLastIsCarriedOut) {
  auto source = open();
  for (int i = 1; i < 20; ++i) source->player().seek(kBegin + i * 1s);
  source->player().seek(kBegin + 3s);
  EXPECT_EQ(source->player().state().jumps, 20U);
  EXPECT_EQ(source->player().state().jumps_done, 0U);
  EXPECT_EQ(read(*source), ReadStatus::jumped);
  EXPECT_EQ(source->player().state().jumps_done, 20U);
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_EQ(sink_.last_of("/camera0/image"), "/camera0/image 29");
  EXPECT_EQ(source->player().state().position, kBegin + 3s);
}

TEST_F(SessionSourceTest, AWatchedEndWaitsForASeek) {
  auto source = open({.speed = kMax});
  source->stay_at_end(true);
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_EQ(sink_.flushes, 1) << "the last samples come out";
  EXPECT_TRUE(source->player().state().ended);
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_EQ(sink_.flushes, 1);
  seek(*source, kBegin + 15s);
  EXPECT_FALSE(source->player().state().ended);
  EXPECT_EQ(read(*source), ReadStatus::idle);
  EXPECT_EQ(sink_.flushes, 2);
  // Playing from the end means from the begin.
  source->player().play();
  EXPECT_EQ(read(*source), ReadStatus::jumped);
  sink_.clear();
  source->stay_at_end(false);
  EXPECT_EQ(read(*source), ReadStatus::finished);
  EXPECT_EQ(sink_.items.size(), 1205U);
}

TEST_F(SessionSourceTest, EveryRoundOfALoopIsTheSame) {
  auto source = open({.speed = kMax, .loop = true});
  EXPECT_EQ(read(*source), ReadStatus::round_ended);
  const auto first = sink_.items;
  const auto arrivals = sink_.arrivals;
  EXPECT_EQ(first.size(), 1205U);
  sink_.clear();
  EXPECT_EQ(source->player().state().jumps, 1U);
  EXPECT_EQ(read(*source), ReadStatus::round_ended);
  EXPECT_EQ(sink_.items, first);
  EXPECT_EQ(sink_.arrivals, arrivals) << "with the times of the recording";
}

}  // namespace
}  // namespace roseau::replay
