#include "display/server.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

#include "core/check.h"
#include "core/log.h"
#include "display/channels.h"
#include "display/http_api.h"
#include "display/hub.h"
#include "display/inbox.h"
#include "display/message_maker.h"
#include "display/request_guard.h"
#include "display/web_server.h"

namespace roseau::display {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kStateInterval{250};  // so that the page can call the daemon lost after a second and a half
constexpr milliseconds kReplayTimeInterval{50};
constexpr milliseconds kPlaybackStateInterval{1000};
constexpr milliseconds kWorkerWait{100};     // a stream without samples is told of within this
constexpr std::size_t kMostInTransit = 512;  // messages between the two threads before pictures are left out

std::string own_host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string();
}

/// Different for every start, so that a client that comes back knows whether it is still the same run.
std::string new_session_id() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::to_string(std::chrono::duration_cast<milliseconds>(now).count()) + "-" + std::to_string(::getpid());
}

std::string_view path_of(const HttpRequest& request) {
  return std::string_view(request.target).substr(0, request.target.find_first_of("?#"));
}

HttpResponse json_response(unsigned status, std::string body) {
  return {.status = status,
          .content_type = "application/json",
          .body = std::move(body),
          .headers = {{"Cache-Control", "no-store"}, {"X-Content-Type-Options", "nosniff"}}};
}

HttpResponse words(unsigned status, const std::string& text) { return {.status = status, .body = text + "\n"}; }

constexpr std::string_view kNoPage =
    "roseau is running, but its page was not found.\n\n"
    "Build it with ./dev build (needs nodejs and npm), or install roseau.\n"
    "Foxglove viewers can connect to this address all the same.\n";

}  // namespace

class DisplayServer::Impl final : public WebHandler {
 public:
  Impl(DisplayOptions options, const StreamTable& streams, DisplayCallbacks callbacks, PlayerControl* player)
      : options_(std::move(options)),
        streams_(streams),
        callbacks_(std::move(callbacks)),
        player_(player),
        session_id_(new_session_id()),
        own_name_(own_host_name()),
        inbox_(options_.inbox_capacity),
        hub_([this] { return server_info(); },
             {{"name", "roseau"}, {"version", options_.version}, {"session", options_.session_name}, {"mode", options_.mode}},
             options_.client_budget_bytes, demand_, playback()),
        web_(*this, WebServerLimits{}) {}

