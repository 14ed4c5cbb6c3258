// PlayerControl: what a page or a client may ask of a replay. Thread-safe.
#pragma once

#include "core/time.h"

namespace roseau {

struct PlayerState {
  bool playing = true;
  bool ended = false;
  double speed = 1;  // of recorded time; infinity = as fast as possible
  HostTime position;
  HostTime begin;
  HostTime end;
};

class PlayerControl {
 public:
  virtual ~PlayerControl() = default;
  virtual void play() = 0;
  virtual void pause() = 0;
  virtual void set_speed(double speed) = 0;
  virtual PlayerState state() const = 0;
};

}  // namespace roseau
