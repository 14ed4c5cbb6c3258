#include "structure/animation/forest.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <utility>

#include "structure/animation/aligned_floats.h"
#include "structure/animation/forest_kernels.h"
#include "structure/animation/frame_team.h"
#include "structure/mechanics/oscillator_step.h"

namespace roseau::structure {

namespace {

constexpr std::size_t kTilesPerUnit = 4;  // a unit of work: as many instances as reuse a panel while it is in the first cache
constexpr std::size_t kStreamingBytes = std::size_t{16} << 20;  // outputs beyond this are written past the caches
constexpr double kNothing = 1e-12;  // of the largest shape: noise of the eigensolver, that would only cost slow tiny numbers

std::size_t round_up(std::size_t value, std::size_t step) { return (value + step - 1) / step * step; }

std::uint64_t physical_memory_bytes() {
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

Error invalid(std::string message) { return {ErrorCode::invalid_argument, "forest: " + std::move(message)}; }

// In doubles: the product of the counts asked for may not fit any integer.
Result<void> check_memory(double instances, double nodes, double modes, const ForestOptions& options) {
  const auto limit =
      static_cast<double>(options.memory_limit_bytes != 0 ? options.memory_limit_bytes : physical_memory_bytes() / 4 * 3);
  const double bytes = sizeof(float) * (instances * (3 * nodes + 2 * modes + 12) + 6 * nodes * modes);
  if (bytes <= limit) return {};
  return Error{ErrorCode::no_space,
               fmt::format("forest: {:.0f} trees of {:.0f} nodes with {:.0f} modes need {:.0f} MB of memory, but {:.0f} MB are "
                           "allowed; take fewer trees or nodes",
                           instances, nodes, modes, bytes * 1e-6, limit * 1e-6)};
}

Result<void> check_correction(const ModalBasis& basis, const LargeAmplitudeCorrection& correction) {
  const auto same = [&](const Eigen::MatrixXd& part) {
    return part.rows() == basis.shapes.rows() && part.cols() == basis.shapes.cols();
  };
  if (!same(correction.v) || !same(correction.w) || correction.b.size() != basis.shapes.cols()) {
    return invalid(fmt::format("the correction is made for {} nodes and {} modes, the basis has {} and {}",
                               correction.v.rows() / 3, correction.b.size(), basis.node_count(), basis.mode_count()));
  }
  if (!correction.v.allFinite() || !correction.w.allFinite() || !(correction.b.array() >= 0).all() ||
      !correction.b.allFinite()) {
    return invalid("a number of the correction is not finite, or a curvature b is negative");
  }
  return {};
}

Result<void> check_instances(std::span<const TreeInstance> instances) {
  if (instances.empty()) return invalid("it has no tree; give at least one instance");
  for (std::size_t k = 0; k < instances.size(); ++k) {
    const auto& [p, r] = instances[k];
    const double norm = std::sqrt(r.w * r.w + r.x * r.x + r.y * r.y + r.z * r.z);
    if (!(std::abs(norm - 1) < 1e-3)) return invalid(fmt::format("the rotation of tree {} is not a unit quaternion", k));
    if (!std::isfinite(p.x + p.y + p.z)) return invalid(fmt::format("the position of tree {} is not finite", k));
  }
  return {};
}

// The rows of the matrix that takes world coordinates to the tree's.
std::array<double, 9> tree_from_world(const Quaternion& r) {
  return {1 - 2 * (r.y * r.y + r.z * r.z), 2 * (r.x * r.y + r.w * r.z),     2 * (r.x * r.z - r.w * r.y),
          2 * (r.x * r.y - r.w * r.z),     1 - 2 * (r.x * r.x + r.z * r.z), 2 * (r.y * r.z + r.w * r.x),
          2 * (r.x * r.z + r.w * r.y),     2 * (r.y * r.z - r.w * r.x),     1 - 2 * (r.x * r.x + r.y * r.y)};
}

void set_products(float (&out)[3], double factor, const Eigen::Vector3d& projection) {
  for (int axis = 0; axis < 3; ++axis) out[axis] = static_cast<float>(factor * projection[axis]);
}

}  // namespace

struct Forest::State {
  struct alignas(64) Member {
    std::atomic<std::size_t> next_unit = 0;  // of this member's own units; others help when they are through with theirs
    std::size_t begin_unit = 0;
    std::size_t end_unit = 0;
    AlignedFloats functions;
  };

