// A pseudo terminal of our own, seen from the master side: what we write, whoever opens the other side (as a serial port)
// reads. For emulators and tests.
//
// It behaves like a serial line: bytes written while nobody has the port open are lost, and readers may come and go.
// Closing our side is unplugging: the reader gets EIO.
#pragma once

#include <string>

#include "drivers/link/byte_stream.h"
#include "drivers/link/posix.h"

namespace roseau::link {

class PtyStream : public ByteStream {
 public:
  /// `link_path`: a symbolic link to the port is kept here while it is open; empty: none.
  explicit PtyStream(std::string link_path = {}) : link_path_(std::move(link_path)) {}
  ~PtyStream() override { close(); }

  Result<void> open() override;
  Result<Received> read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) override;
  Result<void> write(std::span<const std::byte> bytes) override;
  void close() override;
  std::string description() const override;
  Duration byte_time() const override { return Duration{0}; }

  /// What the other side opens: "/dev/pts/5". Empty while closed.
  const std::string& port_path() const { return port_path_; }

 private:
  Result<void> make_link();
  bool somebody_listens() const;

  std::string link_path_;
  std::string port_path_;
  bool has_link_ = false;
  FileDescriptor master_;
};

}  // namespace roseau::link