  ~Impl() override { stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<std::uint16_t> start() {
    auto port = web_.listen(options_.address, options_.port);
    if (!port) return port;
    auto files = StaticFiles::load(options_.web_root);
    if (files) {
      files_ = std::move(*files);
    } else {
      log("display")->warn("{}", files.error().message);
    }
    hub_.add_channels({state_channel()});
    web_.every(kStateInterval, [this] { send_state(); });
    if (player_ != nullptr) web_.every(kReplayTimeInterval, [this] { tell_playback(); });
    server_thread_ = std::thread([this] { web_.run(); });
    worker_thread_ = std::thread([this] { work(); });
    return port;
  }

  void stop() {
    stopping_ = true;
    inbox_.close();
    if (worker_thread_.joinable()) worker_thread_.join();
    if (!server_thread_.joinable()) return;
    web_.stop();
    server_thread_.join();
  }

  /// `sample`: a copy is made only when somebody wants it.
  template <class S>
  bool publish(S&& sample, HostTime log_time) {
    if (!somebody_wants(sample)) return true;
    return inbox_.push({std::forward<S>(sample), log_time, shown_jump_});
  }

  void restart() {
    ROSEAU_CHECK(player_ != nullptr);  // nothing else jumps
    shown_jump_ = player_->state().jumps_done;
    inbox_.clear();
  }

  std::size_t viewers() const { return viewers_; }

  std::map<std::string, std::uint64_t> dropped() const {
    std::map<std::string, std::uint64_t> by_topic;
    for (const auto& [stream, count] : inbox_.dropped()) by_topic[streams_.info(stream).topic] = count;
    return by_topic;
  }

 private:
  // --- any thread

  /// Small messages are always taken: the newest are kept for viewers to come.
  bool somebody_wants(const Sample& sample) const {
    const StreamId stream = sample.header.stream;
    switch (sample.kind()) {
      case SampleKind::frame:
        // A paused replay's last picture waits for viewers to come.
        return player_ != nullptr || demand_.wanted(channel_of(stream)) || demand_.wanted(preview_channel_of(stream));
      case SampleKind::image_motion:
      case SampleKind::raw_bytes:
        return demand_.wanted(channel_of(stream));
      default:
        return true;
    }
  }

  // --- the display's own thread

  void work() {
    MessageMaker maker(streams_, demand_, {options_.preview_width_px, options_.preview_quality, options_.preview_rate_hz});
    std::uint64_t jump = 0;
    while (!stopping_) {
      announce_new_streams();
      const std::optional<InboxItem> item = inbox_.pop(kWorkerWait);
      if (const std::uint64_t now = shown_jump_; now != jump) {
        maker.forget();
        jump = now;
      }
      if (item && item->jump == jump) show(*item, maker);
      for (MadeMessage& message : maker.make_waiting(std::chrono::steady_clock::now())) hand_over(std::move(message), jump);
    }
  }

  void show(const InboxItem& item, MessageMaker& maker) {
    announce_new_streams();
    newest_ns_ = to_ns(item.log_time);
    if (const auto* health = std::get_if<Health>(&item.sample.payload))
      web_.post([this, health = *health] { health_ = health; });
    if (in_transit_ > kMostInTransit && is_conflated(item.sample.kind())) {
      inbox_.count_drop(item.sample.header.stream);
      return;
    }
    for (MadeMessage& message : maker.make(item.sample, item.log_time, std::chrono::steady_clock::now())) {
      hand_over(std::move(message), item.jump);
    }
    if (const auto size = maker.take_new_picture_size()) web_.post([this, size] { note_picture_size(*size); });
  }

  void hand_over(MadeMessage message, std::uint64_t jump) {
    ++in_transit_;
    web_.post([this, message = std::move(message), jump] {
      --in_transit_;
      // From the moment that a viewer wants to see another place, nothing more is sent of the one before.
      if (player_ != nullptr) follow_jumps();
      if (jump == followed_jump_) hub_.deliver(message.channel, message.log_time, message.payload);
    });
  }

  void announce_new_streams() {
    std::vector<ChannelSetup> fresh;
    for (; announced_ < streams_.size(); ++announced_) {
      const auto id = static_cast<StreamId>(announced_);
      const StreamInfo& info = streams_.info(id);
      fresh.push_back(stream_channel(id, info));
      if (is_camera(info)) fresh.push_back(preview_channel(id, info));
    }
    if (!fresh.empty()) web_.post([this, fresh = std::move(fresh)]() mutable { hub_.add_channels(std::move(fresh)); });
  }

  // --- the server's thread

  HttpResponse on_request(const HttpRequest& request) override {
    if (!host_allowed(request.host, own_name_)) return words(403, "this address is not served under that name");
    if (request.method == "POST") return on_post(request);
    if (request.method != "GET" && request.method != "HEAD") return words(405, "only GET, HEAD and POST are served");
    const std::string_view path = path_of(request);
    if (path == "/api/state") return json_response(200, state_json(state()));
    if (path == "/api/recording") {
      if (!health_) return json_response(503, error_json("nothing is known yet: ask again in a second"));
      return json_response(200, recording_json(*health_));
    }
    if (path == "/api/streams") return json_response(200, streams_json(streams_));
    if (path == "/api/marks") return json_response(200, marks_json(options_.marks));
    if (path == "/api/history") return on_history(request);
    return on_file(request);
  }

  HttpResponse on_history(const HttpRequest& request) const {
    const auto channel = channel_in_query(request.target);
    auto history = channel ? hub_.history(*channel) : std::nullopt;
    if (!history) return json_response(404, error_json("there is no such channel"));
    return {
        .content_type = "application/octet-stream", .body = std::move(*history), .headers = {{"Cache-Control", "no-store"}}};
  }

  HttpResponse on_file(const HttpRequest& request) const {
    const StaticFile* file = files_.find(request.target);
    if (file == nullptr) {
      return path_of(request) == "/" ? words(200, std::string(kNoPage)) : words(404, "there is no such page here");
    }
    HttpResponse response{.content_type = file->content_type,
                          .headers = {{"ETag", file->etag},
                                      {"Cache-Control", "no-cache"},
                                      {"X-Content-Type-Options", "nosniff"},
                                      {"Referrer-Policy", "no-referrer"},
                                      {"Content-Security-Policy",
                                       "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' blob: data:; "
                                       "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"}}};
    if (request.if_none_match == file->etag) {
      response.status = 304;
    } else {
      response.body = file->content;
    }
    return response;
  }

  HttpResponse on_post(const HttpRequest& request) {
    if (!origin_may_act(request.origin, request.host)) {
      return json_response(403, error_json("actions are taken from this page and this machine only"));
    }
    if (!request.content_type.starts_with("application/json")) {
      return json_response(415, error_json("send JSON, with Content-Type application/json"));
    }
    if (path_of(request) == "/api/action") return on_action(request.body);
    if (path_of(request) == "/api/player") return on_player(request.body);
    return json_response(404, error_json("there is no such action"));
  }

  HttpResponse on_action(const std::string& body) {
    const auto action = parse_action(body);
    if (!action) return json_response(400, error_json(action.error().message));
    if (!callbacks_.on_action)
      return json_response(409, error_json("this run takes no actions: it has ended or only plays back"));
    if (const auto done = callbacks_.on_action(*action); !done) return json_response(409, error_json(done.error().message));
    return json_response(200, "{}");
  }

  HttpResponse on_player(const std::string& body) {
    const auto command = parse_player_command(body);
    if (!command) return json_response(400, error_json(command.error().message));
    if (player_ == nullptr) return json_response(409, error_json("nothing is being replayed: this is live"));
    apply(*command, *player_);
    tell_playback();
    return json_response(200, "{}");
  }

  std::variant<AcceptedUpgrade, HttpResponse> on_upgrade(const HttpRequest& request) override {
    if (!host_allowed(request.host, own_name_)) return words(403, "this address is not served under that name");
    if (!origin_may_watch(request.origin, request.host, options_.viewer_origins)) {
      return words(403, "viewers on other sites are not served; name the site in the configuration to allow it");
    }
    auto subprotocol = choose_subprotocol(request.subprotocols);
    if (!subprotocol) return words(400, "offer the WebSocket subprotocol foxglove.sdk.v1 or foxglove.websocket.v1");
    auto client = hub_.make_client(*subprotocol);
    return AcceptedUpgrade{std::move(*subprotocol), std::move(client)};
  }

  ServerInfo server_info() const {
    ServerInfo info{.name = "roseau",
                    .session_id = session_id_,
                    .metadata = {{"version", options_.version},
                                 {"session", options_.session_name},
                                 {"mode", options_.mode},
                                 {"civil_from_host_ns", std::to_string(options_.civil_from_host.count())}}};
    if (player_ != nullptr) {
      const PlayerState state = player_->state();
      info.data_range = {state.begin, state.end};
    }
    return info;
  }

  Playback playback() {
    if (player_ == nullptr) return {};
    return {.state = [this] { return playback_state(player_->state()); },
            .control = [this](const PlaybackControl& control) { return carry_out(control); }};
  }

  static PlaybackState playback_state(const PlayerState& player) {
    const auto status = player.ended     ? PlaybackStatus::ended
                        : player.playing ? PlaybackStatus::playing
                                         : PlaybackStatus::paused;
    return {.status = status, .time = player.position, .speed = static_cast<float>(std::min(player.speed, kFastestSpeed))};
  }

  PlaybackState carry_out(const PlaybackControl& control) {
    // The place first: a viewer that loops asks for the begin and for playing in one request.
    if (control.seek) player_->seek(*control.seek);
    player_->set_speed(control.speed);
    if (control.play) {
      player_->play();
    } else {
      player_->pause();
    }
    const PlayerState player = player_->state();
    PlaybackState told = playback_state(player);
    told.did_seek = player.jumps != followed_jump_;
    note_jump(player);
    told_ = told;
    told_at_ = std::chrono::steady_clock::now();
    return told;
  }

  /// Whatever tells of the place before is forgotten; pages learn of it before they get anything of the new place.
  void note_jump(const PlayerState& player) {
    if (player.jumps == followed_jump_) return;
    followed_jump_ = player.jumps;
    hub_.forget();
    send_state();
  }

  void follow_jumps() {
    const PlayerState player = player_->state();
    if (player.jumps == followed_jump_) return;
    note_jump(player);
    tell(player, /*did_seek=*/true);
  }

  void tell(const PlayerState& player, bool did_seek) {
    told_ = playback_state(player);
    told_.did_seek = did_seek;
    told_at_ = std::chrono::steady_clock::now();
    hub_.send_playback_state(told_);
  }

  /// Time many times a second; the player's state when it changes, and now and then for who missed it.
  void tell_playback() {
    follow_jumps();
    const PlayerState player = player_->state();
    const PlaybackState now = playback_state(player);
    const bool is_old = std::chrono::steady_clock::now() - told_at_ >= kPlaybackStateInterval;
    if (is_old || now.status != told_.status || now.speed != told_.speed) tell(player, /*did_seek=*/false);
    hub_.send_time(player.position);
  }

  DisplayState state() const {
    std::uint64_t messages_dropped = 0;
    for (const auto& [stream, count] : inbox_.dropped()) {
      const auto kind = sample_kind_from_string(streams_.info(stream).kind);
      if (kind && !is_conflated(*kind)) messages_dropped += count;
    }
    return {.newest = host_time_from_ns(newest_ns_),
            .viewers = hub_.counters(),
            .messages_dropped = messages_dropped,
            .pictures = picture_sizes_,
            .player = player_ != nullptr ? std::optional(player_->state()) : std::nullopt};
  }

  void send_state() {
    viewers_ = hub_.counters().clients;
    const std::string text = state_json(state());
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    hub_.deliver(kStateChannel, host_time_from_ns(newest_ns_),
                 std::make_shared<const std::vector<std::byte>>(bytes, bytes + text.size()));
  }

  void note_picture_size(const PictureSize& size) {
    std::erase_if(picture_sizes_, [&](const PictureSize& known) { return known.topic == size.topic; });
    picture_sizes_.push_back(size);
  }

  const DisplayOptions options_;
  const StreamTable& streams_;
  const DisplayCallbacks callbacks_;
  PlayerControl* const player_;
  const std::string session_id_;
  const std::string own_name_;

  Demand demand_;
  Inbox inbox_;
  std::atomic<std::int64_t> newest_ns_{0};
  std::atomic<std::size_t> in_transit_{0};
  std::atomic<std::size_t> viewers_{0};
  std::atomic<std::uint64_t> shown_jump_{0};  // of the player's: what is published comes after this one
  std::atomic<bool> stopping_{false};
  std::size_t announced_ = 0;  // the display's own thread

  // The server's thread.
  std::optional<Health> health_;  // the newest
  StaticFiles files_;
  std::vector<PictureSize> picture_sizes_;
  std::uint64_t followed_jump_ = 0;  // of the player's: viewers know of it
  PlaybackState told_;
  std::chrono::steady_clock::time_point told_at_;
  Hub hub_;
  WebServer web_;  // last: its connections use everything above

  std::thread server_thread_;
  std::thread worker_thread_;
};

DisplayServer::DisplayServer(DisplayOptions options, const StreamTable& streams, DisplayCallbacks callbacks,
                             PlayerControl* player)
    : impl_(std::make_unique<Impl>(std::move(options), streams, std::move(callbacks), player)) {}

DisplayServer::~DisplayServer() = default;

Result<std::uint16_t> DisplayServer::start() { return impl_->start(); }

void DisplayServer::stop() { impl_->stop(); }

bool DisplayServer::publish(const Sample& sample, HostTime log_time) { return impl_->publish(sample, log_time); }

void DisplayServer::restart() { impl_->restart(); }

std::size_t DisplayServer::viewers() const { return impl_->viewers(); }

bool DisplayServer::receive(Sample sample) {
  const HostTime arrival = sample.header.arrival_time;
  return impl_->publish(std::move(sample), arrival);
}

std::map<std::string, std::uint64_t> DisplayServer::dropped() const { return impl_->dropped(); }

}  // namespace roseau::display
