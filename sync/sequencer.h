// Sequencer: from the inputs of all devices, in the order it takes them, to one stream ordered by sample time.
//
//   input -> number it, tell the recorder -> decode, map clocks -> hold back for the window -> ordered output
//
// A pure function of the order of its inputs: it reads no clock and waits for nobody, so that a recorded order replayed gives
// the same output to the bit. One thread at a time; the callbacks run in it.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/decoder.h"
#include "core/sample.h"
#include "core/stream.h"
#include "sync/clock_model.h"
#include "sync/counters.h"

namespace roseau::sync {

class Sequencer {
 public:
  struct Options {
    /// How long a sample waits for older ones to arrive, on the axis of arrival times. Streams that state a longer constant
    /// delay (metadata "delay_s") widen it by themselves.
    Duration window = std::chrono::milliseconds(40);
  };

  /// Every input, numbered: `log_time` is its arrival time made strictly increasing. Raw, before any decoding.
  using InputTap = std::function<void(const Sample& input, HostTime log_time)>;
  /// Every sample in order of (sample time, topic, sequence). Late ones come at once, flagged kStatusLate.
  /// `log_time` is that of the input it came from.
  using OrderedOutput = std::function<void(Sample&& sample, HostTime log_time)>;
  /// A decoder for a stream of raw bytes, made at its first sample; none when nobody can decode it.
  using DecoderFactory = std::function<std::unique_ptr<Decoder>(const StreamInfo& raw_stream, StreamTable& streams)>;

  /// How long samples are held back when this stream is among the inputs: `window`, or more where the stream states a delay.
  static Duration window_for(const StreamInfo& stream, Duration window);

  Sequencer(Options options, StreamTable& streams, CounterTable& counters, DecoderFactory make_decoder, InputTap on_input,
            OrderedOutput on_ordered);
  ~Sequencer();

  void take(Sample input);
  /// No more inputs: passes on what is held back.
  void flush();

  /// The state of every device's clock, as of now.
  std::vector<ClockState> clocks() const;

 private:
  class Held;
  struct StreamState;
  struct ClockSlot {
    std::unique_ptr<ClockModel> model;
    StreamId topic = 0;
    HostTime last_reported;
    std::uint32_t reports = 0;
  };

  StreamState& state_of(StreamId stream);
  bool check_numbering(StreamState& state, Sample& sample);
  void map_clock(StreamState& state, Sample& sample);
  void report_clock(ClockSlot& clock, const std::string& device);
  void hold(Sample&& sample);
  void release_until(HostTime limit);

  Options options_;
  StreamTable& streams_;
  CounterTable& counters_;
  DecoderFactory make_decoder_;
  InputTap on_input_;
  OrderedOutput on_ordered_;

  std::vector<std::unique_ptr<StreamState>> stream_states_;  // by stream id
  std::map<std::string, ClockSlot> clocks_;                  // by device
  std::unique_ptr<Held> held_;
  HostTime log_time_{Duration::min()};
  HostTime released_until_{Duration::min()};
  Duration window_;
  StreamId gap_topic_;
  std::uint32_t gap_count_ = 0;
};

}  // namespace roseau::sync
