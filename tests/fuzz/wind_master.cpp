#include "drivers/wire/wind_master.h"

#include "tests/fuzz/gill_decoder.h"

// The first byte chooses how the rest is framed.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  roseau::fuzz::check_gill_decoder(
      roseau::wire::kWindMasterDialect, data[0] % 2 != 0, text,
      [](const roseau::WindSample& sample) { return roseau::wire::encode_wind_master(sample, {}); });
  return 0;
}
