// Past: the newest samples of every stream, in the order they came, bounded in log time and in bytes. What a trigger gets of
// the time before it.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/sample.h"
#include "core/time.h"
#include "recorder/control/frame_memory.h"

namespace roseau::recorder {

struct KeptSample {
  Sample sample;
  HostTime log_time;
  std::uint64_t bytes = 0;  // what it costs the bound; pixels apart, which lie in memory of their own
};

/// Roughly what a sample holds, pixels apart.
std::uint64_t bytes_without_pixels(const Sample& sample);

struct PastOptions {
  Duration length{0};         // 0: nothing is kept
  std::uint64_t bytes = 0;    // of everything together
  bool has_pictures = false;  // then nearly all of the bytes are set aside for them, at once
};

/// One thread at a time; leases of what came out of it may be let go by any.
class Past {
 public:
  explicit Past(PastOptions options);

  /// Takes the sample; what is older than `length` before the newest, and what has no room any more, goes.
  void keep(const Sample& sample, HostTime log_time);

  /// A copy of the sample that may be held for long: pixels lie in our memory. Nothing when there is no room for them.
  std::optional<KeptSample> copy(const Sample& sample, HostTime log_time);

  /// The oldest sample leaves. Nothing: it is empty.
  std::optional<KeptSample> take_oldest();

  /// Log time between the oldest and the newest.
  Duration span() const;
  std::uint64_t bytes() const { return small_bytes_ + pixel_bytes_; }
  std::size_t size() const { return samples_.size(); }
  /// Samples that were young enough and had to go for want of room, ever.
  std::uint64_t cut_off() const { return cut_off_; }

 private:
  void drop_oldest();

  const PastOptions options_;
  const std::uint64_t small_limit_;
  FrameMemory pixels_;
  std::deque<KeptSample> samples_;
  std::uint64_t small_bytes_ = 0;
  std::uint64_t pixel_bytes_ = 0;
  std::uint64_t cut_off_ = 0;
  HostTime newest_ = HostTime::min();
};

}  // namespace roseau::recorder
