// Magnetic trackers we can read, and how their raw bytes become poses. What a stream's metadata says is all that a decoder
// needs: the same one is made live and from a recorded session.
//
//   key       of the raw stream, e.g. /tracker/raw; the streams /tracker/station1/pose, ... carry all but the link on
//
//   model     polhemus_fastrak
//
//   items     what a record holds, as the numbers of the tracker's command O: 2,11,0
//
//   unit      cm, inch: what the tracker counts in, until it says otherwise itself
//
//   stations  1,2,3,4: those in use
//
//   rate_hz   records per station and second
//
//   delay_s   from the middle of the measurement to the record's first byte: sample_time = arrival - delay
//
//   link      where the bytes came from, for people
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/decoder.h"
#include "core/result.h"
#include "core/stream.h"
#include "drivers/wire/fastrak.h"

namespace roseau::wire {

enum class MagneticTrackerModel : std::uint8_t { polhemus_fastrak };
std::string_view to_string(MagneticTrackerModel model);
Result<MagneticTrackerModel> magnetic_tracker_model_from_string(std::string_view name);

std::string_view to_string(FastrakUnit unit);
Result<FastrakUnit> fastrak_unit_from_string(std::string_view name);

struct MagneticTrackerOptions {
  MagneticTrackerModel model = MagneticTrackerModel::polhemus_fastrak;
  std::vector<int> stations{1, 2, 3, 4};  // 1 to 4, each once
  FastrakLayout layout = quaternion_fastrak_layout();
  bool is_binary = true;
  FastrakUnit unit = FastrakUnit::centimetre;
  double delay_s = kFastrakDelay_s;

  double rate_hz() const { return kFastrakCycleHz / static_cast<double>(stations.size()); }
};

/// The raw stream "/<device>/raw" of a tracker, with the metadata above.
StreamInfo raw_stream(const std::string& device, const MagneticTrackerOptions& options, const std::string& link);

/// The pose stream of one station that belongs to a raw one: "/tracker/raw" -> "/tracker/station1/pose".
StreamInfo pose_stream(const StreamInfo& raw, int station);

/// The decoder of a tracker's raw stream; the streams of its stations are added to `streams`, which must outlive it. Nothing
/// when the model is none of these.
std::unique_ptr<Decoder> make_magnetic_tracker_decoder(const StreamInfo& raw, StreamTable& streams);

}  // namespace roseau::wire
