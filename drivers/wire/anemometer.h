// Anemometers we can read, and how their raw bytes become wind. What a stream's metadata says is all that a decoder needs:
// the same one is made live and from a recorded session.
//
//   key               of the raw stream, e.g. /sonic/raw; the wind stream /sonic/wind carries all but the last two on
//
//   model             gill_windsonic, gill_windmaster
//
//   axes              gill_spar, gill_axis (core/wind_geometry.h)
//
//   north_offset_deg  azimuth of the instrument's north mark
//
//   rate_hz           output rate the instrument is set to
//
//   delay_s           from the middle of the time a record stands for to its first byte: sample_time = arrival - delay
//
//   framing           stream; messages where each read was a whole message (UDP)
//
//   link              where the bytes came from, for people
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/decoder.h"
#include "core/result.h"
#include "core/stream.h"
#include "core/wind_geometry.h"

namespace roseau::wire {

enum class AnemometerModel : std::uint8_t { gill_windsonic, gill_windmaster };
std::string_view to_string(AnemometerModel model);
Result<AnemometerModel> anemometer_model_from_string(std::string_view name);

/// The constant delay of a model by its maker's timing, where nothing better was measured (reference: A.7 of the protocol
/// notes). WindSonic: half its output period, over which it averages. WindMaster: half its output period if it is set to
/// average, else one period of its internal sampling (20 Hz; 32 Hz for outputs of 8, 16 and 32 Hz).
double default_delay_s(AnemometerModel model, double rate_hz, bool is_averaging);

struct AnemometerOptions {
  AnemometerModel model = AnemometerModel::gill_windmaster;
  WindAxes axes = WindAxes::gill_spar;
  double north_offset_deg = 0;
  double rate_hz = 1;             // both models' factory setting
  bool is_averaging = false;      // WindMaster only
  std::optional<double> delay_s;  // default_delay_s unless given
  char node = 0;                  // 0 = any
  bool keeps_messages_apart = false;
};

/// The raw stream "/<device>/raw" of an anemometer, with the metadata above.
StreamInfo raw_stream(const std::string& device, const AnemometerOptions& options, const std::string& link);

/// The wind stream that belongs to a raw one: "/sonic/raw" -> "/sonic/wind".
StreamInfo wind_stream(const StreamInfo& raw);

/// The decoder of an anemometer's raw stream, whose wind stream is added to `streams`; nothing when the model is none of these.
std::unique_ptr<Decoder> make_anemometer_decoder(const StreamInfo& raw, StreamTable& streams);

}  // namespace roseau::wire
