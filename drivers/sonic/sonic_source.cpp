#include "drivers/sonic/sonic_source.h"

#include <utility>

namespace roseau::sonic {

SonicSource::SonicSource(SonicOptions options, std::unique_ptr<link::ByteStream> stream)
    : ByteSource(std::move(options.name), std::move(stream)), anemometer_(std::move(options.anemometer)) {
  anemometer_.keeps_messages_apart = this->stream().keeps_messages_apart();
}

StreamId SonicSource::declare(StreamTable& streams) {
  const StreamInfo raw = wire::raw_stream(name(), anemometer_, stream().description());
  const StreamId id = streams.add(raw);
  streams.add(wire::wind_stream(raw));
  return id;
}

}  // namespace roseau::sonic
