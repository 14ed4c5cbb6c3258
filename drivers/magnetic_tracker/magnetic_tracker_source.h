// A magnetic tracker on a byte stream: sets it up, starts it, and hands on its bytes as they come. Decoding happens behind the
// point where they are recorded (drivers/wire/magnetic_tracker.h).
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/link/byte_source.h"
#include "drivers/link/posix.h"
#include "drivers/wire/magnetic_tracker.h"

namespace roseau::magnetic_tracker {

struct MagneticTrackerOptions {
  std::string name = "tracker";
  wire::MagneticTrackerOptions tracker;
  bool sets_up = true;  // false: somebody else has set the tracker up and started it; we only listen
};

/// Emits RawBytes on "/<name>/raw" and declares "/<name>/station<n>/pose" for the stations in use.
///
/// After power-up a FASTRAK says nothing for 10 to 20 seconds. So it is asked for its status until it answers, then stopped,
/// set up and started. When it falls silent while it should be sending (it was switched off and on), all that is done again.
/// A tracker that does not answer for kPatience is an Error (timeout).
class MagneticTrackerSource : public link::ByteSource {
 public:
  static constexpr Duration kAskAgain = std::chrono::seconds(2);
  static constexpr Duration kSilence = std::chrono::seconds(3);
  static constexpr Duration kPatience = std::chrono::seconds(40);

  using Clock = std::function<HostTime()>;
  MagneticTrackerSource(MagneticTrackerOptions options, std::unique_ptr<link::ByteStream> stream,
                        Clock now = link::monotonic_now);

 protected:
  StreamId declare(StreamTable& streams) override;
  Result<void> connected() override;
  Result<void> talk(std::span<const std::byte> received) override;

 private:
  void ask();
  void start();
  bool send(std::string_view command);

  wire::MagneticTrackerOptions tracker_;
  bool sets_up_;
  Clock now_;
  bool is_started_ = false;
  HostTime asked_;        // when it was asked last
  HostTime first_asked_;  // since when it owes us an answer
  HostTime last_byte_;
};

}  // namespace roseau::magnetic_tracker
