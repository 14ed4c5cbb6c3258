// Gill WindSonic (2-D), ASCII: manual 1405-PS-019 Issue 30.
//
//   UV     STX Q,+001.59,-002.74,M,00, ETX 3A CR LF      u, v, unit, status
//   polar  STX Q,229,002.74,M,00, ETX 16 CR LF           direction (deg, from, clockwise from the N mark), speed
//   NMEA   $IIMWV,120,R,002.10,M,A*10 CR LF              status A or V, or Gill's two digits
//
// Continuous and polled output look the same. Axes: u > 0 wind from the south of the N mark, v > 0 from the east
// (core/wind_geometry.h, gill_spar).
//
// Below its threshold (command K, 0.05 m/s unless changed) the instrument leaves the direction empty: u and v are then 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/sample.h"
#include "drivers/wire/gill_framer.h"

namespace roseau::wire {

/// Gill's status: 00 good, 10 largest gain (good, but marginal); every other code spoils the wind.
bool wind_sonic_status_is_good(std::uint16_t status);

/// device_status of an NMEA sentence marked invalid ("V"), which has no number.
inline constexpr std::uint16_t kNmeaStatusVoid = 'V';

/// A good record of something else: another NMEA sentence, or MWV relative to something else than the mark (T).
bool is_foreign_to_wind_sonic(const GillRecord& record);

/// The sample of one record; nothing when its fields make no sense. Values are NaN and `valid` false where the instrument
/// says so (status, empty fields, nines). Winds above 100 m/s make no sense.
std::optional<WindSample> parse_wind_sonic(const GillRecord& record);

struct WindSonicFormat {
  enum class Mode : std::uint8_t { uv, polar, nmea };
  Mode mode = Mode::uv;
  char node = 'Q';
  char unit = 'M';                   // U1..U5: M N P K F
  bool fixed_fields = false;         // O2: direction 999 and speed 999.99 for an error; else empty fields (O1)
  bool ends_with_line_feed = true;   // L1; L2 ends with CR alone
  bool nmea_status_is_gill = false;  // M15, M16; else A or V
  std::string nmea_talker = "II";    // M5, M16; "WI" for M14, M15
  double calm_below_mps = 0.05;      // K50
};

/// What the instrument would send for this sample, with its resolution of 0.01 units and 1 deg. u and v only.
std::vector<std::byte> encode_wind_sonic(const WindSample& sample, const WindSonicFormat& format);

}  // namespace roseau::wire
