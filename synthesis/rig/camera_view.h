// CameraView: the pictures that one of the scene's cameras takes of its world.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>

#include "core/frame.h"
#include "synthesis/render/frame_renderer.h"
#include "synthesis/rig/world.h"

namespace roseau::synthesis {

/// One thread at a time.
class CameraView {
 public:
  /// Takes some hundred milliseconds.
  CameraView(std::shared_ptr<const World> world, std::size_t camera);

  /// Picture number `frame`, with its exposure's midpoint at this time.
  void render(std::uint64_t frame, double midpoint_s, std::span<std::byte> pixels);
  /// The same as a frame in a buffer of the pool; an empty lease when the pool has none.
  Frame take(std::uint64_t frame, double midpoint_s, FramePool& pool);

  const CameraScene& camera() const { return world_->scene().cameras[index_]; }
  std::size_t frame_bytes() const { return renderer_.frame_bytes(); }

 private:
  std::shared_ptr<const World> world_;
  std::size_t index_;
  render::FrameRenderer renderer_;
  Eigen::VectorXd amplitudes_;  // scratch
};

}  // namespace roseau::synthesis
