#include "schema/recorded_header.h"

#include "schema/messages.h"
#include "schema/schemas.h"
#include "schema/wire.h"

namespace roseau::schema {

namespace {

struct MovedHeader {
  SampleHeader header;
  HostTime host_arrival_time;
  HostTime host_sample_time;
};

template <class Io>
void describe(Io& io, typename Io::template Ref<MovedHeader> moved) {
  describe(io, moved.header);
  io.time(5, moved.host_arrival_time);
  io.time(6, moved.host_sample_time);
}

struct Fields {
  std::uint32_t time;
  std::uint32_t header;
};

/// Where each message has them: messages.h.
Fields fields_of(SampleKind kind) {
  return {.time = kind == SampleKind::image_motion ? 5U : 1U,
          .header = schema_name(kind).starts_with("foxglove.") ? kHeaderField : 2U};
}

}  // namespace

Result<SampleHeader> read_header(SampleKind kind, std::span<const std::byte> message, const SampleHeader& known) {
  const Fields fields = fields_of(kind);
  SampleHeader header = known;
  Reader reader(message);
  reader.read([&](Reader& io) {
    io.time(fields.time, header.sample_time);
    io.message(fields.header, header);
  });
  if (reader.fault()) return *reader.fault();
  return header;
}

void append_corrected_times(SampleKind kind, const SampleHeader& corrected, const SampleHeader& own,
                            std::vector<std::byte>& message) {
  const Fields fields = fields_of(kind);
  Writer writer(message);
  writer.time(fields.time, corrected.sample_time);
  writer.message(fields.header, MovedHeader{corrected, own.arrival_time, own.sample_time});
}

}  // namespace roseau::schema
