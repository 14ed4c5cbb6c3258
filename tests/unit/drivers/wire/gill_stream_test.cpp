// What can happen to the bytes between a Gill instrument and its decoder, for both models alike.
#include <gtest/gtest.h>

#include <ostream>
#include <random>

#include "drivers/wire/anemometer.h"
#include "drivers/wire/make_decoder.h"
#include "tests/unit/drivers/wire/decoder_support.h"

namespace roseau::wire {
namespace {

struct Instrument {
  std::string name;
  GillDialect dialect;
  std::string body;

  friend std::ostream& operator<<(std::ostream& out, const Instrument& instrument) { return out << instrument.name; }
};

class GillStream : public ::testing::TestWithParam<Instrument> {
 protected:
  std::string record() const { return framed(GetParam().body); }
  DecoderUnderTest make_decoder() const { return DecoderUnderTest(GetParam().dialect); }

  // Every kind of trouble once, with good records between. A fixed seed: the same trouble every time.
  std::string troubled_stream(std::size_t noise_bytes) const {
    std::mt19937 random(20261122);
    std::string noise;
    for (std::size_t i = 0; i < noise_bytes; ++i) noise += static_cast<char>(random() & 0xFFU);
    const auto good = record();
    const auto half = good.substr(0, good.size() / 2);
    auto wrong = good;
    wrong[3] = wrong[3] == '+' ? '-' : '9';
    std::string stream = good.substr(5);
    for (const auto& piece : {good,
                              good,
                              half,
                              good,
                              wrong,
                              good,
                              std::string(7, '\0'),
                              good,
                              noise,
                              std::string("\r\n"),
                              good,
                              std::string("\x02\x02\x02"),
                              good,
                              std::string("BANNER *PASS*\r\n"),
                              good,
                              good.substr(1),
                              good,
                              std::string("$WIMWV,39,R,1.3,M,A\r\n"),
                              good,
                              half}) {
      stream += piece;
    }
    return stream;
  }
};

INSTANTIATE_TEST_SUITE_P(Models, GillStream,
                         ::testing::Values(Instrument{"WindSonicPolar", kWindSonicDialect, "Q,229,002.74,M,00,"},
                                           Instrument{"WindSonicUv", kWindSonicDialect, "Q,+001.59,-002.74,M,00,"},
                                           Instrument{"WindMaster", kWindMasterDialect,
                                                      "Q,+000.04,-000.04,+000.06,M,+347.06,+025.88,00,"}),
                         [](const auto& instance) { return instance.param.name; });

TEST_P(GillStream, ArrivalIsThatOfTheFirstByteForEverySplit) {
  const auto text = "\r\nM2\r\n" + record();
  const auto first_byte = static_cast<Duration::rep>(text.find('\x02'));
  for (std::size_t split = 0; split <= text.size(); ++split) {
    auto decoder = make_decoder();
    decoder.feed(text.substr(0, split));
    decoder.feed(text.substr(split));
    ASSERT_EQ(decoder.samples().size(), 1U) << split;
    EXPECT_EQ(decoder.samples()[0].header.arrival_time, kFirstArrival + kByteTime * first_byte) << split;
    EXPECT_EQ(decoder.samples()[0].header.stream, 7);
  }
}

TEST_P(GillStream, ARecordEndsWithItsChecksum) {
  auto text = record();
  text.resize(text.size() - 2);
  auto decoder = make_decoder();
  decoder.feed(text);
  EXPECT_EQ(decoder.samples().size(), 1U);
}

TEST_P(GillStream, AnyTerminatorWillDo) {
  for (const char* terminator : {"\r\n", "\r", "\n", "", "\r\r\n"}) {
    std::string text = record();
    text.resize(text.size() - 2);
    text += terminator;
    auto decoder = make_decoder();
    for (int i = 0; i < 3; ++i) decoder.feed(text);
    EXPECT_EQ(decoder.samples().size(), 3U);
    EXPECT_EQ(decoder.counters().skipped_bytes, 0U);
  }
}

TEST_P(GillStream, GluedRecordsAndSingleBytesGiveTheSame) {
  const auto text = record() + record() + record();
  auto glued = make_decoder();
  glued.feed(text);
  auto single = make_decoder();
  single.feed_in_pieces(text, 1);
  EXPECT_EQ(glued.samples().size(), 3U);
  EXPECT_EQ(digest_of(single), digest_of(glued));
  EXPECT_EQ(glued.samples()[2].header.sequence, 2U);
}

TEST_P(GillStream, TroubleIsTheSameHoweverItIsCut) {
  const auto text = troubled_stream(3000);
  auto whole = make_decoder();
  whole.feed(text);
  for (std::size_t size = 1; size < 130; ++size) {
    auto cut = make_decoder();
    cut.feed_in_pieces(text, size);
    ASSERT_EQ(digest_of(cut), digest_of(whole)) << "pieces of " << size;
  }
}

TEST_P(GillStream, NoGoodRecordIsLostInTrouble) {
  auto decoder = make_decoder();
  decoder.feed(troubled_stream(0));
  // Ten whole records and one that lost its STX. Bad: one half, one with a wrong byte, the sentence without checksum.
  EXPECT_EQ(decoder.samples().size(), 11U);
  EXPECT_EQ(decoder.counters().bad_records, 3U);
}

TEST_P(GillStream, LowerCaseChecksumIsTakenAndOffByOneIsNot) {
  const auto& body = GetParam().body;
  auto digits = hex_byte(xor_of(body));
  std::ranges::transform(digits, digits.begin(), [](char c) { return c >= 'A' ? static_cast<char>(c - 'A' + 'a') : c; });
  auto decoder = make_decoder();
  decoder.feed(framed(body, digits));
  EXPECT_EQ(decoder.samples().size(), 1U);
  decoder.feed(framed(body, hex_byte(static_cast<std::uint8_t>(xor_of(body) + 1))));
  EXPECT_EQ(decoder.samples().size(), 1U);
  EXPECT_EQ(decoder.counters().bad_records, 1U);
}

TEST_P(GillStream, EverySingleBitErrorIsNoticed) {
  const auto good = record();
  for (std::size_t byte = 0; byte + 2 < good.size(); ++byte) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      auto damaged = good;
      damaged[byte] = static_cast<char>(static_cast<unsigned char>(damaged[byte]) ^ (1U << bit));
      auto decoder = make_decoder();
      decoder.feed(damaged + good);
      const bool is_digit_in_lower_case = byte + 4 >= good.size() && damaged[byte] >= 'a' && damaged[byte] <= 'f';
      const bool is_line_feed_for_stx = byte == 0 && damaged[byte] == '\n';  // the line still has its checksum
      const std::size_t expected = is_digit_in_lower_case || is_line_feed_for_stx ? 2 : 1;
      ASSERT_EQ(decoder.samples().size(), expected) << "byte " << byte << " bit " << bit;
    }
  }
}

