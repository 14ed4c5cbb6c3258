// A viewer like the page, as small as can be: one WebSocket connection that subscribes to everything the page does and
// throws it away. Loopback only.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "core/result.h"

namespace roseau::bench {

class LiveClient {
 public:
  explicit LiveClient(std::uint16_t port);
  ~LiveClient();
  LiveClient(const LiveClient&) = delete;
  LiveClient& operator=(const LiveClient&) = delete;

  std::uint64_t messages() const { return messages_; }
  std::uint64_t bytes() const { return bytes_; }

 private:
  void run(const std::stop_token& stop);
  bool connect_and_shake_hands();
  void take_text(const std::string& text);
  void send_text(const std::string& text) const;

  const std::uint16_t port_;
  int socket_ = -1;
  std::atomic<std::uint64_t> messages_{0};
  std::atomic<std::uint64_t> bytes_{0};
  std::jthread thread_;
};

}  // namespace roseau::bench
