#include "recorder/control/frame_memory.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <mutex>
#include <new>
#include <optional>

namespace roseau::recorder {

namespace {
constexpr std::uint64_t kAlignment = 64;  // as frame pools have it

struct AlignedDelete {
  void operator()(std::byte* bytes) const { ::operator delete[](bytes, std::align_val_t{kAlignment}); }
};
}  // namespace

struct FrameMemory::State {
  struct Block {
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
    bool is_free = false;
  };

  /// Where a block of this size goes; the caller holds the mutex.
  std::optional<std::uint64_t> place(std::uint64_t size) const {
    if (blocks.empty()) return size <= capacity ? std::optional(std::uint64_t{0}) : std::nullopt;
    const std::uint64_t tail = blocks.front().begin;
    const std::uint64_t head = blocks.back().end;
    if (blocks.back().begin < tail) return head + size <= tail ? std::optional(head) : std::nullopt;  // already round
    if (head + size <= capacity) return head;
    return size <= tail ? std::optional(std::uint64_t{0}) : std::nullopt;
  }
  void give_back(Block& block) {
    const std::scoped_lock lock(mutex);
    block.is_free = true;
    while (!blocks.empty() && blocks.front().is_free) blocks.pop_front();
  }

  std::uint64_t capacity = 0;
  std::unique_ptr<std::byte[], AlignedDelete> bytes;
  std::mutex mutex;
  std::deque<Block> blocks;  // oldest first; deque: leases point to them
};

FrameMemory::FrameMemory(std::uint64_t bytes) : state_(std::make_shared<State>()) {
  state_->capacity = bytes - bytes % kAlignment;
  if (state_->capacity == 0) return;
  state_->bytes.reset(static_cast<std::byte*>(::operator new[](state_->capacity, std::align_val_t{kAlignment})));
  std::memset(state_->bytes.get(), 0, state_->capacity);
}

FrameLease FrameMemory::copy(std::span<const std::byte> bytes) {
  const std::uint64_t size = (std::max<std::uint64_t>(bytes.size(), 1) + kAlignment - 1) / kAlignment * kAlignment;
  State::Block* block = nullptr;
  {
    const std::scoped_lock lock(state_->mutex);
    const auto begin = state_->place(size);
    if (!begin) return {};
    block = &state_->blocks.emplace_back(State::Block{*begin, *begin + size});
  }
  std::byte* to = state_->bytes.get() + block->begin;
  std::memcpy(to, bytes.data(), bytes.size());
  std::shared_ptr<void> owner(static_cast<void*>(block), [state = state_, block](void*) { state->give_back(*block); });
  return FrameLease::of({to, bytes.size()}, std::move(owner));
}

std::uint64_t FrameMemory::capacity() const { return state_->capacity; }

}  // namespace roseau::recorder
