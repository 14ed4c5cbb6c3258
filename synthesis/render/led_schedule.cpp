#include "synthesis/render/led_schedule.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace roseau::render {

namespace {

constexpr std::size_t kRing = 16;
constexpr double kTicksPerStep = 256;  // of the Gray counter
constexpr std::size_t kGrayBits = 10;

LedSchedule constant(bool on) { return {.period_ticks = 1, .on_tick = 0, .off_tick = on ? 1.0 : 0.0}; }

// Bit b of the Gray code n ^ (n >> 1): lit for n in [2^b, 3 * 2^b) of every 2^(b+2); the highest bit of a counter that wraps
// has half that period.
LedSchedule gray_bit(std::size_t bit) {
  const double steps = std::exp2(static_cast<double>(bit));
  if (bit == kGrayBits - 1) {
    return {.period_ticks = 2 * steps * kTicksPerStep, .on_tick = steps * kTicksPerStep, .off_tick = 2 * steps * kTicksPerStep};
  }
  return {.period_ticks = 4 * steps * kTicksPerStep, .on_tick = steps * kTicksPerStep, .off_tick = 3 * steps * kTicksPerStep};
}

// Columns 1 to 16 of row 2.
LedSchedule code_led(const LedBoard& board, std::size_t place) {
  if (place < kGrayBits) return gray_bit(kGrayBits - 1 - place);
  // A Gray code's parity is the lowest bit of the number it stands for.
  if (place == kGrayBits) return {.period_ticks = 2 * kTicksPerStep, .on_tick = kTicksPerStep, .off_tick = 2 * kTicksPerStep};
  if (place < kGrayBits + 5) return constant(((board.board_id >> (kGrayBits + 4 - place)) & 1U) != 0);
  return constant(board.synchronised);
}

}  // namespace

double LedSchedule::lit_share(double begin_ticks, double end_ticks) const {
  ROSEAU_CHECK(end_ticks > begin_ticks);
  // Time lit from tick 0 on; counted from the period in which the exposure begins, to keep all digits of a late time.
  const double first_period = std::floor(begin_ticks / period_ticks);
  const auto lit_until = [this, first_period](double ticks) {
    const double periods = std::floor(ticks / period_ticks);
    const double within = ticks - periods * period_ticks;
    return (periods - first_period) * (off_tick - on_tick) + std::clamp(within - on_tick, 0.0, off_tick - on_tick);
  };
  const double share = (lit_until(end_ticks) - lit_until(begin_ticks)) / (end_ticks - begin_ticks);
  return inverted ? 1 - share : share;
}

LedSchedule led_schedule(const LedBoard& board, std::size_t row, std::size_t column) {
  ROSEAU_CHECK(row < kLedRows && column < kLedColumns);
  if (column == 0) return constant(true);
  if (column == kLedColumns - 1) {
    LedSchedule corner = constant(row != 1);
    corner.populated = row != 2;
    return corner;
  }
  const std::size_t place = column - 1;
  const auto slot = static_cast<double>(place);
  if (row == 0) return {.fine_ring = true, .period_ticks = kRing, .on_tick = slot, .off_tick = slot + 1};
  if (row == 1) return {.period_ticks = kRing * kRing, .on_tick = slot * kRing, .off_tick = (slot + 1) * kRing};
  LedSchedule schedule = code_led(board, place);
  schedule.inverted = row == 3;
  return schedule;
}

}  // namespace roseau::render
