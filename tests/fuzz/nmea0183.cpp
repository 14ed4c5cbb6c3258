#include "drivers/wire/nmea0183.h"

#include "tests/fuzz/feed.h"

// Any bytes, cut two ways, give the same; every wind is read again as it was sent. The first byte chooses the sentence.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roseau;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const wire::NmeaDecoder::Options options{.source = static_cast<wire::NmeaWindSource>(data[0] % 4),
                                           .requires_checksum = data[0] % 8 < 4};
  wire::NmeaDecoder whole(options);
  wire::NmeaDecoder cut(options);
  for (const auto& sample : fuzz::check_cuts(whole, cut, text)) {
    const auto& wind = std::get<WindSample>(sample.payload);
    const auto sentence = wire::encode_nmea_wind(wind, options.source);
    const auto body = wire::nmea_body(std::string_view(sentence).substr(0, sentence.size() - 2));
    ROSEAU_CHECK(body);
    const auto again = wire::parse_nmea_wind(*body, options.source);
    ROSEAU_CHECK(again && again->valid == wind.valid);
  }
  (void)wire::parse_nmea_time(text);
  (void)wire::parse_nmea_mda(text);
  return 0;
}
