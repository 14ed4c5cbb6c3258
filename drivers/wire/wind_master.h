// Gill WindMaster and WindMaster Pro (3-D), ASCII: manual 1561-PS-0001 Issue 11.
//
//   UVW    STX Q,+000.04,-000.04,+000.06,M,+347.06,+025.88,00, ETX 28 CR LF
//   polar  STX Q,335.3,001.261,-001.282,M,+345.41,+023.05,00,+2.4181,+2.4181,+2.4162,+2.4175,-50.00C, ETX 78 CR LF
//
// Speed of sound and sonic temperature, analogue inputs and the platinum thermometer are there or not as the instrument is
// set up (A, I, V): records are read by their own shape, not by a fixed count. Analogue inputs stay in the raw bytes.
// Continuous and polled output look the same. Axes: u > 0 wind from the south of the north spar, v > 0 from the east,
// w > 0 upwards (core/wind_geometry.h: gill_spar, or gill_axis as the instrument is set up).
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

/// Gill's status: 00 good, 0A largest gain and 0B retries used (good, but marginal); every other code spoils the wind.
bool wind_master_status_is_good(std::uint16_t status);

/// A good record of something else: an NMEA sentence.
bool is_foreign_to_wind_master(const GillRecord& record);

/// The sample of one record; nothing when its fields make no sense. Values are NaN and `valid` false where the instrument
/// says so (status, empty fields, nines). Winds above 100 m/s make no sense.
std::optional<WindSample> parse_wind_master(const GillRecord& record);

struct WindMasterFormat {
  enum class Mode : std::uint8_t { uvw, polar };
  Mode mode = Mode::uvw;
  char node = 'Q';
  char unit = 'M';                         // U1..U5: M N P K F
  bool high_resolution = false;            // J2: 0.001 units and 0.1 deg
  bool has_temperature = true;             // A1: speed of sound and sonic temperature
  bool fixed_fields = false;               // O2: nines for an error; else empty fields (O1)
  bool is_delimited = true;                // STX, ETX and checksum; without them the line some loggers pass on by UDP
  bool ends_with_line = true;              // CR LF
  std::vector<double> analogue_inputs;     // I, at most 4
  std::optional<double> platinum_celsius;  // V
};

/// What the instrument would send for this sample, with its resolution.
std::vector<std::byte> encode_wind_master(const WindSample& sample, const WindMasterFormat& format);

}  // namespace roseau::wire
