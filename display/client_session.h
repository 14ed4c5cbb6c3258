// ClientSession: one client of the live protocol: its subscriptions and what waits to be sent to it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "display/hub.h"

namespace roseau::display {

/// Not thread-safe: lives on the server's thread.
class ClientSession final : public WebSocketClient {
 public:
  /// `is_told_of_playback`: without having asked, that is, its version of the protocol knows these messages.
  ClientSession(Hub& hub, bool is_told_of_playback);
  ~ClientSession() override;
  ClientSession(const ClientSession&) = delete;
  ClientSession& operator=(const ClientSession&) = delete;

  void on_open(WebSocketLink& link) override;
  void on_text(std::string_view text) override;
  void on_binary(std::string_view bytes) override;
  std::optional<OutMessage> next_message() override { return outbox_.next(); }

  void send_text(std::string text);
  void send_binary(std::string bytes);
  void deliver(ChannelId channel, bool conflated, HostTime log_time, const SharedBytes& payload);
  void send_playback_state(const PlaybackState& state);
  /// What waits to be sent tells of another time.
  void forget() { outbox_.remove_payloads(); }
  std::uint64_t dropped_images() const { return outbox_.dropped_images(); }

 private:
  void handle(const Subscribe& message);
  void handle(const Unsubscribe& message);
  void handle(const GetParameters& message);
  void handle(const NotOffered& message);
  void subscribe(SubscriptionId subscription, ChannelId channel);
  void push(OutMessage message);

  Hub& hub_;
  bool is_told_of_playback_;
  WebSocketLink* link_ = nullptr;
  Outbox outbox_;
  bool too_slow_ = false;
  std::map<SubscriptionId, ChannelId> subscriptions_;
  std::multimap<ChannelId, SubscriptionId> by_channel_;
};

}  // namespace roseau::display
