#include "drivers/link/link_spec.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <vector>

#include "drivers/link/file_stream.h"
#include "drivers/link/pty_stream.h"
#include "drivers/link/serial_stream.h"
#include "drivers/link/tcp_stream.h"
#include "drivers/link/udp_stream.h"

namespace roseau::link {

namespace {

constexpr std::string_view kSchemes = "serial:, tcp://, tcp-listen://, udp://, udp-listen://, pty:, file:";

Error spec_error(std::string_view text, const std::string& what) {
  return {ErrorCode::invalid_argument, "link '" + std::string(text) + "': " + what};
}

std::optional<int> parse_integer(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool names_a_host(std::string_view scheme) {
  constexpr std::array<std::string_view, 4> kHostSchemes = {"tcp", "tcp-listen", "udp", "udp-listen"};
  return std::ranges::find(kHostSchemes, scheme) != kHostSchemes.end();
}

Result<void> parse_parameters(std::string_view text, std::string_view query, LinkSpec& spec) {
  while (!query.empty()) {
    const auto pair = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), pair.size() + 1));
    const auto equals = pair.find('=');
    if (equals == std::string_view::npos || equals == 0) {
      return spec_error(text, "'" + std::string(pair) + "' should read key=value");
    }
    const std::string key(pair.substr(0, equals));
    if (!spec.parameters.emplace(key, pair.substr(equals + 1)).second) return spec_error(text, "'" + key + "' is given twice");
  }
  return {};
}

Result<void> parse_host_and_port(std::string_view text, std::string_view authority, LinkSpec& spec) {
  const auto colon = authority.rfind(':');
  const auto port = colon == std::string_view::npos ? std::nullopt : parse_integer(authority.substr(colon + 1));
  if (!port || *port < 0 || *port > 65535) {
    return spec_error(text, "should end in a port number, as in " + spec.scheme + "://127.0.0.1:4001");
  }
  auto host = authority.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  if (host.empty()) return spec_error(text, "has no host; to listen on every interface write 0.0.0.0");
  spec.host = host;
  spec.port = static_cast<std::uint16_t>(*port);
  return {};
}

// Takes parameters out of a spec one by one; what nobody took is unknown.
class Parameters {
 public:
  Parameters(std::string_view text, const LinkSpec& spec) : text_(text), left_(spec.parameters) {}

