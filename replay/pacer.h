// Pacer: when is the next recorded sample due? Keeps a session's time running at a speed, with pauses and jumps.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>

#include "core/player_control.h"
#include "core/time.h"

namespace roseau::replay {

/// Thread-safe: the replaying thread asks, pages and clients control.
class Pacer : public PlayerControl {
 public:
  using Clock = std::function<HostTime()>;

  /// `speed`: recorded seconds per second; infinity = as fast as possible. `now`: the host's monotonic clock.
  Pacer(HostTime begin, HostTime end, double speed, Clock now);

  void play() override;
  void pause() override;
  /// Speeds that are not positive are ignored.
  void set_speed(double speed) override;
  void seek(HostTime time) override;
  PlayerState state() const override;

  /// After a seek while paused, samples up to this much later than the place are due all the same: what is shown of a place
  /// comes out of the analysis only when it has seen a little more.
  void set_lookahead(Duration lookahead);

  /// How long until the sample at `session_time` is due; zero or less: now. Duration::max() while paused.
  Duration until_due(HostTime session_time) const;
  /// The same, after waiting until it is due, at most `limit`, or until somebody played, paused, sought or changed the speed.
  Duration wait_until_due(HostTime session_time, Duration limit);

  /// The replaying thread tells how far it is.
  void reached(HostTime session_time);
  /// The last place sought since the call before, if any: it is being carried out.
  std::optional<HostTime> take_seek();
  /// Whether take_seek() would give one.
  bool has_seek() const;
  /// Waits until somebody played, paused, sought or changed the speed, at most `limit`. Not at all when a seek waits.
  void wait_for_change(Duration limit);
  /// From the start again (a loop): a jump that nobody asked for.
  void restart();
  void end();

 private:
  // While playing, session time `anchor_session_` was (or will be) due at `anchor_host_`.
  void anchor_here();
  void jump_to(HostTime time);
  Duration until_due_locked(HostTime session_time) const;
  void changed();

  const HostTime begin_;
  const HostTime end_;
  const Clock now_;
  mutable std::mutex mutex_;
  std::condition_variable change_;
  std::uint64_t changes_ = 0;
  HostTime anchor_session_;
  HostTime anchor_host_;
  HostTime position_;
  Duration lookahead_{0};
  HostTime shown_until_{Duration::min()};  // what is due even while paused ends with the first sample from here on
  bool showing_ = false;
  std::optional<HostTime> seek_;  // asked for, not yet taken
  double speed_;
  bool playing_ = true;
  bool ended_ = false;
  std::uint64_t jumps_ = 0;
  std::uint64_t jumps_done_ = 0;
};

}  // namespace roseau::replay
