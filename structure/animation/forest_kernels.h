// The inner loops of a forest's frame, in vector code for the CPU at hand (Highway picks it at run time). All arrays are
// aligned to 64 bytes. Every number is computed by the same operations in the same order wherever its instance or node stands,
// so how the work is split does not show in the result.
#pragma once

#include <cstddef>
#include <cstdint>

namespace roseau::structure {

/// Instances are stepped in tiles of this many: the widest vector's floats, also where vectors are narrower.
inline constexpr std::size_t kTile = 16;
/// The product computes this many instances at once; rows of the output exist for whole blocks.
inline constexpr std::size_t kInstanceBlock = 4;
/// Coordinates (rows of Phi) per panel at most: with 50 functions a panel is 19 kB, which stays in the first cache.
inline constexpr std::size_t kPanelRows = 96;
/// Panels' rows come in multiples of this.
inline constexpr std::size_t kRowStep = 16;

/// What one mode needs for a step: the coefficients of mechanics' exact_oscillator_step, those of the force already multiplied
/// by the mode's wind projection, and b of the correction, see large_amplitude.h.
struct ModeStep {
  float q_less_one_from_q;
  float q_from_rate;
  float rate_from_q;
  float rate_less_one_from_rate;
  float q_from_start[3];
  float q_from_end[3];
  float rate_from_start[3];
  float rate_from_end[3];
  float b;  // s = arctan(b q) / b; 0: s = q
};

/// Drive |v| v of a tile in the trees' own frames. `wind`: 3 x kTile, world frame; `rotation`: 9 x kTile, tree_from_world by
/// rows; `drive`: 3 x kTile, holds the last drive, which stays where the wind is not a finite number.
void compute_drive(const float* wind_mps, const float* tree_from_world, float* drive);

/// One step of every mode of a tile. `start` and `end`: the drive at both ends of the step; `q`, `rate`: modes x kTile.
void step_modes(const ModeStep* steps, std::size_t modes, const float* start, const float* end, float* q, float* rate);

/// `functions`: 2 modes x kTile: s and s^2 of each mode.
void correct_modes(const ModeStep* steps, std::size_t modes, const float* q, float* functions);

/// A panel of shapes: `rows` coordinates, function by function (functions x rows).
struct ShapePanel {
  const float* shapes;
  std::size_t rows;
  std::size_t first_row;
};

/// Tiles of instances that follow each other in the output.
struct TileRun {
  const float* functions;     // tiles x function_count x kTile
  const std::size_t* counts;  // instances in each tile
  std::size_t tiles;
};

/// Output rows [instance][row] = panel^T functions. `out`: the run's first instance at row 0; `stride`: floats from one
/// instance to the next. `streaming` writes past the caches: right where the output does not fit into them; drain_streams must
/// follow.
void multiply_panel(const ShapePanel& panel, std::size_t function_count, const TileRun& run, float* out, std::size_t stride,
                    bool streaming);
void drain_streams();

/// Sum over the waves of amplitude sin(east x + north y + phase), see gust_wind.h, for `count` points (a multiple of kTile).
struct GustPhase {
  float east_per_m;
  float north_per_m;
  float phase;
  float along;
  float across;
};
void sum_gusts(const GustPhase* gusts, std::size_t gust_count, const float* east_m, const float* north_m, std::size_t count,
               float* along, float* across);

/// Multiply-adds on registers alone, for the machine's limit in the benchmark: returns the number of floating point operations.
std::uint64_t burn_multiply_adds(std::uint64_t rounds, float* sink);
/// Writes `count` floats past the caches or through them, for the same.
void fill_memory(float* data, std::size_t count, float value, bool streaming);

/// The instruction set chosen here, as Highway names it ("AVX3").
const char* instruction_set();

}  // namespace roseau::structure
