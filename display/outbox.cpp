#include "display/outbox.h"

#include <utility>

namespace roseau::display {

bool Outbox::push(OutMessage message) {
  if (waiting_bytes_ + message.size() > budget_bytes_) return false;
  waiting_bytes_ += message.size();
  small_.push_back(std::move(message));
  return true;
}

void Outbox::put_latest(std::uint32_t slot, OutMessage message) {
  const auto [place, is_new] = latest_.insert_or_assign(slot, std::move(message));
  if (!is_new) ++dropped_images_;
}

void Outbox::remove_slot(std::uint32_t slot) { latest_.erase(slot); }

void Outbox::remove_payloads() {
  latest_.clear();
  std::erase_if(small_, [this](const OutMessage& message) {
    if (message.payload == nullptr) return false;
    waiting_bytes_ -= message.size();
    return true;
  });
}

std::optional<OutMessage> Outbox::next() {
  if (!small_.empty()) {
    OutMessage message = std::move(small_.front());
    small_.pop_front();
    waiting_bytes_ -= message.size();
    return message;
  }
  if (latest_.empty()) return std::nullopt;
  // In turn: with a fixed order a slow client would only ever see the first camera.
  auto chosen = latest_.upper_bound(last_slot_);
  if (chosen == latest_.end()) chosen = latest_.begin();
  last_slot_ = chosen->first;
  OutMessage message = std::move(chosen->second);
  latest_.erase(chosen);
  return message;
}

}  // namespace roseau::display
