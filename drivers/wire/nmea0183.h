// NMEA 0183 sentences of weather instruments:
//
//   $WIMWV,214.8,R,0.1,K,A*28                       wind: angle, R or T, speed, unit, status A or V
//   $WIMDA,29.7544,I,1.0076,B,35.5,C,,,42.1,,20.6,C,116.4,T,107.7,M,1.2,N,0.6,M*66         weather, wind from true north
//   $WIXDR,A,302,D,1,S,0.1,M,1*hh                   transducers, in groups of four: type, value, unit, name
//   $GPZDA,160012.71,11,03,2004,-1,00*hh            date and time;  $GPRMC,123519,A,...,230394,... : time, position valid, date
//
// The checksum is the XOR of everything between '$' and '*'. Angles run clockwise, from where the wind comes. MWV's R counts
// from the instrument's mark; T is what some ships work out for standing still, not an angle from north. MDA's counts from
// true north. What is missing is empty.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/decoder.h"
#include "core/result.h"
#include "core/stream.h"
#include "drivers/wire/timed_bytes.h"

namespace roseau::wire {

/// Longest sentence we take, from '$' to the checksum. The standard's limit of 82 is not kept by all (MDA, XDR).
inline constexpr std::size_t kLongestSentence = 220;

/// "$" body "*" HH CR LF
std::string nmea_sentence(std::string_view body);

/// The body of a whole sentence without its line end, "$...*HH"; nothing if the checksum is wrong, or missing and required.
std::optional<std::string_view> nmea_body(std::string_view sentence, bool requires_checksum = true);

/// "WIMWV,..." -> "MWV"; empty for what is no standard sentence (proprietary ones begin with P).
std::string_view nmea_kind(std::string_view body);

enum class NmeaWindSource : std::uint8_t {
  mwv_relative,  // MWV with R
  mwv_true,      // MWV with T
  mda,
  xdr,  // an angle (A, in D) and a speed (S) of one name; of three such names the second: minimum, average, maximum
};
std::string_view to_string(NmeaWindSource source);
Result<NmeaWindSource> nmea_wind_source_from_string(std::string_view name);

struct NmeaXdr {
  struct Transducer {
    char type = 0;
    double value = 0;  // NaN: empty
    char unit = 0;     // 0: none
    std::string name;
  };
  std::vector<Transducer> transducers;
};
std::optional<NmeaXdr> parse_nmea_xdr(std::string_view body);

/// What MDA tells besides: NaN where empty.
struct NmeaWeather {
  double pressure_hpa = 0;
  double air_temperature_celsius = 0;
  double relative_humidity_percent = 0;
  double wind_from_true_deg = 0;
  double wind_mps = 0;
};
std::optional<NmeaWeather> parse_nmea_mda(std::string_view body);

/// True: a good sentence that tells nothing about this wind.
bool is_foreign_to_nmea_wind(std::string_view body, NmeaWindSource source);

/// The wind in a sentence's body, in the axes gill_spar (angles from the mark, or for MDA from north); nothing when its
/// fields make no sense. `valid` is false and values are NaN where the status is V or fields are empty.
std::optional<WindSample> parse_nmea_wind(std::string_view body, NmeaWindSource source);

/// Civil time (UTC) as nanoseconds since 1970, of a ZDA or a valid RMC; nothing for any other sentence.
std::optional<Duration> parse_nmea_time(std::string_view body);

/// Sentences as instruments send them, with checksum and CR LF. Wind: angle to 0.1 degree, speed to 0.01 m/s.
std::string encode_nmea_wind(const WindSample& sample, NmeaWindSource source, std::string_view talker = "WI");
std::string encode_nmea_zda(Duration since_1970, std::string_view talker = "GP");

/// Decoder: raw bytes in, wind out, each sample stamped with the arrival of its sentence's '$'. After damage the search goes
/// on one byte further. Holds at most kLongestSentence + 4 bytes back.
class NmeaDecoder : public Decoder {
 public:
  struct Options {
    StreamId stream = 0;
    Duration delay{0};  // sample_time = arrival_time - delay
    NmeaWindSource source = NmeaWindSource::mwv_relative;
    bool requires_checksum = true;
  };

  explicit NmeaDecoder(const Options& options) : options_(options) {}

  void decode(const Sample& raw, SampleSink& sink) override;
  void reset() override;
  const DecoderCounters& counters() const override { return counters_; }

 private:
  bool step(SampleSink& sink);
  bool skip_to_start();
  bool give_up();
  void take(std::string_view body, SampleSink& sink);

  Options options_;
  TimedBytes<kLongestSentence + 4> bytes_;
  bool is_inside_text_ = false;  // bytes that belong to no sentence were passed on this line
  DecoderCounters counters_;
};

inline constexpr std::string_view kNmeaModel = "nmea0183";

struct NmeaOptions {
  NmeaWindSource source = NmeaWindSource::mwv_relative;
  bool requires_checksum = true;
  double north_offset_deg = 0;
  double rate_hz = 1;
  double delay_s = 0;
};

/// The raw stream "/<device>/raw": metadata model, axes, north_offset_deg, rate_hz, delay_s, link, and
///   sentence   mwv_r, mwv_t, mda, xdr: which one the wind is read from
///   checksum   required, optional
StreamInfo raw_stream(const std::string& device, const NmeaOptions& options, const std::string& link);

/// The decoder of a raw stream whose model is nmea0183; its wind stream is added to `streams`. Nothing otherwise.
std::unique_ptr<Decoder> make_nmea_decoder(const StreamInfo& raw, StreamTable& streams);

}  // namespace roseau::wire
