// Polhemus 3SPACE FASTRAK: manual OPM00PI002 Rev. G.
//
// A data record is '0', the station '1'..'4', an error letter or a space, and the items that the command O chose, one behind
// the other. In text (F) every number is 7 characters wide, in binary (f) it is a little-endian IEEE-754 float:
//
//   O1,2,4,1    01   12.34  -5.67   8.90 -45.00  10.25 179.99 CR LF     47 bytes, as delivered
//   O1,2,11,0   '0' '1' ' ' x y z q0 q1 q2 q3 ' '                       32 bytes in binary
//
// The stations take turns in a cycle of 120 Hz, so each of n comes 120/n times a second.
//
// Position is that of the receiver in the axes of the transmitter (source). Azimuth, elevation and roll turn the source's
// axes into the receiver's about z, then y, then x; the quaternion q0 + q1 i + q2 j + q3 k is that same rotation:
// source_from_station. Items 5, 6 and 7 are the rows of its matrix.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/sample.h"

namespace roseau::wire {

inline constexpr int kFastrakStations = 4;
inline constexpr double kFastrakCycleHz = 120;
/// From the middle of the time in which the fields were sampled to the record's first byte, without filters (page 114).
inline constexpr double kFastrakDelay_s = 0.00375;

enum class FastrakUnit : std::uint8_t { inch, centimetre };
double metres_per(FastrakUnit unit);

/// What a record holds behind its first three bytes: the numbers of command O. Codes above 50 are the same with more digits.
class FastrakLayout {
 public:
  /// "2,11,0". invalid_argument: not a list, unknown items, more than 32 of them or 254 bytes, or no position (2).
  static Result<FastrakLayout> parse(std::string_view items);

  /// "2,11,0", as in command O.
  const std::string& text() const { return text_; }
  const std::vector<int>& items() const { return items_; }
  std::size_t text_bytes() const { return text_bytes_; }
  std::size_t binary_bytes() const { return binary_bytes_; }

 private:
  FastrakLayout() = default;
  std::string text_;
  std::vector<int> items_;
  std::size_t text_bytes_ = 0;  // of whole records
  std::size_t binary_bytes_ = 0;
};

/// "2,4,1", as the tracker is delivered.
FastrakLayout default_fastrak_layout();
/// "2,11,0".
FastrakLayout quaternion_fastrak_layout();

inline constexpr std::size_t kFastrakHeaderBytes = 3;

/// Record type, station and error letter make sense. Looks at three bytes.
bool is_fastrak_header(std::string_view bytes);

/// The pose in a record of exactly layout.text_bytes() or binary_bytes(); nothing when it is none: header, characters,
/// numbers that are not finite, positions further than 200 inches, rotations that are none.
/// A record with an error letter is not `valid`, but keeps its numbers.
std::optional<StationPose> parse_fastrak_text(std::string_view record, const FastrakLayout& layout, FastrakUnit unit);
std::optional<StationPose> parse_fastrak_binary(std::string_view record, const FastrakLayout& layout, FastrakUnit unit);

/// False: however a text record goes on behind `bytes`, it will not be one. To give up early.
bool may_become_fastrak_text(std::string_view bytes, const FastrakLayout& layout);

struct FastrakFormat {
  FastrakLayout layout = default_fastrak_layout();
  bool is_binary = false;
  FastrakUnit unit = FastrakUnit::inch;
};

/// The data record that a tracker so set up would send. The pose must be finite; what does not fit its field is cut off.
std::string encode_fastrak(const StationPose& pose, const FastrakFormat& format);

/// The answer to S, 55 bytes.
struct FastrakStatus {
  int station = 1;
  bool is_binary = false;
  FastrakUnit unit = FastrakUnit::inch;
  bool is_compensating = false;
  bool is_continuous = false;
  int error = 0;               // of the built-in test; 0 = none
  unsigned receivers = 0;      // which are plugged in: bit 0 = station 1
  std::string version;         // 6 characters
  std::string identification;  // 32 characters
};
inline constexpr std::size_t kFastrakStatusBytes = 55;
std::optional<FastrakStatus> parse_fastrak_status(std::string_view line);
std::string encode_fastrak_status(const FastrakStatus& status);

/// The answer to a command that makes no sense ("2 E*ERROR*...").
std::string encode_fastrak_error(std::string_view command, int error);

}  // namespace roseau::wire
