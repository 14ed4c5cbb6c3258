// Checksums made with Python: functools.reduce(operator.xor, b"T,256,0,1").
#include "drivers/wire/led_board.h"

#include <gtest/gtest.h>

#include <random>

#include "drivers/wire/make_decoder.h"
#include "tests/unit/drivers/wire/fed_decoder.h"

namespace roseau::wire {
namespace {

using namespace std::string_literals;
using Kind = LedBoardMessage::Kind;

TEST(LedBoardMessageTest, GoldenLines) {
  const auto latch = parse_led_board("T,256,0,1*48");
  ASSERT_TRUE(latch);
  EXPECT_EQ(latch->kind, Kind::latch);
  EXPECT_EQ(latch->tick, 256U);
  EXPECT_EQ(latch->sequence, 1U);
  const auto last = parse_led_board("T,4294967295,499,4294967295*4C");
  ASSERT_TRUE(last);
  EXPECT_EQ(last->tick, 4294967295U);
  EXPECT_EQ(last->microseconds, 499U);
  const auto answer = parse_led_board("q,17,123456789,123456812*56");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->kind, Kind::answer);
  EXPECT_EQ(answer->sequence, 17U);
  EXPECT_EQ(answer->received_us, 123456789U);
  EXPECT_EQ(answer->sent_us, 123456812U);
  const auto edge = parse_led_board("D,98765432,1*75");
  ASSERT_TRUE(edge);
  EXPECT_EQ(edge->kind, Kind::edge);
  EXPECT_TRUE(edge->is_rising);
  const auto tick = parse_led_board("B,500*5B");
  ASSERT_TRUE(tick);
  EXPECT_EQ(tick->microseconds, 500U);
  const auto version = parse_led_board("V,roseau LED board 1*43");
  ASSERT_TRUE(version);
  EXPECT_EQ(version->text, "roseau LED board 1");
}

TEST(LedBoardMessageTest, EncodesWhatItReads) {
  for (const LedBoardMessage& message :
       {LedBoardMessage{.kind = Kind::latch, .tick = 4'000'000'000, .microseconds = 3, .sequence = 77},
        LedBoardMessage{.kind = Kind::answer, .sequence = 5, .received_us = 9'000'000'000'000, .sent_us = 9'000'000'000'011},
        LedBoardMessage{.kind = Kind::edge, .received_us = 1, .is_rising = true},
        LedBoardMessage{.kind = Kind::edge, .received_us = 2}, LedBoardMessage{.kind = Kind::tick_length, .microseconds = 250},
        LedBoardMessage{.kind = Kind::version, .text = "a,b"}}) {
    const std::string line = encode_led_board(message);
    ASSERT_TRUE(line.ends_with("\r\n"));
    const auto back = parse_led_board(std::string_view(line).substr(0, line.size() - 2));
    ASSERT_TRUE(back) << line;
    EXPECT_EQ(encode_led_board(*back), line);
  }
  EXPECT_EQ(encode_led_board({.kind = Kind::latch, .tick = 256, .sequence = 1}), "T,256,0,1*48\r\n");
}

TEST(LedBoardMessageTest, WrongFieldsAreRefused) {
  const auto with_checksum = [](const std::string& body) {
    unsigned sum = 0;
    for (const char c : body) sum ^= static_cast<unsigned char>(c);
    const char* digits = "0123456789abcdef";  // lower case is taken
    return body + "*" + digits[sum >> 4U] + digits[sum & 15U];
  };
  EXPECT_TRUE(parse_led_board(with_checksum("T,1,2,3")));
  for (const char* body : {"T,1,2", "T,1,2,3,4", "T,-1,2,3", "T,4294967296,0,1", "T,1,1000001,1", "T,,2,3", "T,1 ,2,3", "D,1,2",
                           "D,1", "q,1,5,4", "q,1,5", "B,0", "B,x", "X,1", "T", ""}) {
    EXPECT_FALSE(parse_led_board(with_checksum(body))) << body;
  }
  EXPECT_FALSE(parse_led_board("T,256,0,1*49"));
  EXPECT_FALSE(parse_led_board("T,256,0,1*4"));
  EXPECT_FALSE(parse_led_board("T,256,0,1"));
}

TEST(LedBoardCommandTest, BothWays) {
  using Command = LedBoardCommand::Kind;
  EXPECT_EQ(encode_led_board_command({Command::question, 17}), "Q17\n");
  const auto question = parse_led_board_command("Q17");
  ASSERT_TRUE(question);
  EXPECT_EQ(question->number, 17U);
  EXPECT_EQ(parse_led_board_command("B250")->kind, Command::set_tick_length);
  EXPECT_EQ(parse_led_board_command("B")->kind, Command::ask_tick_length);
  EXPECT_EQ(parse_led_board_command("V")->kind, Command::version);
  for (const char* line : {"", "Q", "Q1x", "B0", "Z", "V1"}) EXPECT_FALSE(parse_led_board_command(line)) << line;
}

// ---------------------------------------------------------------------------------------------------------------------

class BoardUnderTest : public FedDecoder<LedBoardDecoder> {
 public:
  BoardUnderTest() : FedDecoder({.tick_us = 500, .time_stream = 1, .edge_stream = 2, .probe_stream = 3}) {}
  const LedBoardTime& time(std::size_t index) const { return std::get<LedBoardTime>(samples().at(index).payload); }
  std::int64_t device_ns(std::size_t index) const { return to_ns(*samples().at(index).header.device_time); }
};

std::string latch(std::uint32_t tick, std::uint32_t sequence = 0) {
  return encode_led_board({.kind = Kind::latch, .tick = tick, .sequence = sequence});
}

std::string digest_of(const BoardUnderTest& board) {
  std::string digest;
  for (std::size_t i = 0; i < board.samples().size(); ++i) {
    digest += std::to_string(to_ns(board.samples()[i].header.arrival_time)) + " " + std::to_string(board.device_ns(i)) + "\n";
  }
  return digest + describe(board.counters());
}

TEST(LedBoardStream, LatchesCarryTheBoardsTime) {
  BoardUnderTest board;
  board.feed(latch(256, 1) + encode_led_board({.kind = Kind::latch, .tick = 512, .microseconds = 7, .sequence = 2}));
  ASSERT_EQ(board.samples().size(), 2U);
  EXPECT_EQ(board.samples()[0].header.stream, 1);
  EXPECT_EQ(board.samples()[1].header.sequence, 2U);
  EXPECT_EQ(board.device_ns(0), 128'000'000);
  EXPECT_EQ(board.device_ns(1), 256'007'000);
  EXPECT_EQ(board.samples()[1].header.arrival_time, kFirstArrival + kByteTime * 14);
  EXPECT_EQ(board.time(1).event, LedBoardTime::Event::latch);
}

TEST(LedBoardStream, AnAnswerIsTwoTimes) {
  BoardUnderTest board;
  board.feed("q,17,123456789,123456812*56\r\n");
  ASSERT_EQ(board.samples().size(), 2U);
  EXPECT_EQ(board.time(0).event, LedBoardTime::Event::question_received);
  EXPECT_EQ(board.time(0).tick, 246913U);
  EXPECT_EQ(board.time(0).microseconds, 289U);
  EXPECT_EQ(board.time(1).event, LedBoardTime::Event::answer_sent);
  EXPECT_EQ(board.device_ns(1), 123'456'812'000);
  EXPECT_EQ(board.time(1).sequence, 17U);
  EXPECT_EQ(board.samples()[0].header.stream, 3);
}

TEST(LedBoardStream, EdgesGoTheirOwnWay) {
  BoardUnderTest board;
  board.feed("D,98765432,1*75\r\n" + encode_led_board({.kind = Kind::edge, .received_us = 98'765'500}));
  ASSERT_EQ(board.samples().size(), 2U);
  EXPECT_EQ(board.time(0).event, LedBoardTime::Event::rising_edge);
  EXPECT_EQ(board.time(1).event, LedBoardTime::Event::falling_edge);
  EXPECT_EQ(board.samples()[1].header.stream, 2);
  EXPECT_EQ(board.device_ns(0), 98'765'432'000);
  EXPECT_EQ(board.samples()[1].header.sequence, 1U);
}

TEST(LedBoardStream, TheTickCounterWraps) {
  BoardUnderTest board;
  board.feed(latch(4'294'967'040) + latch(0) + latch(256));
  EXPECT_EQ(board.device_ns(1) - board.device_ns(0), 128'000'000);
  EXPECT_EQ(board.device_ns(2) - board.device_ns(1), 128'000'000);
}

TEST(LedBoardStream, ABoardThatStartedAgainStepsBack) {
  BoardUnderTest board;
  board.feed(latch(100'000) + latch(256));
  EXPECT_EQ(board.device_ns(1), 128'000'000);
}

TEST(LedBoardStream, ASequenceThatJumpsIsPassedOn) {
  BoardUnderTest board;
  board.feed(latch(256, 1) + latch(1024, 4));
  EXPECT_EQ(board.samples()[1].header.sequence, 4U);
}

TEST(LedBoardStream, TheBoardsOwnWordOnItsTickCounts) {
  BoardUnderTest board;
  board.feed("B,250*59\r\n" + latch(256));
  ASSERT_EQ(board.samples().size(), 1U);
  EXPECT_EQ(board.device_ns(0), 64'000'000);
  EXPECT_EQ(board.counters().text_lines, 1U);
}

std::string troubled_stream(std::size_t noise_bytes) {
  std::mt19937 random(20261122);
  std::string noise;
  for (std::size_t i = 0; i < noise_bytes; ++i) noise += static_cast<char>(random() & 0xFFU);
  std::string stream = "6,0,1*48\r\n";
  for (const auto& piece : {latch(256, 1), latch(512, 2), "T,768,0,3*00\r\n"s, latch(1024, 4), "T,1280,"s, latch(1280, 5),
                            "roseau LED board starting\r\n"s, latch(1536, 6), std::string(5, '\0'), latch(1792, 7),
                            "T,"s + std::string(300, '1') + "\r\n", latch(2048, 8), noise, "\r\n"s, latch(2304, 9),
                            "D,98765432,1*75\n"s, "T,2560,0\r\n"s, latch(2816, 11), "q,1"s}) {
    stream += piece;
  }
  return stream;
}

TEST(LedBoardStream, NoGoodLineIsLostInTrouble) {
  BoardUnderTest board;
  board.feed(troubled_stream(0));
  EXPECT_EQ(board.samples().size(), 10U);
  EXPECT_EQ(board.counters().bad_records, 4U);  // wrong checksum, cut off, endless, without checksum
}

TEST(LedBoardStream, TroubleIsTheSameHoweverItIsCut) {
  const auto text = troubled_stream(4000);
  BoardUnderTest whole;
  whole.feed(text);
  for (std::size_t size = 1; size < 120; ++size) {
    BoardUnderTest cut;
    cut.feed_in_pieces(text, size);
    ASSERT_EQ(digest_of(cut), digest_of(whole)) << "pieces of " << size;
  }
}

TEST(LedBoardStream, EverySingleBitErrorIsNoticed) {
  const std::string good = latch(1'234'567, 99);
  for (std::size_t byte = 0; byte + 2 < good.size(); ++byte) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      auto damaged = good;
      damaged[byte] = static_cast<char>(static_cast<unsigned char>(damaged[byte]) ^ (1U << bit));
      BoardUnderTest board;
      board.feed(damaged + good);
      const bool is_lower_case = byte + 4 >= good.size() && damaged[byte] >= 'a' && damaged[byte] <= 'f';
      ASSERT_EQ(board.samples().size(), is_lower_case ? 2U : 1U) << "byte " << byte << " bit " << bit;
    }
  }
}

TEST(LedBoardStream, MegabytesWithoutALineAreSkipped) {
  std::mt19937 random(4);
  std::string noise;
  for (int i = 0; i < 64 * 1024; ++i) noise += static_cast<char>(random() & 0xFFU);
  for (const auto& text : {noise, "T,"s + std::string(1'000'000, '1'), std::string(500'000, 'T'), std::string(500'000, '*')}) {
    BoardUnderTest board;
    board.feed(text + "\r\n" + latch(256));
    EXPECT_EQ(board.samples().size(), 1U);
  }
}

TEST(LedBoardStream, ResetForgetsAHalfLine) {
  BoardUnderTest board;
  board.feed("T,12");
  board.decoder().reset();
  board.feed(latch(256));
  EXPECT_EQ(describe(board.counters()), "good 1 bad 0 skipped 0 text 0");
}

TEST(LedBoard, ADecoderIsMadeFromTheStreamsMetadataAlone) {
  StreamTable streams;
  const auto raw = raw_stream("led_board", LedBoardOptions{.tick_us = 250}, "serial:/dev/ttyACM0");
  EXPECT_EQ(raw.topic, "/led_board/raw");
  const auto decoder = make_decoder(raw, streams);
  ASSERT_NE(decoder, nullptr);
  for (const char* topic : {"/led_board/time", "/led_board/edge", "/led_board/probe"}) {
    const auto stream = streams.find(topic);
    ASSERT_TRUE(stream) << topic;
    EXPECT_EQ(streams.info(*stream).kind, "led_board_time");
    EXPECT_EQ(streams.info(*stream).device, "led_board");
  }
  struct Collector : SampleSink {
    bool receive(Sample sample) override {
      device_time = sample.header.device_time;
      return true;
    }
    std::optional<DeviceTime> device_time;
  } collector;
  const std::string line = latch(256);
  RawBytes bytes;
  bytes.size = static_cast<std::uint16_t>(line.size());
  std::ranges::transform(line, bytes.storage.begin(), [](char c) { return static_cast<std::byte>(c); });
  decoder->decode(Sample{.payload = bytes}, collector);
  ASSERT_TRUE(collector.device_time);
  EXPECT_EQ(to_ns(*collector.device_time), 64'000'000) << "tick_us was not taken from the metadata";
}

}  // namespace
}  // namespace roseau::wire
