#include "display/client_session.h"

#include <algorithm>
#include <utility>

#include "core/log.h"

namespace roseau::display {

ClientSession::ClientSession(Hub& hub, bool is_told_of_playback)
    : hub_(hub), is_told_of_playback_(is_told_of_playback), outbox_(hub.client_budget_bytes_) {}

ClientSession::~ClientSession() {
  for (const auto& [subscription, channel] : subscriptions_) hub_.count_subscriber(channel, -1);
  hub_.images_dropped_ += outbox_.dropped_images();
  hub_.clients_.erase(this);
}

void ClientSession::on_open(WebSocketLink& link) {
  link_ = &link;
  hub_.clients_.insert(this);
  send_text(server_info_message(hub_.server_info_()));
  send_text(advertise_message(hub_.advertised()));
  if (hub_.playback_.state) send_playback_state(hub_.playback_.state());
}

void ClientSession::on_text(std::string_view text) {
  const Result<ClientMessage> message = parse_client_text(text);
  if (!message) {
    send_text(status_message(StatusLevel::error, message.error().message));
    return;
  }
  std::visit([this](const auto& known) { handle(known); }, *message);
}

void ClientSession::on_binary(std::string_view bytes) {
  const auto control = parse_client_binary(bytes);
  if (!control) {
    const bool is_wrong = control.error().code == ErrorCode::invalid_argument;
    send_text(status_message(is_wrong ? StatusLevel::error : StatusLevel::warning, control.error().message));
    return;
  }
  if (!hub_.playback_.control) {
    send_text(status_message(StatusLevel::warning, "nothing is being replayed: this is live"));
    return;
  }
  is_told_of_playback_ = true;
  hub_.send_playback_state(hub_.playback_.control(*control), this, control->request_id);
}

void ClientSession::send_playback_state(const PlaybackState& state) {
  if (is_told_of_playback_) send_binary(playback_state_message(state));
}

void ClientSession::handle(const Subscribe& message) {
  for (const auto& [subscription, channel] : message.subscriptions) subscribe(subscription, channel);
}

void ClientSession::subscribe(SubscriptionId subscription, ChannelId channel) {
  const Hub::ChannelState* state = hub_.find(channel);
  if (state == nullptr) {
    send_text(status_message(StatusLevel::warning, "there is no channel " + std::to_string(channel)));
    return;
  }
  if (!subscriptions_.try_emplace(subscription, channel).second) {
    send_text(status_message(StatusLevel::warning, "subscription " + std::to_string(subscription) + " exists already"));
    return;
  }
  by_channel_.emplace(channel, subscription);
  hub_.count_subscriber(channel, +1);
  const std::size_t shown = std::min(state->setup.retention.on_subscribe, state->kept.size());
  for (std::size_t i = state->kept.size() - shown; i < state->kept.size(); ++i) {
    const Hub::Kept& kept = state->kept[i];
    push({.is_text = false, .head = message_data_header(subscription, kept.log_time), .payload = kept.payload});
  }
}

void ClientSession::handle(const Unsubscribe& message) {
  for (const SubscriptionId subscription : message.subscriptions) {
    const auto found = subscriptions_.find(subscription);
    if (found == subscriptions_.end()) {
      send_text(status_message(StatusLevel::warning, "there is no subscription " + std::to_string(subscription)));
      continue;
    }
    const auto [begin, end] = by_channel_.equal_range(found->second);
    by_channel_.erase(std::find_if(begin, end, [&](const auto& entry) { return entry.second == subscription; }));
    outbox_.remove_slot(subscription);
    hub_.count_subscriber(found->second, -1);
    subscriptions_.erase(found);
  }
}

void ClientSession::handle(const GetParameters& message) {
  Parameters asked;
  for (const auto& parameter : hub_.parameters_) {
    if (message.names.empty() || std::ranges::find(message.names, parameter.first) != message.names.end()) {
      asked.push_back(parameter);
    }
  }
  send_text(parameter_values_message(asked, message.request_id));
}

void ClientSession::handle(const NotOffered& message) { send_text(status_message(StatusLevel::warning, message.what)); }

void ClientSession::send_text(std::string text) { push({.is_text = true, .head = std::move(text), .payload = nullptr}); }

void ClientSession::send_binary(std::string bytes) { push({.is_text = false, .head = std::move(bytes), .payload = nullptr}); }

void ClientSession::deliver(ChannelId channel, bool conflated, HostTime log_time, const SharedBytes& payload) {
  const auto [begin, end] = by_channel_.equal_range(channel);
  for (auto entry = begin; entry != end; ++entry) {
    OutMessage message{.is_text = false, .head = message_data_header(entry->second, log_time), .payload = payload};
    if (!conflated) {
      push(std::move(message));
    } else if (!too_slow_) {
      outbox_.put_latest(entry->second, std::move(message));
      link_->wake();
    }
  }
}

void ClientSession::push(OutMessage message) {
  if (too_slow_) return;
  if (outbox_.push(std::move(message))) {
    link_->wake();
    return;
  }
  too_slow_ = true;
  ++hub_.slow_clients_;
  log("display")->warn("a viewer reads too slowly: {} bytes of messages waited for it; closing its connection",
                       outbox_.waiting_bytes());
  link_->close("too slow: messages piled up; connect again, or subscribe to less");
}

}  // namespace roseau::display
