// WebServer: HTTP and WebSocket on one port, one thread. What is served is decided elsewhere: this is the only place that
// knows Boost.Beast (its .cpp takes the better part of a minute to compile, so it says nothing about roseau).
//
// Thread rule: run() is the server's thread; every callback is called in it. post() and stop() are thread-safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/result.h"
#include "display/outbox.h"

namespace roseau::display {

struct HttpRequest {
  std::string method;  // "GET"
  std::string target;  // "/api/state?x=1", as sent
  std::string host;
  std::string origin;  // empty: not from a browser's page
  std::string content_type;
  std::string if_none_match;
  std::string subprotocols;  // Sec-WebSocket-Protocol, as sent
  std::string body;
};

struct HttpResponse {
  unsigned status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;
};

/// The server's end of one WebSocket connection.
class WebSocketLink {
 public:
  virtual ~WebSocketLink() = default;
  /// There is something to send: the link asks its client for messages, one at a time, until there is none.
  virtual void wake() = 0;
  /// Ends the connection with the protocol's "policy" code and this reason (at most 120 bytes); at the latest 1 s later.
  virtual void close(std::string_view reason) = 0;
};

/// What one WebSocket connection does. Lives as long as the connection.
class WebSocketClient {
 public:
  virtual ~WebSocketClient() = default;
  virtual void on_open(WebSocketLink& link) = 0;
  virtual void on_text(std::string_view text) = 0;
  virtual void on_binary(std::string_view bytes) = 0;
  /// The next message; asked only when the one before has gone.
  virtual std::optional<OutMessage> next_message() = 0;
};

/// A connection taken: the subprotocol to echo, and what to do with it.
struct AcceptedUpgrade {
  std::string subprotocol;
  std::unique_ptr<WebSocketClient> client;
};

class WebHandler {
 public:
  virtual ~WebHandler() = default;
  virtual HttpResponse on_request(const HttpRequest& request) = 0;
  virtual std::variant<AcceptedUpgrade, HttpResponse> on_upgrade(const HttpRequest& request) = 0;
};

struct WebServerLimits {
  std::size_t connections = 64;
  std::size_t http_body_bytes = 64 * 1024;
  std::size_t websocket_message_bytes = 256 * 1024;  // from the client
  // How much the kernel may hold for one connection. Small, so that what we decide to send now is what arrives next.
  int send_buffer_bytes = 128 * 1024;
  std::chrono::seconds idle_timeout{20};  // a WebSocket that answers no ping for so long is gone
};

class WebServer {
 public:
  /// `handler` outlives the server.
  WebServer(WebHandler& handler, WebServerLimits limits);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Binds `address` (an IP address) and `port` (0: any free one); returns the port. `busy` when it is taken.
  Result<std::uint16_t> listen(const std::string& address, std::uint16_t port);

  /// Serves until stop(). Call once, after listen.
  void run();

  /// Runs `work` in the server's thread. Dropped when the server has stopped.
  void post(std::function<void()> work);

  /// Calls `work` in the server's thread every `interval`; set up before run().
  void every(std::chrono::milliseconds interval, std::function<void()> work);

  /// Closes every connection (WebSockets with "going away") and lets run() return, within about a second.
  void stop();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace roseau::display
