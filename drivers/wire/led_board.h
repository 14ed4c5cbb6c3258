// LED synchronisation board: its text protocol, 8N1. Every line ends with CR LF and carries '*' and the XOR of what stands
// before in two hexadecimal digits.
//
//   T,<tick>,<us>,<seq>*XX           unasked, at a latch, every 256 ticks (128 ms): tick counter (32 bits), time since that
//   tick Q<seq> LF -> q,<seq>,<rx>,<tx>*XX    a question, and the board's microseconds when it came in and when the answer left
//   D,<us>,<0|1>*XX                  an edge on the board's input, at this many of its microseconds
//   B<us> LF -> B,<us>*XX            sets the length of a tick in microseconds; B alone asks for it
//   V LF -> V,<text>*XX              which board and firmware this is
//
// The board's microseconds count from its start, as its ticks do: tick = microseconds / tick length.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/decoder.h"
#include "core/sample.h"
#include "core/stream.h"
#include "drivers/wire/timed_bytes.h"

namespace roseau::wire {

inline constexpr std::uint32_t kLedBoardTick_us = 500;
inline constexpr std::uint32_t kLedBoardTicksPerMessage = 256;

/// One line that a board sends.
struct LedBoardMessage {
  enum class Kind : std::uint8_t { latch, answer, edge, tick_length, version };
  Kind kind = Kind::latch;
  std::uint32_t tick = 0;          // latch
  std::uint32_t microseconds = 0;  // latch: since the tick; tick_length: of a tick
  std::uint32_t sequence = 0;      // latch, answer
  std::uint64_t received_us = 0;   // answer: when the question came in; edge: when it was
  std::uint64_t sent_us = 0;       // answer
  bool is_rising = false;          // edge
  std::string text;                // version
};

/// The message in a line without its end; nothing when its checksum or its fields are wrong.
std::optional<LedBoardMessage> parse_led_board(std::string_view line);
/// With its checksum and CR LF.
std::string encode_led_board(const LedBoardMessage& message);

/// What a host asks: "Q17\n" and the like, without its end.
struct LedBoardCommand {
  enum class Kind : std::uint8_t { question, set_tick_length, ask_tick_length, version };
  Kind kind = Kind::question;
  std::uint32_t number = 0;  // question: its sequence; set_tick_length: microseconds
};
std::optional<LedBoardCommand> parse_led_board_command(std::string_view line);
/// With its line feed.
std::string encode_led_board_command(const LedBoardCommand& command);

// ---------------------------------------------------------------------------------------------------------------------

/// How a board's raw stream becomes board times: metadata of the raw stream, e.g. /led_board/raw.
///
///   model     led_board
///
///   tick_us   length of a tick, until the board says otherwise itself
///
///   link      where the bytes came from, for people
struct LedBoardOptions {
  std::uint32_t tick_us = kLedBoardTick_us;
};
StreamInfo raw_stream(const std::string& device, const LedBoardOptions& options, const std::string& link);

/// "/led_board/time" (latches), "/led_board/edge" and "/led_board/probe" (questions and answers).
StreamInfo led_board_stream(const StreamInfo& raw, std::string_view what);
inline constexpr std::string_view kLedBoardTime = "time";
inline constexpr std::string_view kLedBoardEdge = "edge";
inline constexpr std::string_view kLedBoardProbe = "probe";

/// The decoder of a board's raw stream, whose streams are added to `streams`; nothing for another model.
std::unique_ptr<Decoder> make_led_board_decoder(const StreamInfo& raw, StreamTable& streams);

class LedBoardDecoder : public Decoder {
 public:
  struct Options {
    std::uint32_t tick_us = kLedBoardTick_us;
    StreamId time_stream = 0;
    StreamId edge_stream = 0;
    StreamId probe_stream = 0;
  };

  explicit LedBoardDecoder(const Options& options) : options_(options), tick_us_(options.tick_us) {}

  void decode(const Sample& raw, SampleSink& sink) override;
  void reset() override;
  const DecoderCounters& counters() const override { return counters_; }

 private:
  enum class Step : std::uint8_t { went_on, needs_more };

  Step step(SampleSink& sink);
  Step skip(std::size_t count);
  void take(const LedBoardMessage& message, SampleSink& sink);
  void hand_on(StreamId stream, const LedBoardTime& time, std::uint32_t sequence, SampleSink& sink);
  LedBoardTime time_at(LedBoardTime::Event event, std::uint64_t board_us) const;
  DeviceTime unwrap(const LedBoardTime& time);

  static constexpr std::size_t kLongestLine = 96;

  Options options_;
  std::uint32_t tick_us_;
  TimedBytes<kLongestLine + 2> bytes_;
  std::uint32_t edges_ = 0;
  std::optional<std::int64_t> unwrapped_tick_;  // of the last event
  DecoderCounters counters_;
};

}  // namespace roseau::wire
