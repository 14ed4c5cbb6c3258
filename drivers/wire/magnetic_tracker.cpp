#include "drivers/wire/magnetic_tracker.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/wire/fastrak_decoder.h"
#include "drivers/wire/metadata.h"

namespace roseau::wire {

namespace {
constexpr std::string_view kFastrak = "polhemus_fastrak";
constexpr std::string_view kCentimetre = "cm";
constexpr std::string_view kInch = "inch";
}  // namespace

std::string_view to_string(MagneticTrackerModel) { return kFastrak; }

Result<MagneticTrackerModel> magnetic_tracker_model_from_string(std::string_view name) {
  if (name == kFastrak) return MagneticTrackerModel::polhemus_fastrak;
  return Error{ErrorCode::invalid_argument,
               fmt::format("magnetic tracker model '{}' is not known; known is {}", name, kFastrak)};
}

std::string_view to_string(FastrakUnit unit) { return unit == FastrakUnit::inch ? kInch : kCentimetre; }

Result<FastrakUnit> fastrak_unit_from_string(std::string_view name) {
  if (name == kInch) return FastrakUnit::inch;
  if (name == kCentimetre) return FastrakUnit::centimetre;
  return Error{ErrorCode::invalid_argument, fmt::format("unit '{}' is not one of {}, {}", name, kCentimetre, kInch)};
}

StreamInfo raw_stream(const std::string& device, const MagneticTrackerOptions& options, const std::string& link) {
  return {.topic = "/" + device + std::string(kRawSuffix),
          .kind = std::string(to_string(SampleKind::raw_bytes)),
          .role = StreamRole::raw,
          .device = device,
          .metadata = {{"model", std::string(to_string(options.model))},
                       {"items", options.layout.text()},
                       {"unit", std::string(to_string(options.unit))},
                       {"stations", fmt::format("{}", fmt::join(options.stations, ","))},
                       {"rate_hz", fmt::format("{}", options.rate_hz())},
                       {"delay_s", fmt::format("{}", options.delay_s)},
                       {"link", link}}};
}

StreamInfo pose_stream(const StreamInfo& raw, int station) {
  StreamInfo pose = derived_stream(raw, fmt::format("station{}/pose", station), SampleKind::station_pose);
  pose.metadata["station"] = fmt::format("{}", station);
  return pose;
}

std::unique_ptr<Decoder> make_magnetic_tracker_decoder(const StreamInfo& raw, StreamTable& streams) {
  if (!magnetic_tracker_model_from_string(metadata_value(raw, "model"))) return nullptr;
  auto layout = FastrakLayout::parse(metadata_value(raw, "items"));
  const auto unit = fastrak_unit_from_string(metadata_value(raw, "unit"));
  if (!layout || !unit) return nullptr;
  return std::make_unique<FastrakDecoder>(FastrakDecoder::Options{
      .layout = std::move(*layout),
      .unit = *unit,
      .delay = from_seconds(metadata_number(raw, "delay_s", 0)),
      .stream_of_station = [raw, &streams](int station) { return streams.add(pose_stream(raw, station)); }});
}

}  // namespace roseau::wire
