#include "drivers/sonic/sonic_source.h"

#include <gtest/gtest.h>

#include <deque>

#include "drivers/link/file_stream.h"
#include "drivers/link/link_spec.h"
#include "drivers/link/pty_stream.h"
#include "drivers/link/udp_stream.h"
#include "drivers/wire/make_decoder.h"
#include "drivers/wire/wind_master.h"
#include "drivers/wire/wind_sonic.h"
#include "tests/support/temporary_folder.h"

namespace roseau::sonic {
namespace {

using std::chrono::milliseconds;

struct Collector : SampleSink {
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  std::vector<Sample> samples;
};

// Gives what it was told to give, then fails.
class ScriptedStream : public link::ByteStream {
 public:
  struct Step {
    std::string bytes;
    HostTime first_byte_time;
    std::uint16_t line_errors = 0;
  };
  explicit ScriptedStream(std::deque<Step> steps) : steps_(std::move(steps)) {}

  Result<void> open() override { return {}; }
  Result<link::Received> read(std::span<std::byte> buffer, milliseconds /*timeout*/) override {
    if (steps_.empty()) return Error{ErrorCode::disconnected, "scripted port is disconnected"};
    const Step step = steps_.front();
    steps_.pop_front();
    std::ranges::copy(std::as_bytes(std::span(step.bytes)), buffer.begin());
    return link::Received{step.bytes.size(), step.first_byte_time, step.line_errors};
  }
  Result<void> write(std::span<const std::byte> /*bytes*/) override { return {}; }
  void close() override {}
  std::string description() const override { return "scripted port"; }
  Duration byte_time() const override { return milliseconds{1}; }

 private:
  std::deque<Step> steps_;
};

std::span<const std::byte> bytes_in(const Sample& sample) { return std::get<RawBytes>(sample.payload).bytes(); }

TEST(SonicSource, DeclaresBothStreamsWithTheirMetadata) {
  SonicSource source({.name = "mast",
                      .anemometer = {.model = wire::AnemometerModel::gill_windmaster, .north_offset_deg = 12.5, .rate_hz = 20}},
                     std::make_unique<ScriptedStream>(std::deque<ScriptedStream::Step>{}));
  StreamTable streams;
  ASSERT_TRUE(source.open(streams));
  const auto raw = streams.find("/mast/raw");
  const auto wind = streams.find("/mast/wind");
  ASSERT_TRUE(raw && wind);
  EXPECT_EQ(streams.info(*raw).role, StreamRole::raw);
  EXPECT_EQ(streams.info(*raw).metadata.at("model"), "gill_windmaster");
  EXPECT_EQ(streams.info(*raw).metadata.at("link"), "scripted port");
  EXPECT_EQ(streams.info(*raw).metadata.at("delay_s"), "0.05");
  EXPECT_EQ(streams.info(*wind).metadata.at("north_offset_deg"), "12.5");
  ASSERT_TRUE(source.open(streams));
  EXPECT_EQ(streams.size(), 2U) << "opening twice declares the same topics";
}

TEST(SonicSource, SplitsLongReadsWithTheRightTimes) {
  const HostTime start{std::chrono::seconds{10}};
  std::string bytes;
  for (int i = 0; i < 500; ++i) bytes += static_cast<char>(i);
  SonicSource source({}, std::make_unique<ScriptedStream>(
                             std::deque<ScriptedStream::Step>{{bytes, start, 3}, {"x", start + milliseconds{900}}}));
  StreamTable streams;
  ASSERT_TRUE(source.open(streams));
  Collector collector;
  EXPECT_EQ(*source.read(collector, milliseconds{0}), ReadStatus::more);
  EXPECT_EQ(*source.read(collector, milliseconds{0}), ReadStatus::more);
  ASSERT_EQ(collector.samples.size(), 4U);
  std::string joined;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& sample = collector.samples[i];
    EXPECT_EQ(sample.header.stream, *streams.find("/sonic/raw"));
    EXPECT_EQ(sample.header.sequence, i);
    const HostTime expected = i < 3 ? start + milliseconds{224 * static_cast<int>(i)} : start + milliseconds{900};
    EXPECT_EQ(sample.header.arrival_time, expected);
    EXPECT_EQ(std::get<RawBytes>(sample.payload).line_errors, i == 0 ? 3 : 0);
    EXPECT_EQ(std::get<RawBytes>(sample.payload).byte_time, milliseconds{1});
    for (const auto byte : bytes_in(sample)) joined += static_cast<char>(byte);
  }
  EXPECT_EQ(joined, bytes + "x");
}

TEST(SonicSource, ALostPortIsAnErrorForTheSupervisor) {
  SonicSource source({}, std::make_unique<ScriptedStream>(std::deque<ScriptedStream::Step>{}));
  StreamTable streams;
  ASSERT_TRUE(source.open(streams));
  Collector collector;
  const auto status = source.read(collector, milliseconds{0});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::disconnected);
}

TEST(SonicSource, APortThatCannotBeOpenedDeclaresNothing) {
  SonicSource source({}, std::make_unique<link::FileStream>("/does/not/exist", Duration{0}));
  StreamTable streams;
  EXPECT_FALSE(source.open(streams));
  EXPECT_EQ(streams.size(), 0U);
}

