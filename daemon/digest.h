// Digest: one SHA-256 over every derived sample in order: topic, sample time, recorded message. Two runs over the same inputs
// that print the same digest gave the same results to the bit.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/stream.h"

namespace roseau::daemon {

/// One thread at a time.
class Digest {
 public:
  Digest();
  ~Digest();
  Digest(const Digest&) = delete;
  Digest& operator=(const Digest&) = delete;

  /// Counts only samples of derived streams; anything else is ignored.
  void add(const Sample& sample, const StreamTable& streams);
  /// So far, as 64 hexadecimal digits. May be called any number of times.
  std::string hex() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
  std::vector<std::byte> message_;  // reused
};

}  // namespace roseau::daemon
