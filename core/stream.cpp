#include "core/stream.h"

#include <limits>
#include <utility>

#include "core/check.h"

namespace roseau {

StreamId StreamTable::add(StreamInfo info) {
  ROSEAU_CHECK(info.topic.starts_with('/'));
  const std::scoped_lock lock(mutex_);
  if (const auto found = by_topic_.find(info.topic); found != by_topic_.end()) return found->second;
  ROSEAU_CHECK(streams_.size() < std::numeric_limits<StreamId>::max());
  const auto id = static_cast<StreamId>(streams_.size());
  by_topic_.emplace(info.topic, id);
  streams_.push_back(std::move(info));
  return id;
}

std::optional<StreamId> StreamTable::find(std::string_view topic) const {
  const std::scoped_lock lock(mutex_);
  const auto found = by_topic_.find(topic);
  if (found == by_topic_.end()) return std::nullopt;
  return found->second;
}

const StreamInfo& StreamTable::info(StreamId id) const {
  const std::scoped_lock lock(mutex_);
  return streams_.at(id);
}

std::size_t StreamTable::size() const {
  const std::scoped_lock lock(mutex_);
  return streams_.size();
}

}  // namespace roseau