// Instrument -> wire -> port -> source -> decoder: what went in comes out.
TEST(SonicSource, WindTravelsThroughARealPort) {
  link::PtyStream instrument;
  ASSERT_TRUE(instrument.open());
  SonicSource source({.anemometer = {.model = wire::AnemometerModel::gill_windmaster, .rate_hz = 20}},
                     *link::make_byte_stream("serial:" + instrument.port_path() + "?baud=19200"));
  StreamTable streams;
  ASSERT_TRUE(source.open(streams));
  EXPECT_TRUE(source.is_live());
  const auto decoder = wire::make_decoder(streams.info(*streams.find("/sonic/raw")), streams);
  ASSERT_NE(decoder, nullptr);
  Collector raw;
  Collector wind;
  for (int i = 0; i < 50; ++i) {
    const WindSample sent{
        .u_mps = i * 0.1, .v_mps = -i * 0.2, .w_mps = 0.01 * i, .sonic_temperature_celsius = 20, .speed_of_sound_mps = 343};
    ASSERT_TRUE(instrument.write(wire::encode_wind_master(sent, {})));
    ASSERT_TRUE(source.read(raw, milliseconds{100}));
  }
  for (int i = 0; i < 20 && wind.samples.size() < 50; ++i) {
    for (const auto& sample : raw.samples) decoder->decode(sample, wind);
    raw.samples.clear();
    ASSERT_TRUE(source.read(raw, milliseconds{10}));
  }
  ASSERT_EQ(wind.samples.size(), 50U);
  HostTime before{};
  for (std::size_t i = 0; i < 50; ++i) {
    const auto& sample = wind.samples[i];
    EXPECT_NEAR(std::get<WindSample>(sample.payload).v_mps, -0.2 * static_cast<double>(i), 0.0051);
    EXPECT_GE(sample.header.arrival_time, before);
    EXPECT_EQ(sample.header.arrival_time - sample.header.sample_time, milliseconds{50});
    before = sample.header.arrival_time;
  }
  const std::string path = instrument.port_path();
  instrument.close();
  Result<ReadStatus> status = ReadStatus::more;
  for (int i = 0; i < 10 && status; ++i) status = source.read(raw, milliseconds{20});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::disconnected);
}

TEST(SonicSource, BareDatagramsAreDecodedOneByOne) {
  auto receiver = std::make_unique<link::UdpStream>(link::UdpRole::listen, "127.0.0.1", 0);
  auto* port = receiver.get();
  SonicSource source({.anemometer = {.model = wire::AnemometerModel::gill_windmaster}}, std::move(receiver));
  StreamTable streams;
  ASSERT_TRUE(source.open(streams));
  EXPECT_EQ(streams.info(*streams.find("/sonic/raw")).metadata.at("framing"), "messages");
  const auto decoder = wire::make_decoder(streams.info(*streams.find("/sonic/raw")), streams);
  link::UdpStream sender(link::UdpRole::send, "127.0.0.1", port->port());
  ASSERT_TRUE(sender.open());
  Collector raw;
  Collector wind;
  for (int i = 0; i < 3; ++i) {
    const WindSample sent{.u_mps = 1.0 * i, .v_mps = 0, .w_mps = 0};
    ASSERT_TRUE(sender.write(wire::encode_wind_master(sent, {.is_delimited = false, .ends_with_line = false})));
    ASSERT_TRUE(source.read(raw, milliseconds{500}));
  }
  for (const auto& sample : raw.samples) decoder->decode(sample, wind);
  ASSERT_EQ(wind.samples.size(), 3U);
  EXPECT_DOUBLE_EQ(std::get<WindSample>(wind.samples[2].payload).u_mps, 2.0);
}

TEST(SonicSource, AFileEnds) {
  const testing::TemporaryFolder folder;
  std::string records;
  for (int i = 0; i < 100; ++i) {
    for (const auto byte : wire::encode_wind_sonic({.u_mps = 1, .v_mps = 2}, {})) records += static_cast<char>(byte);
  }
  SonicSource source({.anemometer = {.model = wire::AnemometerModel::gill_windsonic, .rate_hz = 4}},
                     *link::make_byte_stream("file:" + folder.write("sonic.bin", records) + "?baud=9600"));
  StreamTable streams;
  ASSERT_TRUE(source.open(streams));
  EXPECT_FALSE(source.is_live());
  const auto decoder = wire::make_decoder(streams.info(*streams.find("/sonic/raw")), streams);
  Collector raw;
  ReadStatus status = ReadStatus::more;
  for (int i = 0; i < 100 && status != ReadStatus::finished; ++i) status = *source.read(raw, milliseconds{0});
  EXPECT_EQ(status, ReadStatus::finished);
  Collector wind;
  for (const auto& sample : raw.samples) decoder->decode(sample, wind);
  ASSERT_EQ(wind.samples.size(), 100U);
  // 29 bytes of 10 bits at 9600 baud between one record and the next.
  const auto spacing = wind.samples[99].header.arrival_time - wind.samples[98].header.arrival_time;
  EXPECT_NEAR(to_seconds(spacing), 29 * 10 / 9600.0, 1e-6);
}

}  // namespace
}  // namespace roseau::sonic
