#include "replay/pacer.h"

#include <algorithm>
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

void Pacer::changed() {
  ++changes_;
  change_.notify_all();
}

void Pacer::jump_to(HostTime time) {
  position_ = time;
  shown_until_ = time + lookahead_;
  showing_ = true;
  ended_ = false;
  ++jumps_;
  anchor_here();
}

void Pacer::play() {
  const std::scoped_lock lock(mutex_);
  if (playing_ && !ended_) return;
  playing_ = true;
  if (position_ >= end_ && !seek_) {
    seek_ = begin_;
    jump_to(begin_);
  }
  anchor_here();
  changed();
}

void Pacer::pause() {
  const std::scoped_lock lock(mutex_);
  playing_ = false;
  changed();
}

void Pacer::set_speed(double speed) {
  if (!(speed > 0)) return;
  const std::scoped_lock lock(mutex_);
  speed_ = speed;
  anchor_here();
  changed();
}

void Pacer::seek(HostTime time) {
  const std::scoped_lock lock(mutex_);
  seek_ = std::clamp(time, begin_, end_);
  jump_to(*seek_);
  changed();
}

PlayerState Pacer::state() const {
  const std::scoped_lock lock(mutex_);
  return {.playing = playing_,
          .ended = ended_,
          .speed = speed_,
          .position = position_,
          .begin = begin_,
          .end = end_,
          .jumps = jumps_,
          .jumps_done = jumps_done_};
}

void Pacer::set_lookahead(Duration lookahead) {
  const std::scoped_lock lock(mutex_);
  lookahead_ = lookahead;
}

Duration Pacer::until_due_locked(HostTime session_time) const {
  if (!playing_) return showing_ ? Duration{0} : Duration::max();
  if (std::isinf(speed_)) return Duration{0};
  const double ahead_s = to_seconds(session_time - anchor_session_) / speed_;
  return anchor_host_ + from_seconds(ahead_s) - now_();
}

Duration Pacer::until_due(HostTime session_time) const {
  const std::scoped_lock lock(mutex_);
  return until_due_locked(session_time);
}

Duration Pacer::wait_until_due(HostTime session_time, Duration limit) {
  std::unique_lock lock(mutex_);
  const Duration wait = until_due_locked(session_time);
  if (wait <= Duration{0}) return wait;
  const std::uint64_t before = changes_;
  change_.wait_for(lock, std::min(wait, limit), [this, before] { return changes_ != before; });
  return until_due_locked(session_time);
}

void Pacer::reached(HostTime session_time) {
  const std::scoped_lock lock(mutex_);
  if (session_time >= shown_until_ && !seek_) showing_ = false;
  // What leads up to a place that was sought, or shows it while paused, does not move the place.
  if (playing_ && !seek_) position_ = std::max(position_, session_time);
}

std::optional<HostTime> Pacer::take_seek() {
  const std::scoped_lock lock(mutex_);
  if (seek_) jumps_done_ = jumps_;
  return std::exchange(seek_, std::nullopt);
}

bool Pacer::has_seek() const {
  const std::scoped_lock lock(mutex_);
  return seek_.has_value();
}

void Pacer::wait_for_change(Duration limit) {
  std::unique_lock lock(mutex_);
  if (seek_) return;
  const std::uint64_t before = changes_;
  change_.wait_for(lock, limit, [this, before] { return changes_ != before; });
}

void Pacer::restart() {
  const std::scoped_lock lock(mutex_);
  if (seek_) return;  // somebody wants to be elsewhere: that is carried out next
  jump_to(begin_);
  jumps_done_ = jumps_;
}

void Pacer::end() {
  const std::scoped_lock lock(mutex_);
  if (seek_) return;
  ended_ = true;
  position_ = end_;
}

}  // namespace roseau::replay
