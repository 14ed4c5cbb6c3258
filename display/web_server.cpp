// Boost.Asio 1.74 uses std::exchange without including it.
#include <utility>

// The thread sanitizer cannot follow fences; the mutex of Asio's scheduler orders the same memory.
#ifdef __SANITIZE_THREAD__
#define BOOST_ASIO_DISABLE_FENCED_BLOCK
#endif

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <set>

#include "core/log.h"
#include "display/web_server.h"

namespace roseau::display {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr const char* kServerName = "roseau";
constexpr seconds kHttpTimeout{15};
constexpr seconds kClosingTime{1};
constexpr std::uint32_t kHeaderLimit_bytes = 16 * 1024;

std::string text_of(beast::string_view view) { return {view.data(), view.size()}; }

/// Keeps what waits in the kernel small, so that a picture chosen now is not behind a second of older ones.
void tune(tcp::socket& socket) {
  beast::error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  const int not_sent_bytes = 32 * 1024;
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &not_sent_bytes, sizeof not_sent_bytes);
}

HttpRequest plain(const http::request<http::string_body>& request) {
  return {.method = text_of(request.method_string()),
          .target = text_of(request.target()),
          .host = text_of(request[http::field::host]),
          .origin = text_of(request[http::field::origin]),
          .content_type = text_of(request[http::field::content_type]),
          .if_none_match = text_of(request[http::field::if_none_match]),
          .subprotocols = text_of(request[http::field::sec_websocket_protocol]),
          .body = request.body()};
}

http::response<http::string_body> beast_response(HttpResponse response, unsigned version, bool keep_alive) {
  http::response<http::string_body> out{static_cast<http::status>(response.status), version};
  out.set(http::field::server, kServerName);
  out.set(http::field::content_type, response.content_type);
  for (const auto& [name, value] : response.headers) out.set(name, value);
  out.keep_alive(keep_alive);
  out.body() = std::move(response.body);
  out.prepare_payload();
  return out;
}

/// A connection the server can end.
class Connection {
 public:
  virtual ~Connection() = default;
  virtual void go_away() = 0;
};

/// Every open connection, so that they can be counted and ended.
using Connections = std::set<Connection*>;

class Registered {
 public:
  Registered(Connections& all, Connection* self) : all_(all), self_(self) { all_.insert(self_); }
  ~Registered() { all_.erase(self_); }
  Registered(const Registered&) = delete;
  Registered& operator=(const Registered&) = delete;

 private:
  Connections& all_;
  Connection* self_;
};

// ---------------------------------------------------------------------------------------------------------------------

class WebSocketConnection final : public Connection,
                                  public WebSocketLink,
                                  public std::enable_shared_from_this<WebSocketConnection> {
 public:
  WebSocketConnection(beast::tcp_stream&& stream, Connections& all, AcceptedUpgrade accepted, const WebServerLimits& limits)
      : socket_(std::move(stream)),
        registered_(all, this),
        closing_timer_(socket_.get_executor()),
        subprotocol_(std::move(accepted.subprotocol)),
        client_(std::move(accepted.client)) {
    socket_.set_option(websocket::stream_base::timeout{kHttpTimeout, limits.idle_timeout, /*keep_alive_pings=*/true});
    socket_.set_option(websocket::stream_base::decorator([this](websocket::response_type& response) {
      response.set(http::field::server, kServerName);
      response.set(http::field::sec_websocket_protocol, subprotocol_);
    }));
    socket_.read_message_max(limits.websocket_message_bytes);
    // One frame a message: no copy into a fragment buffer.
    socket_.auto_fragment(false);
  }

  void start(const http::request<http::string_body>& request) {
    beast::get_lowest_layer(socket_).expires_never();
    socket_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
      if (error) return;
      self->open_ = true;
      self->client_->on_open(*self);
      self->read();
      self->wake();
    });
  }

  void wake() override {
    if (!open_ || writing_ || closing_) return;
    std::optional<OutMessage> message = client_->next_message();
    if (!message) return;
    writing_ = true;
    current_ = std::move(*message);
    socket_.text(current_.is_text);
    const std::array<asio::const_buffer, 2> buffers = {
        asio::buffer(current_.head), current_.payload ? asio::buffer(*current_.payload) : asio::const_buffer()};
    socket_.async_write(buffers, [self = shared_from_this()](beast::error_code error, std::size_t) {
      self->writing_ = false;
      self->current_ = {};
      if (error) {
        self->cut();
      } else if (self->closing_) {
        self->send_close();
      } else {
        self->wake();
      }
    });
  }

  void close(std::string_view reason) override { begin_close(websocket::close_code::policy_error, reason); }
  void go_away() override { begin_close(websocket::close_code::going_away, "the server is closing"); }

 private:
  void read() {
    socket_.async_read(incoming_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) {
        self->cut();
        return;
      }
      self->handle_incoming();
      self->read();
    });
  }

  void handle_incoming() {
    const auto data = incoming_.data();
    const std::string_view bytes(static_cast<const char*>(data.data()), data.size());
    // Once we are leaving, what the client still says goes unanswered.
    if (!closing_) {
      if (socket_.got_text()) {
        client_->on_text(bytes);
      } else {
        client_->on_binary(bytes);
      }
    }
    incoming_.consume(incoming_.size());
  }

  void begin_close(websocket::close_code code, std::string_view reason) {
    if (closing_) return;
    closing_ = true;
    constexpr std::size_t kLongestReason = 120;
    close_reason_ = websocket::close_reason(code, std::string(reason.substr(0, kLongestReason)));
    // A client that no longer reads would keep the closing handshake waiting.
    closing_timer_.expires_after(kClosingTime);
    closing_timer_.async_wait([weak = weak_from_this()](beast::error_code error) {
      if (const auto self = weak.lock(); self && !error) self->cut();
    });
    if (!open_) {
      cut();
    } else if (!writing_) {
      send_close();
    }
  }

  void send_close() {
    socket_.async_close(close_reason_, [self = shared_from_this()](beast::error_code) { self->cut(); });
  }

  void cut() {
    open_ = false;
    closing_ = true;
    closing_timer_.cancel();
    beast::get_lowest_layer(socket_).close();
  }

  websocket::stream<beast::tcp_stream> socket_;
  Registered registered_;
  asio::steady_timer closing_timer_;
  std::string subprotocol_;
  std::unique_ptr<WebSocketClient> client_;
  beast::flat_buffer incoming_;
  OutMessage current_;  // on its way
  websocket::close_reason close_reason_;
  bool open_ = false;
  bool writing_ = false;
  bool closing_ = false;
};

