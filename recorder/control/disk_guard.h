// What watches over the disk: how fast it fills, how long it will last, what to do about it, and which old recordings may go.
// Pure but for delete_oldest().
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/time.h"
#include "recorder/control/session_files.h"

namespace roseau::recorder {

/// Bytes per second, smoothed: recordings are written in bursts.
class WriteRate {
 public:
  /// `bytes` written in total as of `now`. A total that falls (a new session) starts anew.
  void add(HostTime now, std::uint64_t bytes);
  /// Nothing is being written at the time: the rate that was is forgotten at the next add().
  void pause() { last_time_.reset(); }
  double bytes_per_s() const { return bytes_per_s_; }

 private:
  static constexpr double kTimeConstant_s = 10;
  std::optional<HostTime> last_time_;
  std::uint64_t last_bytes_ = 0;
  double seconds_ = 0;  // seen so far: at first the mean of all, then exponential
  double bytes_per_s_ = 0;
};

enum class WhenFull : std::uint8_t {
  stop,    // end the recording cleanly
  oldest,  // delete the oldest finished parts that roseau made in the recording directory
};

struct DiskGuardOptions {
  std::uint64_t least_free_bytes = std::uint64_t{1} << 30U;
  WhenFull when_full = WhenFull::stop;
  std::uint64_t keep_at_most_bytes = 0;  // of recordings in the directory, WhenFull::oldest only; 0: as many as fit
  Duration warn_ahead = std::chrono::minutes(10);
};

struct DiskVerdict {
  enum class Kind : std::uint8_t { well, warn, make_room, full };
  Kind kind = Kind::well;
  std::string message;              // warn, full: what is the matter and what to do
  double left_s = 0;                // at this rate until the least free space is reached; 0: not known
  std::uint64_t missing_bytes = 0;  // make_room, full: to be freed
};

class DiskGuard {
 public:
  explicit DiskGuard(DiskGuardOptions options) : options_(options) {}

  /// `recorded_bytes`: what all recordings in the directory take, the one at hand included. Once full, it stays full until
  /// there is a margin above the least free space, so that recording does not flutter.
  DiskVerdict judge(const std::filesystem::path& directory, std::uint64_t free_bytes, std::uint64_t recorded_bytes,
                    double bytes_per_s);

 private:
  const DiskGuardOptions options_;
  bool is_full_ = false;
};

/// Which files to delete, oldest first, so that at least `missing_bytes` are freed: finished ones, without those of `spared`
/// (the parts being written or copied). As many as there are when they do not suffice.
std::vector<SessionFile> oldest_to_delete(const std::vector<SessionFile>& files, std::uint64_t missing_bytes,
                                          const std::vector<std::filesystem::path>& spared);

/// "1 d 4 h", "12 min", "40 s".
std::string words_for_seconds(double seconds);
/// "1.5 GiB", "320 MiB".
std::string words_for_bytes(std::uint64_t bytes);

}  // namespace roseau::recorder
