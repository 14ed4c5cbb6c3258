#include "bench/live_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace roseau::bench {

namespace {

// RFC 6455: the key is any 16 bytes in base64, the mask of a client's frames any four bytes.
constexpr const char* kRequest =
    "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: cm9zZWF1LWJlbmNoLTAwMA==\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n";
constexpr std::uint8_t kFinalText = 0x81;
constexpr std::uint8_t kMasked = 0x80;
constexpr int kPoll_ms = 50;

}  // namespace

LiveClient::LiveClient(std::uint16_t port) : port_(port) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

LiveClient::~LiveClient() {
  thread_.request_stop();
  thread_.join();
  if (socket_ >= 0) close(socket_);
}

bool LiveClient::connect_and_shake_hands() {
  socket_ = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port_);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    close(socket_);
    socket_ = -1;
    return false;
  }
  const std::string request = kRequest;
  if (send(socket_, request.data(), request.size(), MSG_NOSIGNAL) < 0) return false;
  std::string answer;
  char byte = 0;
  while (!answer.ends_with("\r\n\r\n")) {
    if (recv(socket_, &byte, 1, 0) != 1) return false;
    answer += byte;
  }
  return answer.starts_with("HTTP/1.1 101");
}

void LiveClient::send_text(const std::string& text) const {
  std::string frame;
  frame += static_cast<char>(kFinalText);
  if (text.size() < 126) {  // the shortest form is the only one allowed
    frame += static_cast<char>(kMasked | text.size());
  } else {
    frame += static_cast<char>(kMasked | 126U);
    frame += static_cast<char>(text.size() >> 8U);
    frame += static_cast<char>(text.size() & 255U);
  }
  frame.append(4, '\0');  // a mask of zeros changes nothing
  frame += text;
  send(socket_, frame.data(), frame.size(), MSG_NOSIGNAL);
}

/// Subscribes to new channels as the page does: previews instead of raw pictures, no raw bytes.
void LiveClient::take_text(const std::string& text) {
  const auto message = nlohmann::json::parse(text, nullptr, false);
  if (message.is_discarded() || message.value("op", "") != "advertise") return;
  nlohmann::json subscriptions = nlohmann::json::array();
  for (const auto& channel : message["channels"]) {
    const std::string topic = channel["topic"];
    if (topic.ends_with("/image") || topic.ends_with("/raw") || topic.starts_with("/truth")) continue;
    subscriptions.push_back({{"id", channel["id"]}, {"channelId", channel["id"]}});
  }
  send_text(nlohmann::json{{"op", "subscribe"}, {"subscriptions", subscriptions}}.dump());
}

void LiveClient::run(const std::stop_token& stop) {
  while (!stop.stop_requested() && !connect_and_shake_hands()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  std::vector<std::uint8_t> received;
  std::vector<std::uint8_t> block(1U << 16U);
  while (!stop.stop_requested()) {
    pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, kPoll_ms) <= 0) continue;
    const ssize_t count = recv(socket_, block.data(), block.size(), 0);
    if (count <= 0) return;
    received.insert(received.end(), block.begin(), block.begin() + count);
    for (;;) {
      if (received.size() < 2) break;
      std::size_t head = 2;
      std::uint64_t length = received[1] & 127U;
      const std::size_t extra = length == 126 ? 2 : length == 127 ? 8 : 0;
      if (received.size() < head + extra) break;
      if (extra > 0) length = 0;
      for (std::size_t i = 0; i < extra; ++i) length = length << 8U | received[head + i];
      head += extra;
      if (received.size() < head + length) break;
      const auto begin = received.begin() + static_cast<std::ptrdiff_t>(head);
      const auto end = begin + static_cast<std::ptrdiff_t>(length);
      if (received[0] == kFinalText) take_text(std::string(begin, end));
      ++messages_;
      bytes_ += length;
      received.erase(received.begin(), end);
    }
  }
}

}  // namespace roseau::bench
