#include "display/hub.h"

#include <algorithm>
#include <utility>

#include "display/client_session.h"

namespace roseau::display {

namespace {
void append_u32(std::string& out, std::size_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>((value >> shift) & 0xff));
}
}  // namespace

Hub::Hub(std::function<ServerInfo()> server_info, Parameters parameters, std::size_t client_budget_bytes, Demand& demand,
         Playback playback)
    : server_info_(std::move(server_info)),
      parameters_(std::move(parameters)),
      client_budget_bytes_(client_budget_bytes),
      demand_(demand),
      playback_(std::move(playback)) {}

Hub::~Hub() = default;

void Hub::add_channels(std::vector<ChannelSetup> channels) {
  std::vector<Channel> fresh;
  for (ChannelSetup& setup : channels) {
    const ChannelId id = setup.channel.id;
    fresh.push_back(setup.channel);
    channels_.try_emplace(id).first->second.setup = std::move(setup);
  }
  if (fresh.empty()) return;
  const std::string text = advertise_message(fresh);
  // A copy: a client that is too slow for this may leave the set.
  const std::set<ClientSession*> clients = clients_;
  for (ClientSession* client : clients) client->send_text(text);
}

void Hub::deliver(ChannelId channel, HostTime log_time, const SharedBytes& payload) {
  ChannelState* state = find(channel);
  if (state == nullptr) return;
  keep(*state, log_time, payload);
  if (state->subscribers == 0) return;
  const std::set<ClientSession*> clients = clients_;
  for (ClientSession* client : clients) client->deliver(channel, state->setup.conflated, log_time, payload);
}

void Hub::send_time(HostTime time) {
  const std::string bytes = time_message(time);
  const std::set<ClientSession*> clients = clients_;
  for (ClientSession* client : clients) client->send_binary(bytes);
}

void Hub::send_playback_state(PlaybackState state, ClientSession* requester, const std::string& request_id) {
  const std::set<ClientSession*> clients = clients_;
  for (ClientSession* client : clients) {
    state.request_id = client == requester ? request_id : std::string();
    client->send_playback_state(state);
  }
}

void Hub::forget() {
  for (auto& [id, state] : channels_) {
    if (id != kStateChannel) state.kept.clear();
  }
  for (ClientSession* client : clients_) client->forget();
}

std::unique_ptr<WebSocketClient> Hub::make_client(std::string_view subprotocol) {
  return std::make_unique<ClientSession>(*this, subprotocol == kSdkSubprotocol);
}

std::optional<std::string> Hub::history(ChannelId channel) const {
  const auto found = channels_.find(channel);
  if (found == channels_.end()) return std::nullopt;
  std::string out;
  for (const Kept& kept : found->second.kept) {
    const std::string head = message_data_header(0, kept.log_time);
    append_u32(out, head.size() + kept.payload->size());
    out += head;
    out.append(reinterpret_cast<const char*>(kept.payload->data()), kept.payload->size());
  }
  return out;
}

HubCounters Hub::counters() const {
  HubCounters counters{.clients = clients_.size(), .images_dropped = images_dropped_, .slow_clients = slow_clients_};
  for (const ClientSession* client : clients_) counters.images_dropped += client->dropped_images();
  return counters;
}

void Hub::keep(ChannelState& state, HostTime log_time, const SharedBytes& payload) {
  const Retention& retention = state.setup.retention;
  if (retention.on_subscribe == 0 && retention.for_history.count() == 0) return;
  state.kept.push_back({log_time, payload});
  while (state.kept.size() > retention.on_subscribe && state.kept.front().log_time + retention.for_history <= log_time) {
    state.kept.pop_front();
  }
}

Hub::ChannelState* Hub::find(ChannelId channel) {
  const auto found = channels_.find(channel);
  return found == channels_.end() ? nullptr : &found->second;
}

void Hub::count_subscriber(ChannelId channel, int change) {
  ChannelState* state = find(channel);
  if (state == nullptr) return;
  state->subscribers += static_cast<std::size_t>(change);  // modulo 2^n: -1 counts down
  demand_.set(channel, state->subscribers > 0);
}

std::vector<Channel> Hub::advertised() const {
  std::vector<Channel> list;
  list.reserve(channels_.size());
  for (const auto& [id, state] : channels_) list.push_back(state.setup.channel);
  return list;
}

}  // namespace roseau::display
