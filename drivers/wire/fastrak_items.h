// The items a FASTRAK's record is made of: what each holds and how long it is. For the codec's own files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

namespace roseau::wire {

inline constexpr std::size_t kPlainDigits = 7;      // Sxxx.xx, Sx.xxxx
inline constexpr std::size_t kExtendedDigits = 13;  // Sx.xxxxxESxxb

struct FastrakItem {
  enum class What : std::uint8_t {
    space,
    line_end,
    position,
    movement,  // since the last record
    angles,
    cosines_x,
    cosines_y,
    cosines_z,
    quaternion,
    stylus,
  };
  int code = 0;
  What what = What::space;
  std::size_t numbers = 0;
  int decimals = 0;  // of a plain number
  std::size_t text_bytes = 0;
  std::size_t binary_bytes = 0;
  bool is_extended = false;
};

/// Nothing for codes that mean nothing.
std::optional<FastrakItem> fastrak_item(int code);

}  // namespace roseau::wire