  int integer(const std::string& key, int fallback, int lowest, int highest) {
    const auto given = take(key);
    if (!given) return fallback;
    const auto value = parse_integer(*given);
    if (value && *value >= lowest && *value <= highest) return *value;
    fail(key + "=" + *given + " is not a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest));
    return fallback;
  }

  template <class T>
  T choice(const std::string& key, T fallback, const std::vector<std::pair<std::string, T>>& choices) {
    const auto given = take(key);
    if (!given) return fallback;
    std::string allowed;
    for (const auto& [name, value] : choices) {
      if (name == *given) return value;
      allowed += (allowed.empty() ? "" : ", ") + name;
    }
    fail(key + "=" + *given + " is not one of " + allowed);
    return fallback;
  }

  Result<void> finish() {
    if (!left_.empty()) {
      fail("unknown parameter '" + left_.begin()->first + "'; known here: " + (known_.empty() ? "none" : known_));
    }
    if (error_) return *error_;
    return {};
  }

 private:
  std::optional<std::string> take(const std::string& key) {
    known_ += (known_.empty() ? "" : ", ") + key;
    const auto found = left_.find(key);
    if (found == left_.end()) return std::nullopt;
    auto value = std::move(found->second);
    left_.erase(found);
    return value;
  }
  void fail(const std::string& what) {
    if (!error_) error_ = spec_error(text_, what);
  }

  std::string_view text_;
  std::map<std::string, std::string> left_;
  std::string known_;
  std::optional<Error> error_;
};

constexpr int kSlowestBaud = 50;
constexpr int kFastestBaud = 4'000'000;

SerialSettings serial_settings(Parameters& parameters) {
  SerialSettings settings;
  settings.baud = parameters.integer("baud", settings.baud, kSlowestBaud, kFastestBaud);
  settings.data_bits = parameters.integer("bits", settings.data_bits, 5, 8);
  settings.parity = parameters.choice<Parity>("parity", settings.parity,
                                              {{"none", Parity::none}, {"even", Parity::even}, {"odd", Parity::odd}});
  settings.stop_bits = parameters.integer("stop", settings.stop_bits, 1, 2);
  settings.flow_control = parameters.choice<FlowControl>(
      "flow", settings.flow_control,
      {{"none", FlowControl::none}, {"rtscts", FlowControl::rts_cts}, {"xonxoff", FlowControl::xon_xoff}});
  return settings;
}

// The serial side of a device server or of a capture: only its byte time matters; without `baud` there is none.
Duration byte_time_of(Parameters& parameters) {
  const int baud = parameters.integer("baud", 0, kSlowestBaud, kFastestBaud);
  return baud == 0 ? Duration{0} : SerialSettings{.baud = baud}.byte_time();
}

std::unique_ptr<ByteStream> make_stream(const LinkSpec& spec, Parameters& parameters) {
  if (spec.scheme == "serial") return std::make_unique<SerialStream>(spec.path, serial_settings(parameters));
  if (spec.scheme == "tcp") return std::make_unique<TcpStream>(spec.host, spec.port, byte_time_of(parameters));
  if (spec.scheme == "tcp-listen") return std::make_unique<TcpListenStream>(spec.host, spec.port, byte_time_of(parameters));
  if (spec.scheme == "udp") return std::make_unique<UdpStream>(UdpRole::send, spec.host, spec.port);
  if (spec.scheme == "udp-listen") return std::make_unique<UdpStream>(UdpRole::listen, spec.host, spec.port);
  if (spec.scheme == "pty") return std::make_unique<PtyStream>(spec.path);
  return std::make_unique<FileStream>(spec.path, byte_time_of(parameters));
}

}  // namespace

Duration SerialSettings::byte_time() const {
  const int bits = 1 + data_bits + (parity == Parity::none ? 0 : 1) + stop_bits;
  return Duration{std::chrono::seconds{bits}} / baud;
}

Result<LinkSpec> parse_link_spec(std::string_view text) {
  const auto colon = text.find(':');
  LinkSpec spec;
  spec.scheme = text.substr(0, colon == std::string_view::npos ? 0 : colon);
  const bool has_host = names_a_host(spec.scheme);
  if (!has_host && spec.scheme != "serial" && spec.scheme != "pty" && spec.scheme != "file") {
    return spec_error(text, "should begin with one of " + std::string(kSchemes));
  }
  auto rest = text.substr(colon + 1);
  const auto question_mark = rest.find('?');
  if (question_mark != std::string_view::npos) {
    if (auto parsed = parse_parameters(text, rest.substr(question_mark + 1), spec); !parsed) return parsed.error();
    rest = rest.substr(0, question_mark);
  }
  const bool has_slashes = rest.starts_with("//");
  if (has_slashes) rest.remove_prefix(2);
  if (has_host) {
    if (!has_slashes) return spec_error(text, "should begin with " + spec.scheme + "://");
    if (auto parsed = parse_host_and_port(text, rest, spec); !parsed) return parsed.error();
    return spec;
  }
  if (rest.empty() && spec.scheme != "pty")
    return spec_error(text, "names no " + std::string(spec.scheme == "file" ? "file" : "port"));
  spec.path = rest;
  return spec;
}

Result<std::unique_ptr<ByteStream>> make_byte_stream(std::string_view text) {
  const auto spec = parse_link_spec(text);
  if (!spec) return spec.error();
  const bool listens = spec->scheme.ends_with("-listen");
  if (names_a_host(spec->scheme) && !listens) {
    if (spec->port == 0) return spec_error(text, "port 0 cannot be connected to");
    if (spec->host == "0.0.0.0" || spec->host == "::") {
      return spec_error(text, "to receive on every interface write " + spec->scheme + "-listen://");
    }
  }
  Parameters parameters(text, *spec);
  auto stream = make_stream(*spec, parameters);
  if (auto checked = parameters.finish(); !checked) return checked.error();
  return stream;
}

}  // namespace roseau::link
