// `roseau record`: tells the daemon that runs on this machine to start, stop or trigger, by the same interface as the page.

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "recorder/control/disk_guard.h"

namespace roseau::daemon {

namespace {

using nlohmann::json;
using recorder::words_for_bytes;
using recorder::words_for_seconds;

struct Answer {
  int status = 0;
  std::string body;
};

class Connection {
 public:
  explicit Connection(std::uint16_t port) : port_(port), fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {}
  ~Connection() {
    if (fd_ >= 0) ::close(fd_);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  Result<Answer> ask(const std::string& request) {
    const timeval patience{.tv_sec = 5, .tv_usec = 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port_);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      return failure("no roseau answers there: start it (roseau run CONFIG), or name its port with --port");
    }
    if (::send(fd_, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size())) {
      return failure("it does not listen");
    }
    std::string text;
    char buffer[4096];
    while (true) {
      const ssize_t got = ::recv(fd_, buffer, sizeof buffer, 0);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return failure("it does not answer");
      if (got == 0) break;
      text.append(buffer, static_cast<std::size_t>(got));
    }
    return parse(text);
  }

 private:
  Error failure(const std::string& what) const {
    return {ErrorCode::disconnected, fmt::format("127.0.0.1:{}: {}; {}", port_, std::strerror(errno), what)};
  }
  /// "HTTP/1.1 200 OK\r\n...\r\n\r\nbody"; the connection ends behind it.
  Result<Answer> parse(const std::string& text) const {
    Answer answer;
    const std::size_t body = text.find("\r\n\r\n");
    const bool is_http = text.starts_with("HTTP/1.") && text.size() > 12 && body != std::string::npos;
    if (!is_http || std::from_chars(text.data() + 9, text.data() + 12, answer.status).ec != std::errc{}) {
      return Error{ErrorCode::unsupported, fmt::format("127.0.0.1:{}: who answers there is no roseau", port_)};
    }
    answer.body = text.substr(body + 4);
    return answer;
  }

  std::uint16_t port_;
  int fd_;
};

Result<json> ask(std::uint16_t port, const std::string& method, const std::string& target, const std::string& body) {
  auto request = fmt::format("{} {} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: close\r\n", method, target, port);
  if (!body.empty()) request += fmt::format("Content-Type: application/json\r\nContent-Length: {}\r\n", body.size());
  const auto answer = Connection(port).ask(request + "\r\n" + body);
  if (!answer) return answer.error();
  auto said = json::parse(answer->body, nullptr, /*allow_exceptions=*/false);
  if (!said.is_object()) return Error{ErrorCode::unsupported, fmt::format("127.0.0.1:{}: answered {}", port, answer->status)};
  if (answer->status >= 300) return Error{ErrorCode::busy, said.value("error", fmt::format("refused ({})", answer->status))};
  return said;
}

std::string in_words(const json& status) {
  std::string text = status.value("phase", "");
  if (const auto cause = status.value("cause", ""); !cause.empty()) text += " (" + cause + ")";
  if (const double ends_s = status.value("ends_s", 0.0); ends_s > 0) text += fmt::format(", ends in {:.0f} s", ends_s);
  text += "\n";
  if (const auto path = status.value("path", ""); !path.empty()) {
    text += fmt::format("file: {}, part {}, {} so far\n", path, status.value("part", 0),
                        words_for_bytes(status.value("session_bytes", std::uint64_t{0})));
  }
  text += fmt::format("disk: {} free", words_for_bytes(status.value("disk_free_bytes", std::uint64_t{0})));
  if (const double left_s = status.value("disk_free_s", 0.0); left_s > 0) text += ", enough for " + words_for_seconds(left_s);
  text += "\n";
  if (const double kept_s = status.value("pre_trigger_s", 0.0); kept_s > 0)
    text += fmt::format("kept for a trigger: {:.1f} s\n", kept_s);
  if (const auto& copy = status.at("copy"); copy.is_object()) {
    text += fmt::format("copy: {} verified in {}, {} behind. {}\n",
                        words_for_bytes(copy.value("verified_bytes", std::uint64_t{0})), copy.value("directory", ""),
                        words_for_bytes(copy.value("behind_bytes", std::uint64_t{0})), copy.value("message", ""));
  }
  if (const auto message = status.value("message", ""); !message.empty()) text += message + "\n";
  return text;
}

}  // namespace

int record_command(const RecordArguments& arguments) {
  if (arguments.order == "status") {
    const auto status = ask(arguments.port, "GET", "/api/recording", "");
    if (!status) return failed(status.error());
    std::fputs((arguments.json ? status->dump() + "\n" : in_words(*status)).c_str(), stdout);
    return kExitOk;
  }
  json action = {{"kind", arguments.order == "trigger" ? "trigger" : arguments.order + "_recording"}};
  if (!arguments.text.empty()) action["text"] = arguments.text;
  const auto done = ask(arguments.port, "POST", "/api/action", action.dump());
  if (!done) return failed(done.error());
  std::fputs(arguments.json ? "{}\n" : "done\n", stdout);
  return kExitOk;
}

}  // namespace roseau::daemon