// ---------------------------------------------------------------------------------------------------------------------

class HttpConnection final : public Connection, public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(tcp::socket&& socket, Connections& all, WebHandler& handler, const WebServerLimits& limits)
      : stream_(std::move(socket)), all_(all), registered_(all, this), handler_(handler), limits_(limits) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(kHeaderLimit_bytes);
    parser_->body_limit(limits_.http_body_bytes);
    stream_.expires_after(kHttpTimeout);
    http::async_read(stream_, incoming_, *parser_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (!error) {
        self->answer();
      } else if (error == http::error::body_limit) {
        self->send({.status = 413, .body = "the request is too large\n"}, 11, /*keep_alive=*/false);
      } else if (error == http::error::header_limit) {
        self->send({.status = 431, .body = "the request's header is too large\n"}, 11, /*keep_alive=*/false);
      } else if (error.category() == http::make_error_code(http::error::bad_method).category() &&
                 error != http::error::end_of_stream && error != http::error::partial_message) {
        self->send({.status = 400, .body = "this is not HTTP\n"}, 11, /*keep_alive=*/false);
      } else {
        self->go_away();
      }
    });
  }

  void go_away() override { stream_.close(); }

 private:
  void answer() {
    const auto& request = parser_->get();
    if (websocket::is_upgrade(request)) {
      auto decision = handler_.on_upgrade(plain(request));
      if (auto* accepted = std::get_if<AcceptedUpgrade>(&decision)) {
        std::make_shared<WebSocketConnection>(std::move(stream_), all_, std::move(*accepted), limits_)->start(request);
      } else {
        send(std::move(std::get<HttpResponse>(decision)), request.version(), /*keep_alive=*/false);
      }
      return;
    }
    send(handler_.on_request(plain(request)), request.version(), request.keep_alive());
  }

  void send(HttpResponse response, unsigned version, bool keep_alive) {
    const bool head_only = parser_->get().method() == http::verb::head;
    response_ = beast_response(std::move(response), version, keep_alive);
    // The length stays that of the body a GET would have brought.
    if (head_only) response_.body().clear();
    http::async_write(stream_, response_, [self = shared_from_this(), keep_alive](beast::error_code error, std::size_t) {
      if (error || !keep_alive) {
        self->finish();
      } else {
        self->read();
      }
    });
  }

  void finish() {
    beast::error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    // Reading to the client's end lets the answer arrive before the connection is reset.
    stream_.expires_after(kClosingTime);
    stream_.async_read_some(rest_.prepare(4096),
                            [self = shared_from_this()](beast::error_code, std::size_t) { self->go_away(); });
  }

  beast::tcp_stream stream_;
  Connections& all_;
  Registered registered_;
  WebHandler& handler_;
  const WebServerLimits& limits_;
  beast::flat_buffer incoming_;
  beast::flat_buffer rest_;
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::string_body> response_;
};

}  // namespace

// ---------------------------------------------------------------------------------------------------------------------

class WebServer::Impl {
 public:
  Impl(WebHandler& handler, WebServerLimits limits) : handler_(handler), limits_(limits) {}

