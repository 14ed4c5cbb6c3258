// ByteSource: a device on a byte stream as a SampleSource. Hands on its bytes as they come, as RawBytes; decoding happens
// behind the point where they are recorded. What differs from device to device is what its streams are called and what it
// must be told.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/source.h"
#include "drivers/link/byte_stream.h"

namespace roseau::link {

/// An Error from read means that the link is lost: close, back off, open again. Thread rule of SampleSource.
class ByteSource : public SampleSource {
 public:
  ByteSource(std::string name, std::unique_ptr<ByteStream> stream);

  const std::string& name() const override { return name_; }
  bool is_live() const override { return stream_->is_live(); }
  Result<void> open(StreamTable& streams) override;
  Result<ReadStatus> read(SampleSink& sink, std::chrono::milliseconds timeout) override;
  void close() override { stream_->close(); }

 protected:
  /// Adds the device's streams; the id of its raw one.
  virtual StreamId declare(StreamTable& streams) = 0;
  /// Called after each opening, before anything is read.
  virtual Result<void> connected() { return {}; }
  /// Called after each read with what it brought, which may be nothing: the time to say something to the device.
  virtual Result<void> talk(std::span<const std::byte> /*received*/) { return {}; }

  ByteStream& stream() { return *stream_; }
  const ByteStream& stream() const { return *stream_; }

 private:
  void hand_on(const Received& received, SampleSink& sink);

  std::string name_;
  std::unique_ptr<ByteStream> stream_;
  StreamId raw_stream_ = 0;
  std::uint32_t sequence_ = 0;
  // A slow host finds more than one record waiting; a second at 115200 baud is 11520 bytes.
  std::array<std::byte, 16384> buffer_{};
};

}  // namespace roseau::link
