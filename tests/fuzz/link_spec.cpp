// Any text is either a stream or an error with words.
#include "drivers/link/link_spec.h"

#include "core/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto stream = roseau::link::make_byte_stream(text);
  if (!stream) ROSEAU_CHECK(!stream.error().message.empty());
  if (stream) ROSEAU_CHECK((*stream)->byte_time() >= roseau::Duration{0});
  return 0;
}
