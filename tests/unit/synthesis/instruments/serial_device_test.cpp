#include "synthesis/instruments/serial_device.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/unit/synthesis/instruments/simulated_field.h"

namespace roseau::synthesis {
namespace {

// "record 000012;" ten times a second, at 1000 baud: 10 ms a byte, 140 ms a record would not fit, so 10000 baud: 14 ms.
class Talker final : public SerialInstrument {
 public:
  explicit Talker(const DeviceTiming& timing, SerialLineOptions line = {.baud = 10000}, std::size_t length = 14)
      : times_(10, timing, 1, 1), line_(line), length_(length) {}
  const std::string& name() const override { return name_; }
  StreamInfo raw_stream(const std::string& link) const override {
    return {.topic = "/talker/raw", .kind = "raw_bytes", .device = name_, .metadata = {{"link", link}}};
  }
  const SampleTimes& times() const override { return times_; }
  const SerialLineOptions& line() const override { return line_; }
  std::string record(std::uint64_t number) const override {
    std::string text = fmt::format("record {:06};", number);
    text.resize(length_, '.');
    return text;
  }

 private:
  std::string name_ = "talker";
  SampleTimes times_;
  SerialLineOptions line_;
  std::size_t length_;
};

std::string text_of(const std::vector<Sample>& samples) {
  std::string text;
  for (const Sample& sample : samples) {
    for (const std::byte byte : std::get<RawBytes>(sample.payload).bytes()) text += static_cast<char>(byte);
  }
  return text;
}

SerialDevice device_of(const DeviceTiming& timing, SerialLineOptions line = {.baud = 10000}, std::size_t length = 14) {
  return {std::make_shared<Talker>(timing, line, length), 5, 77};
}

TEST(SerialDevice, EveryRecordComesAfterItsDelayByteByByte) {
  auto device = device_of({.latency_s = 0.02});
  StreamTable streams;
  const auto samples = play(device, 1, streams);
  ASSERT_EQ(samples.size(), 10U);
  EXPECT_EQ(streams.info(samples[0].header.stream).topic, "/talker/raw");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_NEAR(to_seconds(samples[i].header.arrival_time - kSceneStart), 0.02 + 0.1 * static_cast<double>(i), 1e-9);
    EXPECT_EQ(samples[i].header.sequence, i);
  }
  EXPECT_EQ(text_of(samples).substr(0, 28), "record 000000;record 000001;");
  EXPECT_EQ(device.next().complete - device.next().arrival, std::chrono::milliseconds(14));
}

TEST(SerialDevice, ABusyLineMakesRecordsWaitOrLosesThem) {
  // 30 bytes take 0.12 s at 2500 baud, and a record comes every 0.1 s.
  auto waiting = device_of({}, {.baud = 2500}, 30);
  StreamTable streams;
  const auto late = play(waiting, 1.2, streams);
  EXPECT_NEAR(to_seconds(late[5].header.arrival_time - kSceneStart), 0.6, 1e-9);
  EXPECT_EQ(text_of(late).substr(30 * 5, 13), "record 000005");
  auto discarding = device_of({}, {.baud = 2500, .discards_when_busy = true}, 30);
  const auto lost = play(discarding, 1.2, streams);
  ASSERT_GE(lost.size(), 6U);
  EXPECT_NEAR(to_seconds(lost[1].header.arrival_time - kSceneStart), 0.2, 1e-9);
  EXPECT_EQ(text_of(lost).substr(30, 13), "record 000002");
}

TEST(SerialDevice, SplitRecordsLoseNothing) {
  auto whole = device_of({});
  auto split = device_of({}, {.baud = 10000, .split_probability = 0.5});
  StreamTable streams;
  const auto one = play(whole, 20, streams);
  const auto two = play(split, 20, streams);
  EXPECT_GT(two.size(), one.size() + 60);
  EXPECT_EQ(text_of(two), text_of(one));
  for (std::size_t i = 1; i < two.size(); ++i) EXPECT_GT(two[i].header.arrival_time, two[i - 1].header.arrival_time);
}

TEST(SerialDevice, LongRecordsComeInPiecesThatFit) {
  auto device = device_of({}, {.baud = 115200}, 500);
  StreamTable streams;
  const auto samples = play(device, 0.09, streams);
  ASSERT_EQ(samples.size(), 3U);
  EXPECT_EQ(text_of(samples).size(), 500U);
  EXPECT_EQ(samples[1].header.arrival_time - samples[0].header.arrival_time,
            std::get<RawBytes>(samples[0].payload).byte_time * RawBytes::kCapacity);
}

TEST(SerialDevice, BytesErrAsOftenAsAsked) {
  auto clean = device_of({});
  auto noisy = device_of({}, {.baud = 10000, .byte_error_probability = 0.01});
  StreamTable streams;
  const std::string sent = text_of(play(clean, 500, streams));
  const std::string got = text_of(play(noisy, 500, streams));
  ASSERT_EQ(got.size(), sent.size());
  int errors = 0;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const auto difference =
        static_cast<unsigned char>(static_cast<unsigned char>(sent[i]) ^ static_cast<unsigned char>(got[i]));
    errors += difference != 0 ? 1 : 0;
    EXPECT_EQ(difference & (difference - 1), 0) << "one bit";
  }
  EXPECT_NEAR(errors, 700, 100);
}

