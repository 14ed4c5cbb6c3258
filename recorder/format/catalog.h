// Catalog: the schemas and channels of a file, and the rules between them.
#pragma once

#include <cstdint>
#include <map>

#include "core/result.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

class Catalog {
 public:
  /// Corrupt when the id is taken by something else. Schema id 0 is ignored, as the specification wants.
  Result<void> add(const Schema& schema);
  /// Corrupt when the id is taken by something else, or its schema is not known.
  Result<void> add(const Channel& channel);

  /// Null when there is none. Addresses stay valid for the catalog's life.
  const Channel* channel(std::uint16_t id) const;
  /// The channel's schema; null for a schemaless channel.
  const Schema* schema_of(const Channel& channel) const;

  const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, Channel>& channels() const { return channels_; }

 private:
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
};

}  // namespace roseau::mcap
