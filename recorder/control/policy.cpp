#include "recorder/control/policy.h"

#include <algorithm>

namespace roseau::recorder {

bool RecordingPolicy::begin(HostTime at, const std::string& cause) {
  if (is_open_ && !is_stopped_) {
    last_.reset();
    return false;
  }
  is_open_ = true;
  is_stopped_ = false;
  // Where the past would begin before time does: with everything there is.
  first_ = at.time_since_epoch() < Duration::min() + options_.pre_trigger ? HostTime::min() : at - options_.pre_trigger;
  last_.reset();
  cause_ = cause;
  return true;
}

bool RecordingPolicy::start(HostTime at, const std::string& cause) {
  is_held_ = true;
  return begin(at, cause);
}

bool RecordingPolicy::stop(HostTime at) {
  is_held_ = false;
  active_.clear();
  if (!is_open_) return false;
  is_stopped_ = true;
  if (last_ && *last_ <= at) return false;
  last_ = at;
  return true;
}

bool RecordingPolicy::begin_trigger(HostTime at, const std::string& name) {
  active_.insert(name);
  return begin(at, "trigger " + name);
}

void RecordingPolicy::end_trigger(HostTime at, const std::string& name) {
  if (active_.erase(name) == 0 || !active_.empty() || is_held_ || !is_open_) return;
  last_ = at + options_.post_trigger;
}

bool RecordingPolicy::trigger(HostTime at, const std::string& name) {
  const std::optional<HostTime> ended = last_;
  const bool began = begin_trigger(at, name);
  end_trigger(at, name);
  if (!began && last_ && ended) last_ = std::max(*last_, *ended);
  return began;
}

bool RecordingPolicy::wants(HostTime log_time) const {
  return is_open_ && log_time >= first_ && (!last_ || log_time <= *last_);
}

bool RecordingPolicy::is_over(HostTime now) {
  if (!is_open_ || !last_ || now <= *last_ + options_.settling) return false;
  abandon();
  return true;
}

void RecordingPolicy::abandon() {
  is_open_ = false;
  is_stopped_ = false;
  is_held_ = false;
  active_.clear();
  last_.reset();
  cause_.clear();
}

RecordingPhase RecordingPolicy::phase(HostTime now) const {
  if (!is_open_ || (last_ && *last_ <= now)) return RecordingPhase::idle;
  return last_ ? RecordingPhase::post_trigger : RecordingPhase::recording;
}

}  // namespace roseau::recorder
