// Decoder of Gill's anemometers: raw bytes in, wind out, each sample stamped with the arrival of its record's first byte.
#pragma once

#include <cstdint>

#include "core/decoder.h"
#include "drivers/wire/gill_framer.h"
#include "drivers/wire/wind_master.h"
#include "drivers/wire/wind_sonic.h"

namespace roseau::wire {

/// How one model reads its records.
struct GillDialect {
  bool (*is_foreign)(const GillRecord& record);
  std::optional<WindSample> (*parse)(const GillRecord& record);
};
inline constexpr GillDialect kWindSonicDialect{&is_foreign_to_wind_sonic, &parse_wind_sonic};
inline constexpr GillDialect kWindMasterDialect{&is_foreign_to_wind_master, &parse_wind_master};

class GillDecoder : public Decoder {
 public:
  struct Options {
    StreamId stream = 0;                // of the wind samples
    Duration delay{0};                  // sample_time = arrival_time - delay
    bool keeps_messages_apart = false;  // each RawBytes that is not full ends a message
    char node = 0;                      // the instrument's letter where several share one line; 0 = any
    GillDialect dialect = kWindMasterDialect;
  };

  explicit GillDecoder(const Options& options) : options_(options) {}

  void decode(const Sample& raw, SampleSink& sink) override;
  void reset() override { framer_.reset(); }
  const DecoderCounters& counters() const override { return counters_; }

 private:
  void hand_on(const GillRecord& record, SampleSink& sink);

  Options options_;
  GillFramer framer_;
  std::uint64_t records_ = 0;
  std::uint64_t unreadable_records_ = 0;
  std::uint64_t foreign_records_ = 0;
  DecoderCounters counters_;
};

}  // namespace roseau::wire
