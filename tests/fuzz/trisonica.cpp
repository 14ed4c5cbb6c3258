#include "drivers/wire/trisonica.h"

#include "tests/fuzz/feed.h"

// Any bytes, cut two ways, give the same; what comes out is read again as it was. The first byte chooses whether the layout is
// told or learned.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roseau;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  wire::TriSonicaDecoder::Options options;
  const auto layout = wire::default_trisonica_layout();
  if (data[0] % 2 != 0) options.layout = layout;
  wire::TriSonicaDecoder whole(options);
  wire::TriSonicaDecoder cut(options);
  for (const auto& sample : fuzz::check_cuts(whole, cut, text)) {
    const auto& wind = std::get<WindSample>(sample.payload);
    const auto line = wire::encode_trisonica(wind, layout);
    ROSEAU_CHECK(wire::parse_trisonica(std::string_view(line).substr(0, line.size() - 2), layout));
  }
  (void)wire::TriSonicaLayout::parse(text);
  return 0;
}
