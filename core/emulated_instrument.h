// EmulatedInstrument: an instrument's side of a conversation on a byte stream. Implemented by synthesis (the instruments of the
// simulated field); played on ttys and sockets by replay.
#pragma once

#include <string>
#include <string_view>

#include "core/time.h"

namespace roseau {

/// One thread at a time. Times are since the instrument's start.
class EmulatedInstrument {
 public:
  virtual ~EmulatedInstrument() = default;
  virtual const std::string& name() const = 0;

  /// When what it sends next, unasked, is through on the wire. Duration::max() when nothing will ever come.
  virtual Duration next() const = 0;

  /// What that is (empty: it keeps silent this time); goes on to what comes after. What is long overdue is left out.
  virtual std::string send(Duration now) = 0;

  /// What it answers to bytes that have come.
  virtual std::string answer(std::string_view received, Duration now) = 0;

  /// False: its cable is pulled.
  virtual bool is_connected(Duration now) const = 0;
};

}  // namespace roseau
