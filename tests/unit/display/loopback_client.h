// A bare HTTP and WebSocket client over a loopback socket, for tests: it can also behave badly.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace roseau::display::testing {

struct HttpAnswer {
  int status = 0;
  std::string head;
  std::string body;

  std::string header(const std::string& name) const {
    const std::size_t at = head.find("\r\n" + name + ": ");
    if (at == std::string::npos) return "";
    const std::size_t start = at + name.size() + 4;
    return head.substr(start, head.find("\r\n", start) - start);
  }
};

struct WsMessage {
  int opcode = 0;  // 1 text, 2 binary, 8 close
  std::string payload;
};

class LoopbackClient {
 public:
  explicit LoopbackClient(std::uint16_t port, int receive_buffer_bytes = 0) : port_(port) {
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (receive_buffer_bytes > 0) {
      ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof receive_buffer_bytes);
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) ADD_FAILURE() << "no connection";
  }
  ~LoopbackClient() { ::close(socket_); }
  LoopbackClient(const LoopbackClient&) = delete;
  LoopbackClient& operator=(const LoopbackClient&) = delete;

  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }

  void send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return;  // the server has hung up: the test looks at what it said
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
  }

  /// `headers`: lines, each ending in CRLF; Host and Content-Length are added unless they are there.
  HttpAnswer request(const std::string& method, const std::string& target, const std::string& headers = "",
                     const std::string& body = "") {
    std::string text = method + " " + target + " HTTP/1.1\r\n";
    if (headers.find("Host:") == std::string::npos) text += "Host: " + host() + "\r\n";
    text += headers;
    if (!body.empty()) text += "Content-Length: " + std::to_string(body.size()) + "\r\n";
    send(text + "\r\n" + body);
    return read_answer(method == "HEAD");
  }

  HttpAnswer read_answer(bool without_body = false) {
    HttpAnswer answer;
    std::size_t end = 0;
    while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
      if (!fill()) return answer;
    }
    answer.head = buffer_.substr(0, end + 2);
    buffer_.erase(0, end + 4);
    answer.status = std::stoi(answer.head.substr(9, 3));
    const std::string length = answer.header("Content-Length");
    if (length.empty() || without_body || answer.status == 304) return answer;
    while (buffer_.size() < std::stoul(length)) {
      if (!fill()) return answer;
    }
    answer.body = buffer_.substr(0, std::stoul(length));
    buffer_.erase(0, std::stoul(length));
    return answer;
  }

  HttpAnswer upgrade(const std::string& subprotocol, const std::string& more_headers = "") {
    std::string headers = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n";
    headers += "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" + more_headers;
    if (!subprotocol.empty()) headers += "Sec-WebSocket-Protocol: " + subprotocol + "\r\n";
    return request("GET", "/", headers);
  }

  /// Masked with zeros, as a client must mask.
  void send_frame(int opcode, std::string_view payload) {
    std::string frame(1, static_cast<char>(0x80 | opcode));
    if (payload.size() < 126) {
      frame.push_back(static_cast<char>(0x80 | payload.size()));
    } else {
      frame.push_back(static_cast<char>(0x80 | 127));
      for (int shift = 56; shift >= 0; shift -= 8) frame.push_back(static_cast<char>((payload.size() >> shift) & 0xff));
    }
    frame.append(4, '\0');
    frame.append(payload);
    send(frame);
  }
  void send_text(std::string_view text) { send_frame(1, text); }

  /// The next message of the server; answers pings. Nothing when the connection has ended or nothing came for 10 s.
  std::optional<WsMessage> read_message() {
    for (;;) {
      auto message = read_frame();
      if (!message) return std::nullopt;
      if (message->opcode == 9) {
        send_frame(10, message->payload);
        continue;
      }
      return message;
    }
  }

  /// The first text message holding `words`; others are passed over.
  std::string read_text_with(std::string_view words) {
    while (auto message = read_message()) {
      if (message->opcode == 1 && message->payload.find(words) != std::string::npos) return message->payload;
      if (message->opcode == 8) break;
    }
    ADD_FAILURE() << "no message with " << words;
    return "";
  }

  bool at_end() { return buffer_.empty() && !fill(); }

 private:
  std::optional<WsMessage> read_frame() {
    if (!need(2)) return std::nullopt;
    const auto byte = [this](std::size_t i) { return static_cast<std::uint64_t>(static_cast<unsigned char>(buffer_[i])); };
    std::size_t head = 2;
    std::uint64_t length = byte(1) & 0x7f;
    const std::size_t extra = length == 126 ? 2 : length == 127 ? 8 : 0;
    if (!need(head + extra)) return std::nullopt;
    if (extra > 0) {
      length = 0;
      for (std::size_t i = 0; i < extra; ++i) length = length << 8 | byte(head + i);
      head += extra;
    }
    if (!need(head + length)) return std::nullopt;
    WsMessage message{static_cast<int>(byte(0) & 0x0f), buffer_.substr(head, length)};
    buffer_.erase(0, head + length);
    return message;
  }

  bool need(std::size_t count) {
    while (buffer_.size() < count) {
      if (!fill()) return false;
    }
    return true;
  }

  bool fill() {
    pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
    constexpr int kPatience_ms = 10'000;
    if (::poll(&ready, 1, kPatience_ms) <= 0) return false;
    char piece[65536];
    const ssize_t count = ::recv(socket_, piece, sizeof piece, 0);
    if (count <= 0) return false;
    buffer_.append(piece, static_cast<std::size_t>(count));
    return true;
  }

  std::uint16_t port_;
  int socket_ = -1;
  std::string buffer_;
};

}  // namespace roseau::display::testing
