// Any bytes, cut two ways, give the same poses and counters; every pose goes through the encoder and back.
#include "drivers/wire/fastrak.h"

#include <cmath>

#include "drivers/wire/fastrak_decoder.h"
#include "tests/fuzz/feed.h"

namespace {

using namespace roseau;
using namespace roseau::wire;

FastrakDecoder::Options options_of(const FastrakLayout& layout) {
  return {.layout = layout, .unit = FastrakUnit::centimetre, .stream_of_station = [](int station) {
            return static_cast<StreamId>(station);
          }};
}

void check_echo(const Sample& sample, const FastrakLayout& layout) {
  const auto& sent = std::get<StationPose>(sample.payload);
  // A unit stated on the way may leave a position that no longer fits its field.
  if (std::abs(sent.position_in_source_m.x) > 5) return;
  const std::string record = encode_fastrak(sent, {layout, true, FastrakUnit::centimetre});
  const auto got = parse_fastrak_binary(record, layout, FastrakUnit::centimetre);
  if (!got) return;
  ROSEAU_CHECK(got->valid == sent.valid && got->device_status == sent.device_status && got->station == sent.station);
  ROSEAU_CHECK(std::abs(got->position_in_source_m.x - sent.position_in_source_m.x) < 1e-5);
}

}  // namespace

// The first byte chooses the layout.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr std::array kLayouts = {"2,4,1", "2,11,0", "2,5,6,7,1", "52,61,1", "2,16,1"};
  const auto layout = FastrakLayout::parse(kLayouts[data[0] % kLayouts.size()]);
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  FastrakDecoder whole(options_of(*layout));
  FastrakDecoder cut(options_of(*layout));
  const auto samples = fuzz::check_cuts(whole, cut, text);
  for (const Sample& sample : samples) {
    // Without a rotation in the record there is none to encode again.
    if (!std::isnan(std::get<StationPose>(sample.payload).source_from_station.w)) check_echo(sample, *layout);
  }
  return 0;
}
