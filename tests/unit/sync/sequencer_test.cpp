#include "sync/sequencer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tuple>

namespace roseau::sync {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;

HostTime at_ms(std::int64_t ms) { return HostTime{milliseconds(ms)}; }

/// A decoder that makes one wind sample per byte, at the byte's own arrival.
class BytePerRecord : public Decoder {
 public:
  explicit BytePerRecord(StreamId wind) : wind_(wind) {}
  void decode(const Sample& raw, SampleSink& sink) override {
    const auto& bytes = std::get<RawBytes>(raw.payload);
    for (std::size_t i = 0; i < bytes.size; ++i) {
      Sample wind;
      wind.header.stream = wind_;
      wind.header.sequence = sequence_++;
      wind.header.arrival_time = raw.header.arrival_time + bytes.byte_time * static_cast<int>(i);
      wind.header.sample_time = wind.header.arrival_time;
      wind.payload = WindSample{.u_mps = static_cast<double>(bytes.storage[i])};
      sink.receive(std::move(wind));
    }
  }
  void reset() override {}
  const DecoderCounters& counters() const override { return counters_; }

 private:
  StreamId wind_;
  std::uint32_t sequence_ = 0;
  DecoderCounters counters_;
};

class SequencerTest : public ::testing::Test {
 protected:
  struct Out {
    std::string topic;
    std::int64_t sample_ms;
    std::uint16_t status;
    bool operator==(const Out&) const = default;
  };

  Sequencer make(milliseconds window = milliseconds(40)) {
    return Sequencer(
        {.window = window}, streams_, counters_,
        [](const StreamInfo&, StreamTable& streams) -> std::unique_ptr<Decoder> {
          return std::make_unique<BytePerRecord>(
              streams.add({.topic = "/sonic/wind", .kind = "wind", .role = StreamRole::derived}));
        },
        [this](const Sample& input, HostTime log_time) {
          inputs_.emplace_back(streams_.info(input.header.stream).topic, log_time);
        },
        [this](Sample&& sample, HostTime) {
          ordered_.push_back(
              {streams_.info(sample.header.stream).topic, to_ns(sample.header.sample_time) / 1'000'000, sample.header.status});
          samples_.push_back(std::move(sample));
        });
  }

  Sample frame(StreamId stream, std::uint32_t sequence, std::int64_t sample_ms, std::int64_t arrival_ms) {
    Sample sample;
    sample.header = {
        .stream = stream, .sequence = sequence, .arrival_time = at_ms(arrival_ms), .sample_time = at_ms(sample_ms)};
    sample.payload = Frame{};
    return sample;
  }

