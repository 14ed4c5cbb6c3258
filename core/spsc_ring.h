// SpscRing: bounded lock-free queue between exactly one producer and one consumer thread.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

namespace roseau {

/// Holds at most `capacity` items (rounded up to a power of two). T must be default constructible and movable.
/// Thread rule: try_push by one thread, try_pop by one other; size() by anyone (a snapshot).
template <class T>
class SpscRing {
 public:
  explicit SpscRing(std::size_t capacity)
      : mask_(std::bit_ceil(capacity < 2 ? std::size_t{2} : capacity) - 1), slots_(std::make_unique<T[]>(mask_ + 1)) {}

  std::size_t capacity() const { return mask_ + 1; }

  /// False when full: `item` is then left untouched, and the caller counts the drop. Moved from otherwise.
  bool try_push(T& item) {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - cached_tail_ > mask_) {
      cached_tail_ = tail_.load(std::memory_order_acquire);
      if (head - cached_tail_ > mask_) return false;
    }
    // The analyser believes that a refused item was moved from; it was not.
    slots_[head & mask_] = std::move(item);  // NOLINT(clang-analyzer-cplusplus.Move)
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Nothing when empty. The slot keeps a moved-from T, so leases held by items are released with the popped item.
  std::optional<T> try_pop() {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == cached_head_) {
      cached_head_ = head_.load(std::memory_order_acquire);
      if (tail == cached_head_) return std::nullopt;
    }
    std::optional<T> item(std::move(slots_[tail & mask_]));
    tail_.store(tail + 1, std::memory_order_release);
    return item;
  }

  std::size_t size() const {
    const std::size_t tail = tail_.load(std::memory_order_acquire);
    return head_.load(std::memory_order_acquire) - tail;
  }

 private:
  // Producer and consumer counters live on separate cache lines so that the two threads do not slow each other.
  static constexpr std::size_t kCacheLine = 64;
  const std::size_t mask_;
  const std::unique_ptr<T[]> slots_;
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};
  std::size_t cached_tail_ = 0;
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};
  std::size_t cached_head_ = 0;
};

}  // namespace roseau
