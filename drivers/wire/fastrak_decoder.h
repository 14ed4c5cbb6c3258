// Decoder of a FASTRAK: raw bytes in, station poses out, each stamped with the arrival of its record's first byte.
//
// Text and binary records are told apart by what they hold, so that a tracker switched from one to the other is read on. The
// layout is the configured one. The unit is the configured one until the tracker itself says which it uses (answer to S).
// After damage the search goes on one byte further, so that no good record behind it is lost.
#pragma once

#include <array>
#include <functional>

#include "core/decoder.h"
#include "drivers/wire/fastrak.h"
#include "drivers/wire/timed_bytes.h"

namespace roseau::wire {

class FastrakDecoder : public Decoder {
 public:
  struct Options {
    FastrakLayout layout = default_fastrak_layout();
    FastrakUnit unit = FastrakUnit::inch;
    Duration delay{0};  // sample_time = arrival_time - delay
    /// Stream of a station's poses, asked once per station, when it is first seen.
    std::function<StreamId(int station)> stream_of_station;
  };

  explicit FastrakDecoder(Options options) : options_(std::move(options)), unit_(options_.unit) {}

  void decode(const Sample& raw, SampleSink& sink) override;
  void reset() override;
  const DecoderCounters& counters() const override { return counters_; }

 private:
  enum class Step : std::uint8_t { went_on, needs_more };
  struct Station {
    std::optional<StreamId> stream;
    std::uint32_t records = 0;
  };

  Step step(SampleSink& sink);
  Step match_record(SampleSink& sink);
  Step match_answer();
  Step skip_byte(bool looked_like_a_record);
  void hand_on(const StationPose& pose, SampleSink& sink);
  void used(std::size_t count);

  // The longest record and the longest line of text fit.
  static constexpr std::size_t kLongest = 256;

  Options options_;
  FastrakUnit unit_;
  TimedBytes<kLongest> bytes_;
  bool in_step_ = false;  // what came before was understood to its last byte
  std::array<Station, kFastrakStations> stations_{};
  DecoderCounters counters_;
};

}  // namespace roseau::wire