TEST_P(GillStream, WrongBaudRateGivesNothing) {
  std::string noise;
  for (const char c : {'\x00', '\xff', '\xf8', '\x80', '\xfe', '\x00'}) noise.append(2000, c);
  auto decoder = make_decoder();
  decoder.feed(noise);
  EXPECT_TRUE(decoder.samples().empty());
  EXPECT_EQ(decoder.counters().bad_records, 0U);
  decoder.feed(record());
  EXPECT_EQ(decoder.samples().size(), 1U);
}

TEST_P(GillStream, SixtyFourKibibytesOfNoiseGiveNothing) {
  std::mt19937 random(1);
  std::string noise;
  for (int i = 0; i < 64 * 1024; ++i) noise += static_cast<char>(random() & 0xFFU);
  auto decoder = make_decoder();
  decoder.feed(noise);
  EXPECT_TRUE(decoder.samples().empty());
  decoder.feed("\r\n" + record());
  EXPECT_EQ(decoder.samples().size(), 1U);
}

// The framer's memory is a member of fixed size: what is tried here is that it never fills up.
TEST_P(GillStream, TenMegabytesWithoutTerminatorAreSkipped) {
  const std::vector<std::pair<std::string, std::size_t>> openings = {
      {"\x02Q,", 10'000'000}, {"", 500'000}, {"$WIMWV,", 500'000}, {"Q,", 500'000}};
  for (const auto& [opening, size] : openings) {
    auto decoder = make_decoder();
    decoder.feed(opening + std::string(size, '1'));
    EXPECT_TRUE(decoder.samples().empty());
    EXPECT_GT(decoder.counters().skipped_bytes, size - GillFramer::kLongestRecord - 3);
    decoder.feed("\r\n" + record());
    EXPECT_EQ(decoder.samples().size(), 1U);
  }
}

TEST_P(GillStream, StxInsideARecordBeginsAnother) {
  auto decoder = make_decoder();
  const auto good = record();
  decoder.feed(good.substr(0, 9) + good);
  EXPECT_EQ(decoder.samples().size(), 1U);
  EXPECT_EQ(decoder.counters().bad_records, 1U);
  EXPECT_EQ(decoder.samples()[0].header.arrival_time, kFirstArrival + kByteTime * 9);
}

TEST_P(GillStream, ResetForgetsAHalfRecord) {
  auto decoder = make_decoder();
  decoder.feed(record().substr(0, 10));
  decoder.decoder().reset();
  decoder.feed(record());
  EXPECT_EQ(decoder.samples().size(), 1U);
  EXPECT_EQ(decoder.counters().bad_records, 0U);
}

TEST_P(GillStream, DuplicatesAndBackwardArrivalsPassThroughUnjudged) {
  auto decoder = make_decoder();
  decoder.feed(record() + record());
  ASSERT_EQ(decoder.samples().size(), 2U);
  EXPECT_EQ(decoder.samples()[0].header.sequence, 0U);
  EXPECT_EQ(decoder.samples()[1].header.sequence, 1U);
}

TEST_P(GillStream, SampleTimeIsArrivalMinusDelay) {
  DecoderUnderTest decoder(GillDecoder::Options{.delay = std::chrono::milliseconds{125}, .dialect = GetParam().dialect});
  decoder.feed(record());
  ASSERT_EQ(decoder.samples().size(), 1U);
  const auto& header = decoder.samples()[0].header;
  EXPECT_EQ(header.arrival_time - header.sample_time, std::chrono::milliseconds{125});
}

TEST(Anemometer, DelaysFollowTheMakersTiming) {
  using enum AnemometerModel;
  EXPECT_DOUBLE_EQ(default_delay_s(gill_windsonic, 4, false), 0.125);
  EXPECT_DOUBLE_EQ(default_delay_s(gill_windmaster, 20, false), 0.050);
  EXPECT_DOUBLE_EQ(default_delay_s(gill_windmaster, 32, false), 0.03125);
  EXPECT_DOUBLE_EQ(default_delay_s(gill_windmaster, 1, true), 0.5);
}

TEST(Anemometer, ADecoderIsMadeFromTheStreamsMetadataAlone) {
  StreamTable streams;
  const auto raw = raw_stream(
      "sonic", {.model = AnemometerModel::gill_windsonic, .north_offset_deg = 235, .rate_hz = 4, .keeps_messages_apart = true},
      "udp-listen://0.0.0.0:5001");
  EXPECT_EQ(raw.topic, "/sonic/raw");
  EXPECT_EQ(raw.metadata.at("delay_s"), "0.125");
  const auto decoder = make_decoder(raw, streams);
  ASSERT_NE(decoder, nullptr);
  const auto wind = streams.find("/sonic/wind");
  ASSERT_TRUE(wind);
  const auto& info = streams.info(*wind);
  EXPECT_EQ(info.kind, "wind");
  EXPECT_EQ(info.role, StreamRole::derived);
  EXPECT_EQ(info.device, "sonic");
  EXPECT_EQ(info.metadata.at("axes"), "gill_spar");
  EXPECT_EQ(info.metadata.at("north_offset_deg"), "235");
  EXPECT_EQ(info.metadata.at("delay_s"), "0.125");
  EXPECT_FALSE(info.metadata.contains("link"));

  struct Collector : SampleSink {
    bool receive(Sample sample) override {
      samples.push_back(std::move(sample));
      return true;
    }
    std::vector<Sample> samples;
  } collector;
  const std::string_view line = "Q,229,002.74,M,00,";
  RawBytes bytes;
  bytes.size = static_cast<std::uint16_t>(line.size());
  std::ranges::transform(line, bytes.storage.begin(), [](char c) { return static_cast<std::byte>(c); });
  decoder->decode(Sample{.payload = bytes}, collector);
  ASSERT_EQ(collector.samples.size(), 1U) << "framing was not taken from the metadata";
  EXPECT_EQ(collector.samples[0].header.stream, *wind);
}

TEST(Anemometer, UnknownModelsAreNotDecoded) {
  StreamTable streams;
  EXPECT_EQ(make_decoder({.topic = "/tracker/raw"}, streams), nullptr);
  EXPECT_EQ(streams.size(), 0U);
  const auto model = anemometer_model_from_string("windmaster");
  ASSERT_FALSE(model);
  EXPECT_NE(model.error().message.find("gill_windsonic, gill_windmaster"), std::string::npos);
}

}  // namespace
}  // namespace roseau::wire
