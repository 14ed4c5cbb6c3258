// A target's displacement as identification and filter want it: at equal steps. Finds the rate from the samples' own times,
// places each sample on the nearest step, marks the steps that were missed, and begins anew after a hole or a change of rate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry.h"
#include "core/time.h"

namespace roseau::estimation {

class DisplacementSeries {
 public:
  /// Holes up to `max_gap_s` (or three steps, if that is longer) are bridged.
  explicit DisplacementSeries(double max_gap_s) : max_gap_s_(max_gap_s) {}

  struct Frame {
    std::int64_t time_ns = 0;  // host time; of a missing frame: where it should have been
    Vec2 at;                   // NaN where missing
    bool measured = true;

    template <class Archive>
    void archive(Archive& a) {
      a(time_ns), a(at.x), a(at.y), a(measured);
    }
  };

  enum class Added {
    nothing,    // not used: out of order or doubled, or the rate is not known yet
    appended,   // one frame, and the missing ones before it
    restarted,  // what was there is gone: frames() begins with this sample (and those held back until the rate was known)
  };
  /// Only samples that are valid. `appended_count()` says how many frames this one added.
  Added add(HostTime time, Vec2 at);
  std::size_t appended_count() const { return appended_; }

  const std::vector<Frame>& frames() const { return frames_; }
  double period_s() const { return period_s_; }
  /// Since the last restart, forgotten frames included.
  double segment_s() const { return static_cast<double>(segment_frames_) * period_s_; }
  /// Keeps the newest `count` frames or a few more.
  void keep_newest(std::size_t count);
  /// Period from first to last frame kept: better than a median of differences.
  void refine_period();

  /// Component along `axis` of the newest `count` frames, missing ones filled by straight lines.
  std::vector<double> along(Vec2 axis, std::size_t count) const;

  template <class Archive>
  void archive(Archive& a) {
    a(frames_), a(held_), a(differences_ns_), a(segment_frames_), a(period_s_), a(seen_ns_), a(placed_ns_), a(late_steps_);
  }

 private:
  void note_difference(std::int64_t difference_ns);
  bool rate_has_changed() const;
  void append(std::int64_t time_ns, Vec2 at, bool measured);
  Added hold(std::int64_t time_ns, Vec2 at);
  Added place(std::int64_t time_ns, Vec2 at);

  double max_gap_s_;
  std::vector<Frame> frames_;
  std::vector<Frame> held_;                   // until the rate is known
  std::vector<std::int64_t> differences_ns_;  // of the last samples
  std::uint64_t segment_frames_ = 0;
  std::size_t appended_ = 0;
  double period_s_ = 0;                  // 0: not known
  std::optional<std::int64_t> seen_ns_;  // the last sample's time, and that of the last one placed
  std::optional<std::int64_t> placed_ns_;
  double late_steps_ = 0;  // the last one placed, behind the grid
};

/// Unit vector of the largest scatter of the newest `count` frames about their trend. The sign follows `previous` where there
/// is one; else x is positive, or y for an axis within 15 degrees of the vertical.
Vec2 main_axis(const DisplacementSeries& series, std::size_t count, const Vec2* previous);

}  // namespace roseau::estimation
