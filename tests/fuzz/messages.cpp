// Any bytes as a message of any kind. What is accepted must be writable, and read back the same.
#include <cstdint>
#include <span>
#include <vector>

#include "core/check.h"
#include "schema/conversion.h"

using namespace roseau;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  StreamTable streams;
  const StreamId stream = streams.add({.topic = "/fuzz", .kind = "log"});
  FramePool frames(2, 4096);
  const auto kind = static_cast<SampleKind>(data[0] % kSampleKindCount);
  const auto message = std::as_bytes(std::span(data + 1, size - 1));
  const auto sample = schema::parse(kind, message, {.stream = stream}, streams, &frames);
  if (!sample) return 0;
  std::vector<std::byte> written;
  schema::serialize(*sample, streams, written);
  const auto again = schema::parse(kind, written, {.stream = stream}, streams, &frames);
  ROSEAU_CHECK(again || again.error().code == ErrorCode::unsupported);
  return 0;
}
