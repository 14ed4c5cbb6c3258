// The last bytes of a stream, each with the time at which it began on the wire: what decoders search for records.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "core/check.h"
#include "core/sample.h"
#include "core/time.h"

namespace roseau::wire {

/// Holds what is not yet used up, in memory of fixed size: a decoder that waits for at most `Longest` bytes before it drops
/// some never fills it.
template <std::size_t Longest>
class TimedBytes {
 public:
  /// Takes at most RawBytes::kCapacity bytes, which follow those before; byte i began at `first_byte_time` + i * `byte_time`.
  void push(std::span<const std::byte> bytes, HostTime first_byte_time, Duration byte_time) {
    std::copy(text_.begin() + offset(begin_), text_.begin() + offset(end_), text_.begin());
    std::copy(times_.begin() + offset(begin_), times_.begin() + offset(end_), times_.begin());
    end_ -= begin_;
    begin_ = 0;
    ROSEAU_CHECK(end_ + bytes.size() <= kCapacity);
    for (const std::byte byte : bytes) {
      text_[end_] = static_cast<char>(byte);
      times_[end_] = first_byte_time;
      first_byte_time += byte_time;
      ++end_;
    }
  }

  /// Valid until the next push.
  std::string_view text() const { return {text_.data() + begin_, end_ - begin_}; }
  bool empty() const { return begin_ == end_; }
  HostTime first_byte_time() const { return times_[begin_]; }

  void drop(std::size_t count) {
    ROSEAU_CHECK(count <= end_ - begin_);
    begin_ += count;
  }
  void clear() { begin_ = end_ = 0; }

 private:
  static constexpr std::size_t kCapacity = Longest + RawBytes::kCapacity;
  static std::ptrdiff_t offset(std::size_t index) { return static_cast<std::ptrdiff_t>(index); }

  std::array<char, kCapacity> text_{};
  std::array<HostTime, kCapacity> times_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
};

}  // namespace roseau::wire