TEST(SerialDevice, APulledCableCutsRecordsAndSilencesTheRest) {
  // Record 3 is on the line from 0.300 to 0.314; record 7 from 0.700 on.
  auto device = device_of({.cable_pulls_s = {0.305, 0.7071}});
  StreamTable streams;
  const auto samples = play(device, 1, streams);
  EXPECT_EQ(text_of(samples),
            "record 000000;record 000001;record 000002;"
            "recor"
            "00007;"
            "record 000008;record 000009;");
  EXPECT_FALSE(device.fault_at(from_seconds(0.3)));
  const auto fault = device.fault_at(from_seconds(0.5));
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->code, ErrorCode::disconnected);
  EXPECT_NE(fault->message.find("talker"), std::string::npos);
}

TEST(SerialDevice, ACableThatStaysOutIsTheEnd) {
  auto device = device_of({.cable_pulls_s = {0.5, 1e12}});
  StreamTable streams;
  EXPECT_EQ(play(device, 1e6, streams).size(), 5U);
  EXPECT_EQ(device.next().arrival, Due::never().arrival);
}

TEST(SerialDevice, ALongPullIsPassedOverQuicklyAndExactly) {
  auto device = device_of({.cable_pulls_s = {0.45, 100'000}});
  StreamTable streams;
  const auto samples = play(device, 100'000.25, streams);
  EXPECT_EQ(text_of(samples).substr(5 * 14), "record 1000000record 1000001record 1000002");
}

TEST(SerialDevice, LostRecordsLeaveHoles) {
  auto device = device_of({.drop_probability = 0.2});
  StreamTable streams;
  const auto samples = play(device, 1000, streams);
  EXPECT_NEAR(static_cast<double>(samples.size()), 8000, 200);
}

TEST(SerialDevice, WhoConnectsLateMissesWhatWasSent) {
  auto device = device_of({});
  StreamTable streams;
  device.declare(streams);
  device.connect_at(from_seconds(3600.05));
  CollectorSink sink;
  device.produce(kSceneStart, sink);
  EXPECT_EQ(text_of(sink.samples), "record 036001;");
}

TEST(SerialDevice, IsAFunctionOfItsSeed) {
  StreamTable streams;
  const auto play_with = [&](std::uint64_t seed) {
    SerialDevice device(std::make_shared<Talker>(DeviceTiming{}, SerialLineOptions{.baud = 10000, .split_probability = 0.5}),
                        seed, 1);
    return play(device, 5, streams).size();
  };
  EXPECT_EQ(play_with(3), play_with(3));
  EXPECT_NE(play_with(3), play_with(4));
}

}  // namespace
}  // namespace roseau::synthesis
