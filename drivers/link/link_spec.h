// Where a byte stream leads, as written in a configuration:
//
//   serial:/dev/ttyUSB0?baud=19200&parity=none&bits=8&stop=1&flow=none
//   tcp://192.168.127.254:4001?baud=19200      we connect to a device server; baud = its serial side, to date first bytes
//   tcp-listen://0.0.0.0:4001                  the device connects to us; port 0 = any free one
//   udp-listen://0.0.0.0:5001                  datagrams that devices send us (answers go to the last sender)
//   udp://192.168.127.254:5001                 datagrams we send, and the answers
//   pty:  or  pty:/tmp/sonic                   a new pseudo terminal, we hold the master side; the path becomes a link to it
//   file:/data/sonic.bin?baud=19200            the bytes of a file, one after another at this rate
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "core/result.h"
#include "drivers/link/byte_stream.h"

namespace roseau::link {

enum class Parity : std::uint8_t { none, even, odd };
enum class FlowControl : std::uint8_t { none, rts_cts, xon_xoff };

struct SerialSettings {
  int baud = 9600;
  int data_bits = 8;
  Parity parity = Parity::none;
  int stop_bits = 1;
  FlowControl flow_control = FlowControl::none;

  /// Start bit, data bits, parity bit and stop bits at this rate.
  Duration byte_time() const;
};

/// A specification taken apart, before anyone knows what its scheme means.
struct LinkSpec {
  std::string scheme;                             // "serial"
  std::string path;                               // serial, pty, file
  std::string host;                               // tcp, udp; IPv6 without its brackets
  std::uint16_t port = 0;                         // tcp, udp
  std::map<std::string, std::string> parameters;  // behind the '?'
};

Result<LinkSpec> parse_link_spec(std::string_view text);

/// The stream that `text` describes, not yet opened. Everything that can be wrong with the text is found here, so that a
/// configuration can be checked without any device.
Result<std::unique_ptr<ByteStream>> make_byte_stream(std::string_view text);

}  // namespace roseau::link
