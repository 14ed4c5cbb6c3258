#include "display/inbox.h"

#include <utility>

namespace roseau::display {

bool is_conflated(SampleKind kind) { return kind == SampleKind::frame || kind == SampleKind::image_motion; }

bool Inbox::push(InboxItem item) {
  // Declared first, destroyed last: the replaced picture's buffer goes back to its pool outside the lock.
  std::optional<InboxItem> replaced;
  {
    const std::scoped_lock lock(mutex_);
    const StreamId stream = item.sample.header.stream;
    if (is_conflated(item.sample.kind())) {
      const auto [place, is_new] = latest_.try_emplace(stream);
      if (!is_new) {
        ++dropped_[stream];
        replaced = std::move(place->second);
      }
      place->second = std::move(item);
    } else if (small_.size() < capacity_) {
      small_.push_back(std::move(item));
    } else {
      ++dropped_[stream];
      return false;
    }
  }
  arrived_.notify_one();
  return true;
}

std::optional<InboxItem> Inbox::pop(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  arrived_.wait_for(lock, timeout, [this] { return closed_ || !small_.empty() || !latest_.empty(); });
  return take();
}

std::optional<InboxItem> Inbox::take() {
  if (!small_.empty()) {
    InboxItem item = std::move(small_.front());
    small_.pop_front();
    return item;
  }
  if (latest_.empty()) return std::nullopt;
  auto chosen = latest_.upper_bound(last_stream_);
  if (chosen == latest_.end()) chosen = latest_.begin();
  last_stream_ = chosen->first;
  InboxItem item = std::move(chosen->second);
  latest_.erase(chosen);
  return item;
}

void Inbox::clear() {
  // Swapped out: the pictures' buffers go back to their pool outside the lock.
  std::deque<InboxItem> small;
  std::map<StreamId, InboxItem> latest;
  const std::scoped_lock lock(mutex_);
  small_.swap(small);
  latest_.swap(latest);
}

void Inbox::close() {
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
  }
  arrived_.notify_all();
}

void Inbox::count_drop(StreamId stream) {
  const std::scoped_lock lock(mutex_);
  ++dropped_[stream];
}

std::map<StreamId, std::uint64_t> Inbox::dropped() const {
  const std::scoped_lock lock(mutex_);
  return dropped_;
}

}  // namespace roseau::display