  State(const ModalBasis& basis, const LargeAmplitudeCorrection* correction, std::span<const TreeInstance> instances,
        unsigned threads);

  void lay_out_tiles(unsigned threads);
  void pack_shapes(const Eigen::MatrixXd* const* parts, std::size_t part_count);
  void place(std::span<const TreeInstance> instances);
  void set_dynamics(const ModalBasis& basis);
  void set_step(double step_s);
  void set_equilibrium();

  void run_frame(std::span<const Vec3> given_winds, const WindField* given_field, double at_s);
  void work(unsigned member);
  void run_unit(std::size_t unit, Member& member);
  void gather_wind(std::size_t first_tile, std::size_t tiles, float* wind) const;
  void place_state(std::size_t instance, std::size_t& tile, std::size_t& slot) const;

  std::size_t instance_count;
  std::size_t node_count;
  std::size_t mode_count;
  std::size_t function_count;  // per instance: modes, or twice as many with the correction
  std::size_t stride;

  std::vector<Vec3> points;              // where the wind is taken
  std::vector<std::size_t> tile_first;   // first instance of each tile; one more, for the end
  std::vector<std::size_t> tile_counts;  // instances of each tile
  std::size_t tiles_per_unit = 1;
  std::size_t unit_count = 1;

  AlignedFloats shapes;
  std::vector<ShapePanel> panels;
  AlignedFloats rotations;  // tiles x 9 x kTile
  AlignedFloats drives;     // tiles x 3 x kTile, at the end of the last frame
  AlignedFloats q;          // tiles x modes x kTile
  AlignedFloats rates;
  AlignedFloats out;
  bool streaming = false;

  Eigen::VectorXd natural_frequency_hz;
  Eigen::VectorXd damping_coefficient_per_s;
  Eigen::Matrix3Xd wind_projection;
  std::vector<ModeStep> steps;
  double prepared_step_s = -1;  // that `steps` are for

  // The frame at work.
  std::span<const Vec3> winds;
  const WindField* field = nullptr;
  double time_s = 0;

