// An anemometer on a byte stream: hands on its bytes as they come. Decoding happens behind the point where they are recorded
// (drivers/wire/anemometer.h), so live and replay decode alike.
#pragma once

#include <memory>
#include <string>

#include "drivers/link/byte_source.h"
#include "drivers/wire/anemometer.h"

namespace roseau::sonic {

struct SonicOptions {
  std::string name = "sonic";
  wire::AnemometerOptions anemometer;  // keeps_messages_apart is taken from the stream
};

/// Emits RawBytes on "/<name>/raw" and declares "/<name>/wind" with the same description. The instrument is listened to, never
/// told anything.
class SonicSource : public link::ByteSource {
 public:
  SonicSource(SonicOptions options, std::unique_ptr<link::ByteStream> stream);

 protected:
  StreamId declare(StreamTable& streams) override;

 private:
  wire::AnemometerOptions anemometer_;
};

}  // namespace roseau::sonic
