// Hub: who watches what. Gives every message to the clients subscribed to its channel, and keeps what a later client needs.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "display/channels.h"
#include "display/foxglove_protocol.h"
#include "display/outbox.h"
#include "display/web_server.h"

namespace roseau::display {

struct HubCounters {
  std::size_t clients = 0;
  std::uint64_t images_dropped = 0;  // replaced by a newer one before they were sent
  std::uint64_t slow_clients = 0;    // let go because small messages piled up
};

class ClientSession;

/// How clients see and drive a replay; both empty when nothing is replayed.
struct Playback {
  std::function<PlaybackState()> state;
  /// Carries the request out and tells what came of it.
  std::function<PlaybackState(const PlaybackControl&)> control;
};

/// Not thread-safe: lives on the server's thread. Outlives its clients.
class Hub {
 public:
  /// `server_info` is asked for at every connection. `client_budget_bytes`: small messages that may wait for one client.
  Hub(std::function<ServerInfo()> server_info, Parameters parameters, std::size_t client_budget_bytes, Demand& demand,
      Playback playback = {});
  ~Hub();
  Hub(const Hub&) = delete;
  Hub& operator=(const Hub&) = delete;

  void add_channels(std::vector<ChannelSetup> channels);
  void deliver(ChannelId channel, HostTime log_time, const SharedBytes& payload);
  void send_time(HostTime time);
  /// To every client that knows of playback. `requester`, when given, gets it as the answer to its request.
  void send_playback_state(PlaybackState state, ClientSession* requester = nullptr, const std::string& request_id = {});
  /// The replay has jumped: what is kept and what waits to be sent tells of another time. The display's own state stays.
  void forget();

  /// Clients of the older name of the protocol may not know the playback messages: these get them only once they asked.
  std::unique_ptr<WebSocketClient> make_client(std::string_view subprotocol = kSdkSubprotocol);

  /// What is kept of a channel, oldest first: of each message its length (u32, little-endian), then the bytes a subscriber
  /// with id 0 would have got. Nothing when there is no such channel.
  std::optional<std::string> history(ChannelId channel) const;

  HubCounters counters() const;

 private:
  friend class ClientSession;

  struct Kept {
    HostTime log_time;
    SharedBytes payload;
  };
  struct ChannelState {
    ChannelSetup setup;
    std::deque<Kept> kept;
    std::size_t subscribers = 0;
  };

  void keep(ChannelState& state, HostTime log_time, const SharedBytes& payload);
  ChannelState* find(ChannelId channel);
  void count_subscriber(ChannelId channel, int change);
  std::vector<Channel> advertised() const;

  const std::function<ServerInfo()> server_info_;
  const Parameters parameters_;
  const std::size_t client_budget_bytes_;
  Demand& demand_;
  const Playback playback_;
  std::map<ChannelId, ChannelState> channels_;
  std::set<ClientSession*> clients_;
  std::uint64_t images_dropped_ = 0;  // of clients that have gone
  std::uint64_t slow_clients_ = 0;
};

}  // namespace roseau::display