  Result<std::uint16_t> listen(const std::string& address, std::uint16_t port) {
    beast::error_code error;
    const auto parsed = asio::ip::make_address(address, error);
    if (error) {
      return Error{ErrorCode::invalid_argument,
                   "\"" + address + "\" is no IP address: use 127.0.0.1 for this machine only, 0.0.0.0 for the network"};
    }
    const tcp::endpoint endpoint(parsed, port);
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    // Set on the listening socket: accepted ones inherit it before their window is negotiated.
    if (!error) acceptor_.set_option(asio::socket_base::send_buffer_size(limits_.send_buffer_bytes), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (!error) return acceptor_.local_endpoint().port();
    beast::error_code ignored;
    acceptor_.close(ignored);
    return failure(error, address, port);
  }

  void run() {
    accept();
    for (;;) {
      try {
        context_.run();
        return;
      } catch (const std::exception& exception) {
        // One connection's trouble must not end the others.
        log("display")->error("a connection failed: {}", exception.what());
      }
    }
  }

  void post(std::function<void()> work) { asio::post(context_, std::move(work)); }

  void every(milliseconds interval, std::function<void()> work) {
    timers_.push_back(std::make_unique<Timer>(context_, interval, std::move(work)));
    schedule(*timers_.back());
  }

  void stop() {
    asio::post(context_, [this] {
      if (stopping_) return;
      stopping_ = true;
      beast::error_code ignored;
      acceptor_.close(ignored);
      for (const auto& timer : timers_) timer->timer.cancel();
      const Connections open = connections_;
      for (Connection* connection : open) connection->go_away();
      wait_for_connections(kClosingTime / milliseconds(kLookInterval) + 2);
    });
  }

 private:
  struct Timer {
    Timer(asio::io_context& context, milliseconds every, std::function<void()> what)
        : timer(context), interval(every), work(std::move(what)) {}
    asio::steady_timer timer;
    milliseconds interval;
    std::function<void()> work;
  };

  static constexpr milliseconds kLookInterval{10};

  static Error failure(const beast::error_code& error, const std::string& address, std::uint16_t port) {
    const std::string place = address + ":" + std::to_string(port);
    if (error == asio::error::address_in_use) {
      return {ErrorCode::busy, "port " + std::to_string(port) +
                                   " is in use: another roseau may be running (close it), or choose another port with --port"};
    }
    if (error == asio::error::access_denied) {
      return {ErrorCode::permission, "not allowed to listen on " + place + ": choose a port above 1023 with --port"};
    }
    return {ErrorCode::io, "cannot listen on " + place + ": " + error.message()};
  }

  void accept() {
    acceptor_.async_accept([this](beast::error_code error, tcp::socket socket) {
      if (stopping_ || error == asio::error::operation_aborted) return;
      if (error) {
        // Out of descriptors, most likely: try again when some may have been freed.
        retry_.expires_after(milliseconds(100));
        retry_.async_wait([this](beast::error_code cancelled) {
          if (!cancelled && !stopping_) accept();
        });
        return;
      }
      if (connections_.size() < limits_.connections) {
        tune(socket);
        std::make_shared<HttpConnection>(std::move(socket), connections_, handler_, limits_)->read();
      }
      accept();
    });
  }

  void schedule(Timer& timer) {
    timer.timer.expires_after(timer.interval);
    timer.timer.async_wait([this, &timer](beast::error_code error) {
      if (error || stopping_) return;
      timer.work();
      schedule(timer);
    });
  }

  /// Lets closing handshakes finish; what is still open after `looks` looks is left behind.
  void wait_for_connections(std::int64_t looks) {
    if (connections_.empty() || looks <= 0) {
      context_.stop();
      return;
    }
    retry_.expires_after(kLookInterval);
    retry_.async_wait([this, looks](beast::error_code) { wait_for_connections(looks - 1); });
  }

  WebHandler& handler_;
  WebServerLimits limits_;
  Connections connections_;  // before the context, whose destructor destroys the last connections
  asio::io_context context_{1};
  tcp::acceptor acceptor_{context_};
  asio::steady_timer retry_{context_};
  std::vector<std::unique_ptr<Timer>> timers_;
  bool stopping_ = false;
};

WebServer::WebServer(WebHandler& handler, WebServerLimits limits) : impl_(std::make_unique<Impl>(handler, limits)) {}
WebServer::~WebServer() = default;
Result<std::uint16_t> WebServer::listen(const std::string& address, std::uint16_t port) { return impl_->listen(address, port); }
void WebServer::run() { impl_->run(); }
void WebServer::post(std::function<void()> work) { impl_->post(std::move(work)); }
void WebServer::every(milliseconds interval, std::function<void()> work) { impl_->every(interval, std::move(work)); }
void WebServer::stop() { impl_->stop(); }

}  // namespace roseau::display
