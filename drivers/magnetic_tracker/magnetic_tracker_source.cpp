#include "drivers/magnetic_tracker/magnetic_tracker_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace roseau::magnetic_tracker {

namespace {
// The answer to S begins with the record type '2'; data begins with '0'. Data that still comes from an earlier run has 2s, too:
// it only makes us begin a little sooner.
constexpr std::byte kAnswer{'2'};
}  // namespace

MagneticTrackerSource::MagneticTrackerSource(MagneticTrackerOptions options, std::unique_ptr<link::ByteStream> stream,
                                             Clock now)
    : ByteSource(std::move(options.name), std::move(stream)),
      tracker_(std::move(options.tracker)),
      sets_up_(options.sets_up && this->stream().is_live()),
      now_(std::move(now)) {}

StreamId MagneticTrackerSource::declare(StreamTable& streams) {
  const StreamInfo raw = wire::raw_stream(name(), tracker_, stream().description());
  const StreamId id = streams.add(raw);
  for (const int station : tracker_.stations) streams.add(wire::pose_stream(raw, station));
  return id;
}

Result<void> MagneticTrackerSource::connected() {
  if (!sets_up_) return {};
  is_started_ = false;
  first_asked_ = now_();
  ask();
  return {};
}

Result<void> MagneticTrackerSource::talk(std::span<const std::byte> received) {
  if (!sets_up_) return {};
  const HostTime now = now_();
  if (!received.empty()) last_byte_ = now;
  if (is_started_) {
    if (now - last_byte_ <= kSilence) return {};
    is_started_ = false;
    first_asked_ = now;
    ask();
    return {};
  }
  if (std::ranges::find(received, kAnswer) != received.end()) {
    start();
  } else if (now - first_asked_ > kPatience) {
    return Error{ErrorCode::timeout,
                 fmt::format("{}: the tracker on {} does not answer: is it switched on, and is the rate right?", name(),
                             stream().description())};
  } else if (now - asked_ >= kAskAgain) {
    ask();
  }
  return {};
}

void MagneticTrackerSource::ask() {
  asked_ = now_();
  send("S");
}

// Its status once more at the end: what it says about its unit is what the decoder believes.
void MagneticTrackerSource::start() {
  std::string commands = "c";
  commands += tracker_.is_binary ? "f" : "F";
  commands += tracker_.unit == wire::FastrakUnit::centimetre ? "u" : "U";
  for (const int station : tracker_.stations) commands += fmt::format("O{},{}\r", station, tracker_.layout.text());
  commands += "SC";
  last_byte_ = now_();
  is_started_ = send(commands);
}

// Where nobody is there to be told (a TCP port that waits for its device), we go on waiting; a link that is lost is for read
// to tell.
bool MagneticTrackerSource::send(std::string_view command) {
  return stream().write(std::as_bytes(std::span(command))).has_value();
}

}  // namespace roseau::magnetic_tracker
