// The bytes of a file as a stream that ends. The bytes are dated as if they had come without a pause at the stated rate,
// from the moment of opening on; without a rate all at that moment. Nothing waits: the consumer sets the pace.
#pragma once

#include <string>

#include "drivers/link/byte_stream.h"
#include "drivers/link/posix.h"

namespace roseau::link {

class FileStream : public ByteStream {
 public:
  FileStream(std::string path, Duration byte_time) : path_(std::move(path)), byte_time_(byte_time) {}

  Result<void> open() override;
  Result<Received> read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) override;
  /// unsupported: a recording takes no commands.
  Result<void> write(std::span<const std::byte> bytes) override;
  void close() override;
  std::string description() const override { return "file " + path_; }
  Duration byte_time() const override { return byte_time_; }
  bool is_live() const override { return false; }

 private:
  std::string path_;
  Duration byte_time_;
  FileDescriptor file_;
  HostTime next_byte_time_;
};

}  // namespace roseau::link
