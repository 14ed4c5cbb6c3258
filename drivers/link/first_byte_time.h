// When the first byte of a read was on the wire. Pure.
//
// The system tells only when a read returned, with n bytes that each took byte_time. So the first began n byte times before,
// but not before the end of the bytes read earlier: two bytes cannot be on one wire at once (NCAR NIDAS, doc/timetags.md,
// uses the same rule). The times never run backwards.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

#include "core/time.h"

namespace roseau::link {

class FirstByteTime {
 public:
  explicit FirstByteTime(Duration byte_time) : byte_time_(byte_time) {}

  /// `read_time`: when the read of `size` bytes returned; never earlier than the one before.
  HostTime of_read(HostTime read_time, std::size_t size) {
    const Duration on_wire = byte_time_ * static_cast<Duration::rep>(size);
    HostTime first = read_time - on_wire;
    // The cap at read_time is for senders faster than the stated rate (USB adapters, pseudo terminals): else the ends of
    // the reads would run ahead of the clock.
    if (end_of_previous_) first = std::min(std::max(first, *end_of_previous_), read_time);
    end_of_previous_ = first + on_wire;
    return first;
  }

  Duration byte_time() const { return byte_time_; }

  /// After a reopening: what came before no longer binds.
  void reset() { end_of_previous_.reset(); }

 private:
  Duration byte_time_;
  std::optional<HostTime> end_of_previous_;
};

}  // namespace roseau::link
