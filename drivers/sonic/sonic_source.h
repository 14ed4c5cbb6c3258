// An anemometer on a byte stream: hands on its bytes as they come. Decoding happens behind the point where they are recorded
// (drivers/wire/anemometer.h), so live and replay decode alike.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "core/source.h"
#include "drivers/link/byte_stream.h"
#include "drivers/wire/anemometer.h"

namespace roseau::sonic {

struct SonicOptions {
  std::string name = "sonic";
  wire::AnemometerOptions anemometer;  // keeps_messages_apart is taken from the stream
};

/// Emits RawBytes on "/<name>/raw" and declares "/<name>/wind" with the same description. An Error from read means that the
/// port is lost: close, back off, open again. Thread rule of SampleSource.
class SonicSource : public SampleSource {
 public:
  SonicSource(SonicOptions options, std::unique_ptr<link::ByteStream> stream);

  const std::string& name() const override { return options_.name; }
  bool is_live() const override { return stream_->is_live(); }
  Result<void> open(StreamTable& streams) override;
  Result<ReadStatus> read(SampleSink& sink, std::chrono::milliseconds timeout) override;
  void close() override { stream_->close(); }

 private:
  void hand_on(const link::Received& received, SampleSink& sink);

  SonicOptions options_;
  std::unique_ptr<link::ByteStream> stream_;
  StreamId raw_stream_ = 0;
  std::uint32_t sequence_ = 0;
  // A slow host finds more than one record waiting; a second at 115200 baud is 11520 bytes.
  std::array<std::byte, 16384> buffer_{};
};

}  // namespace roseau::sonic
