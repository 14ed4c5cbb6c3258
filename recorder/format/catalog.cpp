#include "recorder/format/catalog.h"

#include <string>

namespace roseau::mcap {

Result<void> Catalog::add(const Schema& schema) {
  if (schema.id == 0) return {};
  const auto [known, added] = schemas_.try_emplace(schema.id, schema);
  if (!added &&
      (known->second.name != schema.name || known->second.encoding != schema.encoding || known->second.data != schema.data)) {
    return Error{ErrorCode::corrupt, "two different schemas have the id " + std::to_string(schema.id)};
  }
  return {};
}

Result<void> Catalog::add(const Channel& channel) {
  if (channel.schema_id != 0 && !schemas_.contains(channel.schema_id)) {
    return Error{ErrorCode::corrupt, "channel " + channel.topic + " uses schema " + std::to_string(channel.schema_id) +
                                         ", which the file does not hold"};
  }
  const auto [known, added] = channels_.try_emplace(channel.id, channel);
  if (!added && (known->second.topic != channel.topic || known->second.schema_id != channel.schema_id ||
                 known->second.message_encoding != channel.message_encoding || known->second.metadata != channel.metadata)) {
    return Error{ErrorCode::corrupt, "two different channels have the id " + std::to_string(channel.id)};
  }
  return {};
}

const Channel* Catalog::channel(std::uint16_t id) const {
  const auto found = channels_.find(id);
  return found == channels_.end() ? nullptr : &found->second;
}

const Schema* Catalog::schema_of(const Channel& channel) const {
  const auto found = schemas_.find(channel.schema_id);
  return found == schemas_.end() ? nullptr : &found->second;
}

}  // namespace roseau::mcap
