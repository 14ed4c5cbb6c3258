// Pacer: when is the next recorded sample due? Keeps a session's time running at a speed, with pauses.
#pragma once

#include <functional>
#include <mutex>

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
  PlayerState state() const override;

  /// How long until the sample at `session_time` is due; zero or less: now. Duration::max() while paused.
  Duration until_due(HostTime session_time) const;

  /// The replaying thread tells how far it is.
  void reached(HostTime session_time);
  /// From the start again (a loop), or ended.
  void restart();
  void end();

 private:
  // While playing, session time `anchor_session_` was (or will be) due at `anchor_host_`.
  void anchor_here();

  const HostTime begin_;
  const HostTime end_;
  const Clock now_;
  mutable std::mutex mutex_;
  HostTime anchor_session_;
  HostTime anchor_host_;
  HostTime position_;
  double speed_;
  bool playing_ = true;
  bool ended_ = false;
};

}  // namespace roseau::replay