  StreamTable streams_;
  CounterTable counters_;
  StreamId camera0_ = streams_.add({.topic = "/camera0/image", .kind = "frame"});
  StreamId camera1_ = streams_.add({.topic = "/camera1/image", .kind = "frame"});
  StreamId sonic_ = streams_.add({.topic = "/sonic/raw", .kind = "raw_bytes"});
  std::vector<std::pair<std::string, HostTime>> inputs_;
  std::vector<Out> ordered_;
  std::vector<Sample> samples_;
};

TEST_F(SequencerTest, OrdersBySampleTimeThenStream) {
  auto sequencer = make();
  sequencer.take(frame(camera1_, 1, 100, 110));
  sequencer.take(frame(camera0_, 1, 100, 112));
  sequencer.take(frame(camera0_, 2, 95, 115));
  EXPECT_TRUE(ordered_.empty()) << "nothing leaves before the window has passed";
  sequencer.flush();
  EXPECT_THAT(ordered_,
              ElementsAre(Out{"/camera0/image", 95, 0}, Out{"/camera0/image", 100, 0}, Out{"/camera1/image", 100, 0}));
}

TEST_F(SequencerTest, LogTimesIncreaseStrictlyEvenWhenArrivalsDoNot) {
  auto sequencer = make();
  sequencer.take(frame(camera0_, 1, 100, 100));
  sequencer.take(frame(camera1_, 1, 90, 100));
  sequencer.take(frame(camera1_, 2, 95, 99));
  ASSERT_EQ(inputs_.size(), 3U);
  EXPECT_EQ(inputs_[1].second, at_ms(100) + Duration{1});
  EXPECT_EQ(inputs_[2].second, at_ms(100) + Duration{2});
}

TEST_F(SequencerTest, LateSampleComesAtOnceFlaggedAndCounted) {
  auto sequencer = make(milliseconds(10));
  sequencer.take(frame(camera0_, 1, 100, 100));
  sequencer.take(frame(camera0_, 2, 130, 130));  // lets the first go
  sequencer.take(frame(camera1_, 1, 50, 131));
  EXPECT_THAT(ordered_, ElementsAre(Out{"/camera0/image", 100, 0}, Out{"/camera1/image", 50, kStatusLate}));
  EXPECT_EQ(counters_.of(camera1_).late.load(), 1U);
}

TEST_F(SequencerTest, HoleInFrameNumbersIsAGapAndARepeatIsDropped) {
  auto sequencer = make();
  sequencer.take(frame(camera0_, 7, 10, 10));
  sequencer.take(frame(camera0_, 10, 20, 20));
  sequencer.take(frame(camera0_, 10, 30, 30));
  sequencer.flush();
  EXPECT_EQ(counters_.of(camera0_).gaps.load(), 2U);
  EXPECT_EQ(counters_.of(camera0_).bad.load(), 1U);
  ASSERT_EQ(samples_.size(), 3U);
  const Gap* gap = nullptr;
  for (const auto& sample : samples_) {
    if (sample.kind() == SampleKind::gap) gap = &std::get<Gap>(sample.payload);
  }
  ASSERT_NE(gap, nullptr);
  EXPECT_EQ(gap->missing, 2U);
  EXPECT_EQ(gap->expected_sequence, 8U);
}

TEST_F(SequencerTest, CounterWrapAndDeviceRestartAreNoGaps) {
  auto sequencer = make();
  sequencer.take(frame(camera0_, 0xFFFFFFFF, 10, 10));
  sequencer.take(frame(camera0_, 0, 20, 20));
  sequencer.take(frame(camera0_, 500, 30, 30));
  counters_.of(camera0_).gaps = 0;
  sequencer.take(frame(camera0_, 0, 40, 40));
  EXPECT_EQ(counters_.of(camera0_).gaps.load(), 0U);
}

TEST_F(SequencerTest, DecodesBytesBehindTheTap) {
  auto sequencer = make();
  Sample raw;
  raw.header = {.stream = sonic_, .arrival_time = at_ms(10), .sample_time = at_ms(10)};
  RawBytes bytes;
  bytes.size = 3;
  bytes.byte_time = milliseconds(1);
  raw.payload = bytes;
  sequencer.take(std::move(raw));
  sequencer.flush();
  EXPECT_THAT(inputs_, ElementsAre(std::pair<std::string, HostTime>("/sonic/raw", at_ms(10))));
  EXPECT_THAT(ordered_, ElementsAre(Out{"/sonic/wind", 10, 0}, Out{"/sonic/wind", 11, 0}, Out{"/sonic/wind", 12, 0}));
}

TEST_F(SequencerTest, StatedDelayWidensTheWindow) {
  const auto slow = streams_.add({.topic = "/slow/wind", .kind = "wind", .metadata = {{"delay_s", "0.125"}}});
  auto sequencer = make(milliseconds(10));
  auto wind = [&](std::uint32_t i) {
    Sample sample;
    sample.header = {.stream = slow, .sequence = i, .arrival_time = at_ms(i * 50), .sample_time = at_ms(i * 50 - 125)};
    sample.payload = WindSample{};
    return sample;
  };
  for (std::uint32_t i = 0; i < 10; ++i) {
    sequencer.take(wind(i));
    sequencer.take(frame(camera0_, i, i * 50 + 1, i * 50 + 1));
  }
  EXPECT_EQ(counters_.of(slow).late.load(), 0U);
}

TEST_F(SequencerTest, DeviceTimeIsMappedToTheHostsAxis) {
  const auto camera = streams_.add({.topic = "/camera2/image", .kind = "frame", .device = "camera2"});
  auto sequencer = make();
  for (std::uint32_t i = 0; i < 300; ++i) {
    auto sample = frame(camera, i, 0, 5000 + i * 33);
    sample.header.device_time = DeviceTime{milliseconds(i * 33)};
    sequencer.take(std::move(sample));
  }
  sequencer.flush();
  EXPECT_EQ(samples_.back().header.sample_time, at_ms(5000 + 299 * 33));
  ASSERT_EQ(sequencer.clocks().size(), 1U);
  EXPECT_EQ(sequencer.clocks()[0].device, "camera2");
  EXPECT_NEAR(sequencer.clocks()[0].offset_s, 5.0, 1e-6);
}

TEST_F(SequencerTest, SameInputsGiveTheSameOrder) {
  std::vector<Out> first;
  for (int run = 0; run < 2; ++run) {
    ordered_.clear();
    auto sequencer = make();
    for (std::uint32_t i = 0; i < 200; ++i) {
      sequencer.take(frame(i % 2 == 0 ? camera0_ : camera1_, i, (i * 7919) % 150 + i * 3, i * 5));
    }
    sequencer.flush();
    if (run == 0) first = ordered_;
  }
  EXPECT_EQ(first, ordered_);
}

}  // namespace
}  // namespace roseau::sync