  std::vector<Member> members;
  std::unique_ptr<FrameTeam> team;  // the last: its threads use all of the above
};

Forest::State::State(const ModalBasis& basis, const LargeAmplitudeCorrection* correction,
                     std::span<const TreeInstance> instances, unsigned threads)
    : instance_count(instances.size()),
      node_count(basis.node_count()),
      mode_count(basis.mode_count()),
      function_count(correction != nullptr ? 2 * mode_count : mode_count),
      stride(round_up(3 * node_count, kRowStep)) {
  lay_out_tiles(threads);
  if (correction != nullptr) {
    const std::array parts{&correction->v, &correction->w};
    pack_shapes(parts.data(), parts.size());
  } else {
    const std::array parts{&basis.shapes};
    pack_shapes(parts.data(), parts.size());
  }
  place(instances);
  out = AlignedFloats(round_up(instance_count, kInstanceBlock) * stride);
  streaming = out.size() * sizeof(float) > kStreamingBytes;

  steps.resize(mode_count);
  for (std::size_t i = 0; i < mode_count; ++i) {
    steps[i].b = correction != nullptr ? static_cast<float>(correction->b[static_cast<Eigen::Index>(i)]) : 0;
  }
  set_dynamics(basis);
  team = std::make_unique<FrameTeam>(static_cast<unsigned>(members.size()), [this](unsigned member) { work(member); });
}

void Forest::State::lay_out_tiles(unsigned threads) {
  const std::size_t blocks = round_up(instance_count, kInstanceBlock) / kInstanceBlock;
  const std::size_t team_size = std::min<std::size_t>(std::max(threads, 1U), blocks);
  const std::size_t full_tiles = round_up(instance_count, kTile) / kTile;
  const std::size_t tiles = std::min(blocks, round_up(full_tiles, team_size));
  for (std::size_t tile = 0; tile <= tiles; ++tile) {
    tile_first.push_back(std::min(instance_count, tile * blocks / tiles * kInstanceBlock));
    if (tile > 0) tile_counts.push_back(tile_first[tile] - tile_first[tile - 1]);
  }
  tiles_per_unit = std::min(kTilesPerUnit, round_up(tiles, team_size) / team_size);
  unit_count = round_up(tiles, tiles_per_unit) / tiles_per_unit;

  members = std::vector<Member>(team_size);
  for (std::size_t m = 0; m < team_size; ++m) {
    members[m].begin_unit = m * unit_count / team_size;
    members[m].end_unit = (m + 1) * unit_count / team_size;
    if (function_count != mode_count) members[m].functions = AlignedFloats(tiles_per_unit * function_count * kTile);
  }
  rotations = AlignedFloats(tiles * 9 * kTile);
  drives = AlignedFloats(tiles * 3 * kTile);
  q = AlignedFloats(tiles * mode_count * kTile);
  rates = AlignedFloats(tiles * mode_count * kTile);
}

// Panel after panel, function after function; the parts' columns alternate: v of the first mode, w of the first mode, ...
void Forest::State::pack_shapes(const Eigen::MatrixXd* const* parts, std::size_t part_count) {
  const std::size_t vectors = stride / kRowStep;
  const std::size_t most = kPanelRows / kRowStep;
  const std::size_t panel_count = (vectors + most - 1) / most;
  shapes = AlignedFloats(stride * function_count);
  float* next = shapes.data();
  for (std::size_t p = 0; p < panel_count; ++p) {
    const std::size_t first_row = p * vectors / panel_count * kRowStep;
    const std::size_t end_row = (p + 1) * vectors / panel_count * kRowStep;
    panels.push_back({.shapes = next, .rows = end_row - first_row, .first_row = first_row});
    for (std::size_t f = 0; f < function_count; ++f) {
      const auto column = parts[f % part_count]->col(static_cast<Eigen::Index>(f / part_count));
      const double nothing = kNothing * column.cwiseAbs().maxCoeff();
      for (std::size_t row = first_row; row < end_row; ++row, ++next) {
        const double value = row < 3 * node_count ? column[static_cast<Eigen::Index>(row)] : 0;
        if (std::abs(value) > nothing) *next = static_cast<float>(value);
      }
    }
  }
}

void Forest::State::place(std::span<const TreeInstance> instances) {
  points.reserve(instance_count);
  for (std::size_t k = 0; k < instance_count; ++k) {
    points.push_back(instances[k].position_in_world_m);
    std::size_t tile = 0;
    std::size_t slot = 0;
    place_state(k, tile, slot);
    const auto rotation = tree_from_world(instances[k].world_from_tree);
    for (std::size_t i = 0; i < 9; ++i) rotations[(tile * 9 + i) * kTile + slot] = static_cast<float>(rotation[i]);
  }
}

void Forest::State::place_state(std::size_t instance, std::size_t& tile, std::size_t& slot) const {
  const auto after = std::upper_bound(tile_first.begin(), tile_first.end() - 1, instance);
  tile = static_cast<std::size_t>(after - tile_first.begin()) - 1;
  slot = instance - tile_first[tile];
}

void Forest::State::set_dynamics(const ModalBasis& basis) {
  natural_frequency_hz = basis.natural_frequency_hz;
  damping_coefficient_per_s = basis.damping_coefficient_per_s;
  wind_projection = basis.wind_projection;
  prepared_step_s = -1;
}

void Forest::State::set_step(double step_s) {
  if (step_s == prepared_step_s) return;
  for (std::size_t i = 0; i < mode_count; ++i) {
    const auto mode = static_cast<Eigen::Index>(i);
    const double omega = 2 * std::numbers::pi * natural_frequency_hz[mode];
    const auto exact = exact_oscillator_step(omega * omega, damping_coefficient_per_s[mode], step_s);
    ModeStep& step = steps[i];
    // The unit part is split off: in single precision it would round away what a short step changes.
    step.q_less_one_from_q = static_cast<float>(exact.position.position - 1);
    step.q_from_rate = static_cast<float>(exact.position.velocity);
    step.rate_from_q = static_cast<float>(exact.velocity.position);
    step.rate_less_one_from_rate = static_cast<float>(exact.velocity.velocity - 1);
    set_products(step.q_from_start, exact.position.begin_force, wind_projection.col(mode));
    set_products(step.q_from_end, exact.position.end_force, wind_projection.col(mode));
    set_products(step.rate_from_start, exact.velocity.begin_force, wind_projection.col(mode));
    set_products(step.rate_from_end, exact.velocity.end_force, wind_projection.col(mode));
  }
  prepared_step_s = step_s;
}

// As an endless step: the old state is forgotten, what remains is the force over the stiffness.
void Forest::State::set_equilibrium() {
  for (std::size_t i = 0; i < mode_count; ++i) {
    const auto mode = static_cast<Eigen::Index>(i);
    const double omega = 2 * std::numbers::pi * natural_frequency_hz[mode];
    const float b = steps[i].b;
    steps[i] = {.q_less_one_from_q = -1, .rate_less_one_from_rate = -1, .b = b};
    set_products(steps[i].q_from_end, 1 / (omega * omega), wind_projection.col(mode));
  }
  prepared_step_s = -1;
}

void Forest::State::run_frame(std::span<const Vec3> given_winds, const WindField* given_field, double at_s) {
  winds = given_winds;
  field = given_field;
  time_s = at_s;
  for (Member& member : members) member.next_unit.store(member.begin_unit, std::memory_order_relaxed);
  team->run();
}

void Forest::State::work(unsigned member) {
  for (std::size_t helped = 0; helped < members.size(); ++helped) {
    Member& owner = members[(member + helped) % members.size()];
    for (;;) {
      const std::size_t unit = owner.next_unit.fetch_add(1, std::memory_order_relaxed);
      if (unit >= owner.end_unit) break;
      run_unit(unit, members[member]);
    }
  }
  if (streaming) drain_streams();
}

void Forest::State::run_unit(std::size_t unit, Member& member) {
  const std::size_t first_tile = unit * tiles_per_unit;
  const std::size_t tiles = std::min(tiles_per_unit, tile_counts.size() - first_tile);
  const bool corrected = function_count != mode_count;
  alignas(64) std::array<float, kTilesPerUnit * 3 * kTile> wind{};
  gather_wind(first_tile, tiles, wind.data());
  for (std::size_t t = 0; t < tiles; ++t) {
    const std::size_t tile = first_tile + t;
    float* drive = drives.data() + tile * 3 * kTile;
    alignas(64) std::array<float, 3 * kTile> start;
    std::copy_n(drive, start.size(), start.begin());
    compute_drive(wind.data() + t * 3 * kTile, rotations.data() + tile * 9 * kTile, drive);
    float* q_of_tile = q.data() + tile * mode_count * kTile;
    step_modes(steps.data(), mode_count, start.data(), drive, q_of_tile, rates.data() + tile * mode_count * kTile);
    if (corrected) correct_modes(steps.data(), mode_count, q_of_tile, member.functions.data() + t * function_count * kTile);
  }
  const TileRun run{.functions = corrected ? member.functions.data() : q.data() + first_tile * mode_count * kTile,
                    .counts = tile_counts.data() + first_tile,
                    .tiles = tiles};
  float* rows = out.data() + tile_first[first_tile] * stride;
  for (const ShapePanel& panel : panels) multiply_panel(panel, function_count, run, rows, stride, streaming);
}

void Forest::State::gather_wind(std::size_t first_tile, std::size_t tiles, float* wind) const {
  const std::size_t first = tile_first[first_tile];
  const std::size_t count = tile_first[first_tile + tiles] - first;
  std::array<Vec3, kTilesPerUnit * kTile> sampled;
  std::span<const Vec3> local;
  if (field != nullptr) {
    const std::span<Vec3> samples(sampled.data(), count);
    field->velocities_mps(std::span(points).subspan(first, count), time_s, samples);
    local = samples;
  } else {
    local = winds.subspan(first, count);
  }
  std::size_t k = 0;
  for (std::size_t t = 0; t < tiles; ++t, wind += 3 * kTile) {
    for (std::size_t slot = 0; slot < tile_counts[first_tile + t]; ++slot, ++k) {
      wind[slot] = static_cast<float>(local[k].x);
      wind[kTile + slot] = static_cast<float>(local[k].y);
      wind[2 * kTile + slot] = static_cast<float>(local[k].z);
    }
  }
}

Forest::Forest(std::unique_ptr<State> state) : state_(std::move(state)) {}
Forest::Forest(Forest&&) noexcept = default;
Forest& Forest::operator=(Forest&&) noexcept = default;
Forest::~Forest() = default;

Result<Forest> Forest::make(const ModalBasis& basis, std::span<const TreeInstance> instances, const ForestOptions& options) {
  return make(basis, nullptr, instances, options);
}

Result<Forest> Forest::make(const ModalBasis& basis, const LargeAmplitudeCorrection& correction,
                            std::span<const TreeInstance> instances, const ForestOptions& options) {
  if (auto checked = check_correction(basis, correction); !checked) return checked.error();
  return make(basis, &correction, instances, options);
}

Result<Forest> Forest::make(const ModalBasis& basis, const LargeAmplitudeCorrection* correction,
                            std::span<const TreeInstance> instances, const ForestOptions& options) {
  if (auto checked = check(basis); !checked) return checked.error();
  if (auto checked = check_instances(instances); !checked) return checked.error();
  const auto room = check_memory(static_cast<double>(instances.size()), static_cast<double>(basis.node_count()),
                                 static_cast<double>(basis.mode_count()), options);
  if (!room) return room.error();
  try {
    return Forest(std::make_unique<State>(basis, correction, instances, options.threads));
  } catch (const std::exception& failure) {  // no memory or no thread to be had
    return Error{ErrorCode::no_space, fmt::format("forest: {}", failure.what())};
  }
}

std::size_t Forest::instance_count() const { return state_->instance_count; }
std::size_t Forest::node_count() const { return state_->node_count; }
std::size_t Forest::mode_count() const { return state_->mode_count; }
std::size_t Forest::row_stride() const { return state_->stride; }

void Forest::advance(double step_s, std::span<const Vec3> winds_mps) {
  ROSEAU_CHECK(step_s >= 0 && winds_mps.size() == state_->instance_count);
  state_->set_step(step_s);
  state_->run_frame(winds_mps, nullptr, 0);
}

void Forest::advance(double step_s, const WindField& wind, double time_s) {
  ROSEAU_CHECK(step_s >= 0);
  state_->set_step(step_s);
  state_->run_frame({}, &wind, time_s);
}

void Forest::settle(std::span<const Vec3> winds_mps) {
  ROSEAU_CHECK(winds_mps.size() == state_->instance_count);
  state_->set_equilibrium();
  state_->run_frame(winds_mps, nullptr, 0);
}

Result<void> Forest::set_dynamics(const ModalBasis& basis) {
  if (auto checked = check(basis); !checked) return checked;
  if (basis.mode_count() != state_->mode_count) {
    return invalid(fmt::format("it has {} modes, the new dynamics {}", state_->mode_count, basis.mode_count()));
  }
  state_->set_dynamics(basis);
  return {};
}

double Forest::modal_coordinate(std::size_t instance, std::size_t mode) const {
  ROSEAU_CHECK(instance < state_->instance_count && mode < state_->mode_count);
  std::size_t tile = 0;
  std::size_t slot = 0;
  state_->place_state(instance, tile, slot);
  return state_->q[(tile * state_->mode_count + mode) * kTile + slot];
}

double Forest::modal_rate(std::size_t instance, std::size_t mode) const {
  ROSEAU_CHECK(instance < state_->instance_count && mode < state_->mode_count);
  std::size_t tile = 0;
  std::size_t slot = 0;
  state_->place_state(instance, tile, slot);
  return state_->rates[(tile * state_->mode_count + mode) * kTile + slot];
}

void Forest::set_modal_state(std::size_t instance, std::size_t mode, double q, double rate) {
  ROSEAU_CHECK(instance < state_->instance_count && mode < state_->mode_count);
  std::size_t tile = 0;
  std::size_t slot = 0;
  state_->place_state(instance, tile, slot);
  const std::size_t at = (tile * state_->mode_count + mode) * kTile + slot;
  state_->q[at] = static_cast<float>(q);
  state_->rates[at] = static_cast<float>(rate);
}

std::span<const float> Forest::displacements_m(std::size_t instance) const {
  ROSEAU_CHECK(instance < state_->instance_count);
  return {state_->out.data() + instance * state_->stride, 3 * state_->node_count};
}

std::span<const float> Forest::all_displacements_m() const {
  return {state_->out.data(), state_->instance_count * state_->stride};
}

}  // namespace roseau::structure
