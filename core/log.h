// Logging: spdlog to stderr, one named logger per folder or device.
#pragma once

#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdint>
#include <string>

namespace roseau {

/// Logger of this name, made on first use: `log("sonic")->warn("...")`. Thread-safe.
std::shared_ptr<spdlog::logger> log(const std::string& name);

/// Lets at most one message through per interval and says how many were held back. Not thread-safe: one per place and thread.
/// The caller passes the time, so that nothing below the drivers reads a clock.
class RateLimit {
 public:
  explicit RateLimit(std::chrono::nanoseconds interval) : interval_(interval) {}

  /// True when a message may go out at `now_ns` (any monotonic nanoseconds); `suppressed()` then says how many did not.
  bool allow(std::int64_t now_ns) {
    if (has_last_ && now_ns - last_ns_ < interval_.count()) {
      ++pending_;
      return false;
    }
    has_last_ = true;
    last_ns_ = now_ns;
    suppressed_ = pending_;
    pending_ = 0;
    return true;
  }
  std::uint64_t suppressed() const { return suppressed_; }

 private:
  std::chrono::nanoseconds interval_;
  bool has_last_ = false;
  std::int64_t last_ns_ = 0;
  std::uint64_t pending_ = 0;
  std::uint64_t suppressed_ = 0;
};

}  // namespace roseau
