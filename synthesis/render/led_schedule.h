// When each LED of the sync board is lit, in closed form. The board has 18 x 4 places:
//
//   row 0:  F  A0 .. A15                       F     A  fine ring: LED tick mod 16
//   row 1:  F  B0 .. B15                       D     B  coarse ring: LED (tick / 16) mod 16
//   row 2:  F  G9 .. G0   P   I3 I2 I1 I0   S  -     G  Gray code of n = (tick / 256) mod 1024; P its parity; I board id
//   row 3:  F  the complements of row 2        F     S  synchronised; F always on; D never on; - not populated
#pragma once

#include <cstddef>

#include "synthesis/render/scene_description.h"

namespace roseau::render {

inline constexpr std::size_t kLedColumns = 18;
inline constexpr std::size_t kLedRows = 4;

/// Lit in [on_tick, off_tick) of every period.
struct LedSchedule {
  bool populated = true;
  bool fine_ring = false;
  double period_ticks = 1;
  double on_tick = 0;
  double off_tick = 0;
  bool inverted = false;

  /// Share of the time from `begin_ticks` to `end_ticks` (later) during which the LED is lit, exactly.
  double lit_share(double begin_ticks, double end_ticks) const;
};

/// `row` from the top, `column` from the left as one looks at the board's face.
LedSchedule led_schedule(const LedBoard& board, std::size_t row, std::size_t column);

}  // namespace roseau::render
