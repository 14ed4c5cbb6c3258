// FrameMemory: one large piece of memory that pictures are copied into, one behind the other, round and round.
//
// Frames wait in their camera's buffers, of which there are at most 64: half a second of pictures held back would stop the
// camera. What is kept for longer is therefore copied, once, into memory that was made for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/frame.h"

namespace roseau::recorder {

/// copy() by one thread at a time; leases are let go by any. The memory outlives this object while leases exist.
class FrameMemory {
 public:
  /// Touches all of it: recording must not fault a page in. 0: none at all.
  explicit FrameMemory(std::uint64_t bytes);

  /// An empty lease when there is no room. Leases let go in the order they were made give room again at once; one that is kept
  /// keeps everything behind it from being used again.
  FrameLease copy(std::span<const std::byte> bytes);

  std::uint64_t capacity() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace roseau::recorder
