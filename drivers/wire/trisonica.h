// Anemoment TriSonica Mini (3-D ultrasonic anemometer), text: one line per record, pairs of a tag and a value. Which tags
// come, in which order and with how many decimals, is set on the instrument. As it is delivered for field work:
//
//   S2  02.222 D  255 U  02.142 V  00.592 W  00.040 T  23.80 H  29.14 AD  0.9655064 AX    336 AY   -648 AZ  17176 MD  349 CR LF
//
//   S, S2       speed in space, horizontal speed, m/s      T           sonic temperature, degrees Celsius
//   D, DV       direction from, elevation, degrees         H, P, AD    humidity %, pressure hPa, air density kg/m3
//   U, V, W     to the east, north and up of the mark      AX AY AZ    accelerometer; MX MY MZ magnetometer
//   MD          magnetic heading of the mark, degrees      PI, RO      pitch and roll, degrees
//
// There is no checksum, so a line only counts if it has exactly the layout that the stream is known to have: one that was
// told, or one that two lines running agreed on. Axes: east_north (core/wind_geometry.h).
//
// -99.9 and the like stand for what could not be measured.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
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

/// Which values a line holds.
class TriSonicaLayout {
 public:
  struct Item {
    std::string tag;
    std::size_t decimals = 0;
    bool operator==(const Item&) const = default;
  };
  static constexpr std::size_t kMostItems = 32;

  /// "S2:3,D:0,U:3": tags with their decimals, as in a stream's metadata "items". Error: not of this form, a tag twice, or
  /// neither U and V nor S2 and D.
  static Result<TriSonicaLayout> parse(std::string_view text);
  /// That of a line, if it is a whole record by its form; nothing otherwise.
  static std::optional<TriSonicaLayout> of_line(std::string_view line);

  std::string text() const;
  const std::vector<Item>& items() const { return items_; }
  std::optional<std::size_t> find(std::string_view tag) const;
  bool operator==(const TriSonicaLayout&) const = default;

 private:
  static std::optional<TriSonicaLayout> make(std::vector<Item> items);
  std::vector<Item> items_;
};

/// "S2:3,D:0,U:3,V:3,W:3,T:2,H:2,AD:7,AX:0,AY:0,AZ:0,MD:0"
TriSonicaLayout default_trisonica_layout();

/// The values of a line, one per item of the layout, NaN where not measured; nothing when the line is no record of this layout.
std::optional<std::vector<double>> parse_trisonica(std::string_view line, const TriSonicaLayout& layout);

/// The wind among them. Not valid where it was not measured; nothing when it makes no sense (above 100 m/s).
std::optional<WindSample> trisonica_wind(const std::vector<double>& values, const TriSonicaLayout& layout);

/// The line that an instrument so set up would send, with CR LF. Wind, temperature and what follows from them (S, S2, D, DV)
/// come from the sample, every other tag from `others`, 0 where it is not there.
std::string encode_trisonica(const WindSample& sample, const TriSonicaLayout& layout,
                             const std::map<std::string, double>& others = {});

/// Decoder: raw bytes in, wind out, each sample stamped with the arrival of its line's first byte. A damaged line costs
/// itself only: a whole record at its end (bytes were lost before it) is found. Holds at most kLongestLine bytes back.
class TriSonicaDecoder : public Decoder {
 public:
  static constexpr std::size_t kLongestLine = 384;

  struct Options {
    StreamId stream = 0;                    // of the wind samples
    Duration delay{0};                      // sample_time = arrival_time - delay
    std::optional<TriSonicaLayout> layout;  // learned when absent, and again when the instrument was set up anew
  };

  explicit TriSonicaDecoder(Options options) : options_(std::move(options)), layout_(options_.layout) {}

  void decode(const Sample& raw, SampleSink& sink) override;
  void reset() override;
  const DecoderCounters& counters() const override { return counters_; }

 private:
  bool step(SampleSink& sink);
  void take_line(std::size_t length, SampleSink& sink);
  bool hand_on(std::string_view record, SampleSink& sink);
  bool learn(std::string_view line);
  void skip(std::size_t count);

  Options options_;
  std::optional<TriSonicaLayout> layout_;     // that of the stream
  std::optional<TriSonicaLayout> candidate_;  // that of the last whole line, if it was another
  TimedBytes<kLongestLine + 1> bytes_;
  std::size_t scanned_ = 0;  // so many of them hold no end of a line
  bool is_overlong_ = false;
  DecoderCounters counters_;
};

inline constexpr std::string_view kTriSonicaModel = "trisonica";

struct TriSonicaOptions {
  std::optional<TriSonicaLayout> layout;
  double north_offset_deg = 0;
  double rate_hz = 10;
  double delay_s = 0;
};

/// The raw stream "/<device>/raw": metadata model, axes, north_offset_deg, rate_hz, delay_s, link, and items if they are known.
StreamInfo raw_stream(const std::string& device, const TriSonicaOptions& options, const std::string& link);

/// The decoder of a raw stream whose model is trisonica; its wind stream is added to `streams`. Nothing otherwise.
std::unique_ptr<Decoder> make_trisonica_decoder(const StreamInfo& raw, StreamTable& streams);

}  // namespace roseau::wire
