// Whether bytes are a message of a protobuf schema that a file brings along: for messages of other programs, whose types this
// one does not know.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace roseau::schema {

class PayloadChecker {
 public:
  /// `descriptor_set`: a serialized FileDescriptorSet with everything that the message refers to, as session files hold it.
  /// Errors: corrupt (not a descriptor set), not_found (no such message, or one that it refers to is missing).
  static Result<PayloadChecker> make(std::string_view descriptor_set, const std::string& message_name);

  /// Every field has the wire type that the schema says, every length fits, every string of proto3 is UTF-8. Fields that the
  /// schema does not know are walked over: a newer writer may have added them. Errors: corrupt or truncated, naming the field.
  Result<void> check(std::span<const std::byte> message) const;

 private:
  struct Field {
    std::string name;
    std::uint64_t type = 0;  // FieldDescriptorProto.Type
    bool is_repeated = false;
    std::size_t message_type = 0;  // of types_, for messages and groups
  };
  struct MessageType {
    std::string name;
    bool is_proto3 = false;
    std::map<std::uint32_t, Field> fields;
  };
  class Maker;
  Result<void> check(std::span<const std::byte> message, const MessageType& type, int depth) const;
  Result<void> check_field(std::uint32_t number, std::uint8_t wire_type, std::span<const std::byte> value,
                           const MessageType& type, int depth) const;

  std::vector<MessageType> types_;
  std::size_t root_ = 0;
};

}  // namespace roseau::schema
