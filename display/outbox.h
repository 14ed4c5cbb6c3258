// Outbox: what waits to be sent to one client. Small messages go in order and none is lost; of every picture channel only the
// newest waits, in a slot of its own. So a slow client sees fewer pictures, and nothing else late for their sake.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace roseau::display {

/// A message's payload, shared by all clients it goes to.
using SharedBytes = std::shared_ptr<const std::vector<std::byte>>;

struct OutMessage {
  bool is_text = false;
  std::string head;     // this client's own part
  SharedBytes payload;  // may be null

  std::size_t size() const { return head.size() + (payload ? payload->size() : 0); }
};

/// Not thread-safe: lives on the server's thread.
class Outbox {
 public:
  /// `budget_bytes`: how much of small messages may wait. The connection takes one message out at a time and the next when
  /// that has gone, so at most one picture is on its way.
  explicit Outbox(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// False when the budget is used up: the client cannot keep up and must be told so and let go. The message is not queued.
  [[nodiscard]] bool push(OutMessage message);

  /// Replaces what waits in `slot`; the picture that was there is counted as dropped.
  void put_latest(std::uint32_t slot, OutMessage message);

  /// Forgets what waits in `slot` (the client has unsubscribed).
  void remove_slot(std::uint32_t slot);

  /// Forgets every message with a payload, pictures too: they tell of a time that is no longer shown.
  void remove_payloads();

  /// The next to send: all small messages first, then pictures, channel by channel in turn.
  std::optional<OutMessage> next();

  std::size_t waiting_bytes() const { return waiting_bytes_; }
  std::uint64_t dropped_images() const { return dropped_images_; }

 private:
  const std::size_t budget_bytes_;
  std::deque<OutMessage> small_;
  std::size_t waiting_bytes_ = 0;  // of small_
  std::map<std::uint32_t, OutMessage> latest_;
  std::uint32_t last_slot_ = 0;
  std::uint64_t dropped_images_ = 0;
};

}  // namespace roseau::display
