#include "replay/pacer.h"

#include <cmath>
#include <utility>

namespace roseau::replay {

Pacer::Pacer(HostTime begin, HostTime end, double speed, Clock now)
    : begin_(begin),
      end_(end),
      now_(std::move(now)),
      anchor_session_(begin),
      anchor_host_(now_()),
      position_(begin),
      speed_(speed) {}

void Pacer::anchor_here() {
  anchor_session_ = position_;
  anchor_host_ = now_();
}

void Pacer::play() {
  const std::scoped_lock lock(mutex_);
  if (playing_) return;
  playing_ = true;
  anchor_here();
}

void Pacer::pause() {
  const std::scoped_lock lock(mutex_);
  playing_ = false;
}

void Pacer::set_speed(double speed) {
  if (!(speed > 0)) return;
  const std::scoped_lock lock(mutex_);
  speed_ = speed;
  anchor_here();
}

PlayerState Pacer::state() const {
  const std::scoped_lock lock(mutex_);
  return {.playing = playing_, .ended = ended_, .speed = speed_, .position = position_, .begin = begin_, .end = end_};
}

Duration Pacer::until_due(HostTime session_time) const {
  const std::scoped_lock lock(mutex_);
  if (!playing_) return Duration::max();
  if (std::isinf(speed_)) return Duration{0};
  const double ahead_s = to_seconds(session_time - anchor_session_) / speed_;
  return anchor_host_ + from_seconds(ahead_s) - now_();
}

void Pacer::reached(HostTime session_time) {
  const std::scoped_lock lock(mutex_);
  position_ = session_time;
}

void Pacer::restart() {
  const std::scoped_lock lock(mutex_);
  position_ = begin_;
  ended_ = false;
  anchor_here();
}

void Pacer::end() {
  const std::scoped_lock lock(mutex_);
  ended_ = true;
}

}  // namespace roseau::replay
