// The two seams of the format: where an MCAP file goes to and comes from. Implemented by files (file_io.h), and in memory and
// with injected faults by the tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "core/result.h"

namespace roseau::mcap {

class Writable {
 public:
  virtual ~Writable() = default;
  /// Appends every part in order, all bytes or an Error. After an Error nothing of this call has been written; where that could
  /// not be arranged, every later call fails too. The parts' memory is not needed after the call, but they may be written
  /// later, in order, by another thread: what then goes wrong is the Error of a later call, and of all that follow.
  virtual Result<void> append(std::span<const std::span<const std::byte>> parts) = 0;
  /// How many of the appended bytes have been written: they survive the end of this program. More than were appended, where
  /// append writes at once. Any thread.
  virtual std::uint64_t written() const { return std::numeric_limits<std::uint64_t>::max(); }
  /// Begins to write what was appended and is still held back.
  virtual Result<void> flush() { return {}; }
  /// Returns when what was appended would survive a power cut.
  virtual Result<void> sync() = 0;
  /// Begins what sync() does, and need not wait for it.
  virtual Result<void> begin_sync() { return sync(); }
  /// The file's end will take about so many bytes: to be held back for it, besides a fixed amount.
  virtual void keep_back(std::uint64_t bytes) { static_cast<void>(bytes); }
  /// The last appends follow: space that was held back for them may now be used.
  virtual void begin_closing() {}
  /// Syncs and closes; nothing but destruction may follow.
  virtual Result<void> close() { return sync(); }
};

/// Random access to bytes that do not change while they are read. One thread at a time.
class Readable {
 public:
  virtual ~Readable() = default;
  virtual std::uint64_t size() const = 0;
  /// Fills `to` from `offset`; offset + to.size() must not pass size() (checked: a bug otherwise).
  virtual Result<void> read(std::uint64_t offset, std::span<std::byte> to) = 0;
};

}  // namespace roseau::mcap
