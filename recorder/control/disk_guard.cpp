#include "recorder/control/disk_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace roseau::recorder {

namespace {
constexpr std::uint64_t kMib = std::uint64_t{1} << 20U;
constexpr std::uint64_t kGib = std::uint64_t{1} << 30U;
// The writer reserves space ahead in steps of 64 MiB, which comes back when a file is closed: less than two steps is no margin.
constexpr std::uint64_t kMarginBytes = 160 * kMib;
}  // namespace

void WriteRate::add(HostTime now, std::uint64_t bytes) {
  if (!last_time_ || bytes < last_bytes_) {
    *this = {};
  } else if (const double interval_s = to_seconds(now - *last_time_); interval_s > 0) {
    seconds_ += interval_s;
    const double rate = static_cast<double>(bytes - last_bytes_) / interval_s;
    const double weight = std::max(interval_s / seconds_, 1 - std::exp(-interval_s / kTimeConstant_s));
    bytes_per_s_ += weight * (rate - bytes_per_s_);
  }
  last_time_ = now;
  last_bytes_ = bytes;
}

DiskVerdict DiskGuard::judge(const std::filesystem::path& directory, std::uint64_t free_bytes, std::uint64_t recorded_bytes,
                             double bytes_per_s) {
  DiskVerdict verdict;
  const std::uint64_t least = options_.least_free_bytes;
  const std::uint64_t above = free_bytes > least ? free_bytes - least : 0;
  if (bytes_per_s >= 1) verdict.left_s = static_cast<double>(above) / bytes_per_s;

  const bool is_ring = options_.when_full == WhenFull::oldest;
  const std::uint64_t kept = options_.keep_at_most_bytes;
  std::uint64_t missing = free_bytes < least ? least - free_bytes : 0;
  if (is_ring && kept > 0 && recorded_bytes > kept) missing = std::max(missing, recorded_bytes - kept);
  if (is_full_ && free_bytes < least + std::min(kMarginBytes, least))
    missing = std::max(missing, least + kMarginBytes - free_bytes);
  verdict.missing_bytes = missing;
  if (is_ring) {
    is_full_ = false;
    verdict.left_s = 0;  // it lasts for ever
    if (missing > 0) verdict.kind = DiskVerdict::Kind::make_room;
    return verdict;
  }
  is_full_ = missing > 0;
  if (is_full_) {
    verdict.kind = DiskVerdict::Kind::full;
    verdict.left_s = 0;
    verdict.message = fmt::format(
        "{} has {} left, less than the {} that are to stay free: recording has stopped, the file is whole. "
        "Free some space or record to another disk",
        directory.string(), words_for_bytes(free_bytes), words_for_bytes(least));
  } else if (verdict.left_s > 0 && verdict.left_s < to_seconds(options_.warn_ahead)) {
    verdict.kind = DiskVerdict::Kind::warn;
    verdict.message =
        fmt::format("{} will be full in {} at the present {}/s: recording stops then. Free some space", directory.string(),
                    words_for_seconds(verdict.left_s), words_for_bytes(static_cast<std::uint64_t>(bytes_per_s)));
  }
  return verdict;
}

std::vector<SessionFile> oldest_to_delete(const std::vector<SessionFile>& files, std::uint64_t missing_bytes,
                                          const std::vector<std::filesystem::path>& spared) {
  std::vector<SessionFile> chosen;
  std::uint64_t freed = 0;
  for (const SessionFile& file : files) {
    if (freed >= missing_bytes) break;
    if (!file.is_finished || std::ranges::find(spared, file.path) != spared.end()) continue;
    chosen.push_back(file);
    freed += file.bytes;
  }
  return chosen;
}

std::string words_for_seconds(double seconds) {
  const auto whole = static_cast<std::int64_t>(seconds);
  if (whole >= 86'400) return fmt::format("{} d {} h", whole / 86'400, whole % 86'400 / 3600);
  if (whole >= 3600) return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
  if (whole >= 120) return fmt::format("{} min", whole / 60);
  return fmt::format("{} s", whole);
}

std::string words_for_bytes(std::uint64_t bytes) {
  if (bytes >= kGib) return fmt::format("{:.1f} GiB", static_cast<double>(bytes) / static_cast<double>(kGib));
  if (bytes >= kMib) return fmt::format("{} MiB", bytes / kMib);
  return fmt::format("{} KiB", bytes / 1024);
}

}  // namespace roseau::recorder
