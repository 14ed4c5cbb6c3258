// Forest: many instances of one tree in wind, by its modes of deformation (thesis 6.2.3, 6.3, Figure 6.6). A frame is: the wind
// at each instance, the modal forces through the wind projection (6.30), one exact step of every oscillator, the displacement
// of every node (6.22, or 6.34 with the large-amplitude correction).
//
// Output: a row of 3N floats per instance, x y z of each node in metres, in the tree's own frame (what the thesis's texture U
// holds): the layout of a vertex buffer or texture of R32G32B32. Rows start on cache lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/result.h"
#include "core/wind_field.h"
#include "structure/animation/large_amplitude.h"
#include "structure/animation/modal_basis.h"

namespace roseau::structure {

struct TreeInstance {
  Vec3 position_in_world_m;  // where the wind is taken
  Quaternion world_from_tree;
};

struct ForestOptions {
  unsigned threads = 2;                  // the caller's and helpers; the same result whatever their number
  std::uint64_t memory_limit_bytes = 0;  // 0: three quarters of the machine's memory
};

/// One thread at a time may call it; a frame is worked on by the forest's own threads too. No frame allocates memory.
class Forest {
 public:
  /// Trees at rest in still air. Refused: a basis that does not pass check(), no instance, a rotation that is not one, more
  /// memory than the limit (the message says how much).
  static Result<Forest> make(const ModalBasis& basis, std::span<const TreeInstance> instances,
                             const ForestOptions& options = {});
  /// With the large-amplitude correction, made for the same shapes.
  static Result<Forest> make(const ModalBasis& basis, const LargeAmplitudeCorrection& correction,
                             std::span<const TreeInstance> instances, const ForestOptions& options = {});
  Forest(Forest&&) noexcept;
  Forest& operator=(Forest&&) noexcept;
  ~Forest();

  std::size_t instance_count() const;
  std::size_t node_count() const;
  std::size_t mode_count() const;

  /// A frame of `step_s` that ends with these winds (world frame, one per instance); over the frame the drive |v| v goes
  /// linearly from the last frame's to this one's.
  void advance(double step_s, std::span<const Vec3> winds_mps);
  /// With the wind of a field where the instances stand. Called from several threads; must not throw.
  void advance(double step_s, const WindField& wind, double time_s);
  /// Every tree comes to rest, bent, in a wind that does not change: a start without a jolt.
  void settle(std::span<const Vec3> winds_mps);

  /// Other frequencies, dampings or projections of the same modes (thesis 6.4.3) from the next frame on; the shapes are not
  /// looked at. Refused as by make.
  Result<void> set_dynamics(const ModalBasis& basis);

  /// For pull and release, and for those who look inside.
  double modal_coordinate(std::size_t instance, std::size_t mode) const;
  double modal_rate(std::size_t instance, std::size_t mode) const;
  void set_modal_state(std::size_t instance, std::size_t mode, double q, double rate);

  /// 3N floats; valid until the next frame.
  std::span<const float> displacements_m(std::size_t instance) const;
  /// All rows, and the floats from one to the next.
  std::span<const float> all_displacements_m() const;
  std::size_t row_stride() const;

 private:
  struct State;
  explicit Forest(std::unique_ptr<State> state);
  static Result<Forest> make(const ModalBasis& basis, const LargeAmplitudeCorrection* correction,
                             std::span<const TreeInstance> instances, const ForestOptions& options);
  std::unique_ptr<State> state_;
};

}  // namespace roseau::structure
