// PlayerControl: what a page or a client may ask of a replay. Thread-safe.
#pragma once

#include <cstdint>
#include <string>

#include "core/time.h"

namespace roseau {

/// What was marked or noted when the session that is replayed was recorded.
struct RecordedMark {
  HostTime time;
  std::string text;
};

struct PlayerState {
  bool playing = true;
  bool ended = false;
  double speed = 1;  // of recorded time; infinity = as fast as possible
  HostTime position;
  HostTime begin;
  HostTime end;
  /// How often the position was made to jump so far: rises with every seek and with every new round of a loop. Whoever finds
  /// it changed forgets what was shown before.
  std::uint64_t jumps = 0;
  /// Of these, carried out: while it is less than `jumps`, samples of the place before may still be under way.
  std::uint64_t jumps_done = 0;
};

class PlayerControl {
 public:
  virtual ~PlayerControl() = default;
  /// At the end: from the beginning again.
  virtual void play() = 0;
  virtual void pause() = 0;
  virtual void set_speed(double speed) = 0;
  /// Goes on from `time`, playing or paused as before; times outside of the session mean its begin or its end. Analysis starts
  /// anew there. Of several seeks in quick succession only the last one may be carried out.
  virtual void seek(HostTime time) = 0;
  virtual PlayerState state() const = 0;
};

}  // namespace roseau
