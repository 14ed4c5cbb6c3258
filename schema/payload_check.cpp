#include "schema/payload_check.h"

#include <optional>
#include <utility>

#include "schema/utf8.h"

namespace roseau::schema {

namespace {

constexpr int kMostNesting = 100;  // as libprotobuf's own limit

constexpr std::uint8_t kVarint = 0;
constexpr std::uint8_t kFixed64 = 1;
constexpr std::uint8_t kLengthDelimited = 2;
constexpr std::uint8_t kGroupBegin = 3;
constexpr std::uint8_t kGroupEnd = 4;
constexpr std::uint8_t kFixed32 = 5;

// FieldDescriptorProto.Type
constexpr std::uint64_t kString = 9;
constexpr std::uint64_t kGroup = 10;
constexpr std::uint64_t kMessage = 11;
constexpr std::uint64_t kBytes = 12;

/// What stands on the wire for a field of this type.
std::optional<std::uint8_t> wire_type_of(std::uint64_t type) {
  switch (type) {
    case 1:   // double
    case 6:   // fixed64
    case 16:  // sfixed64
      return kFixed64;
    case 2:   // float
    case 7:   // fixed32
    case 15:  // sfixed32
      return kFixed32;
    case kString:
    case kMessage:
    case kBytes:
      return kLengthDelimited;
    case kGroup:
      return kGroupBegin;
    case 3:   // int64
    case 4:   // uint64
    case 5:   // int32
    case 8:   // bool
    case 13:  // uint32
    case 14:  // enum
    case 17:  // sint32
    case 18:  // sint64
      return kVarint;
    default:
      return std::nullopt;
  }
}

Error malformed(const char* what) { return {ErrorCode::corrupt, what}; }

/// Field by field over the bytes of one message, without knowing it.
class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> bytes) : rest_(bytes) {}

  /// False at the end. `value`: of length-delimited and fixed fields their bytes, of a group its fields.
  Result<bool> next(int depth = 0) {
    if (rest_.empty()) return false;
    const auto tag = varint();
    if (!tag) return tag.error();
    constexpr std::uint64_t kMostField = (std::uint64_t{1} << 29U) - 1;
    if (*tag >> 3U == 0 || *tag >> 3U > kMostField) return malformed("an impossible field number");
    field = static_cast<std::uint32_t>(*tag >> 3U);
    type = static_cast<std::uint8_t>(*tag & 7U);
    return read_value(depth);
  }

  std::uint32_t field = 0;
  std::uint8_t type = 0;
  std::uint64_t number = 0;
  std::span<const std::byte> value;

  std::string text() const { return {reinterpret_cast<const char*>(value.data()), value.size()}; }
  Result<std::uint64_t> varint() {
    std::uint64_t result = 0;
    for (unsigned shift = 0; shift < 70; shift += 7) {
      if (rest_.empty()) return Error{ErrorCode::truncated, "ends in the middle of a number"};
      const auto bits = static_cast<std::uint64_t>(rest_.front());
      rest_ = rest_.subspan(1);
      result |= (bits & 0x7F) << shift;
      if (bits < 0x80) return result;
    }
    return malformed("a number of more than ten bytes");
  }
  bool empty() const { return rest_.empty(); }

 private:
  Result<bool> read_value(int depth) {
    if (type == kVarint || type == kLengthDelimited) {
      const auto got = varint();
      if (!got) return got.error();
      number = *got;
      value = {};
      return type == kVarint ? Result<bool>(true) : take(number);
    }
    if (type == kFixed64) return take(8);
    if (type == kFixed32) return take(4);
    if (type == kGroupBegin) return take_group(depth);
    return malformed("a wire type that does not exist, or the end of a group that did not begin");
  }
  Result<bool> take(std::uint64_t size) {
    if (size > rest_.size()) return Error{ErrorCode::truncated, "field " + std::to_string(field) + " runs past the end"};
    value = rest_.first(size);
    rest_ = rest_.subspan(size);
    return true;
  }
  Result<bool> take_group(int depth) {
    if (depth >= kMostNesting) return malformed("nested too deeply");
    const std::uint32_t group = field;
    const auto begin = rest_;
    while (true) {
      const auto before = rest_.size();
      const auto tag = varint();
      if (!tag) return tag.error();
      if ((*tag & 7U) == kGroupEnd) {
        if (*tag >> 3U != group) return malformed("the end of another group");
        value = begin.first(begin.size() - before);
        field = group;
        type = kGroupBegin;
        return true;
      }
      field = static_cast<std::uint32_t>(*tag >> 3U);
      type = static_cast<std::uint8_t>(*tag & 7U);
      if (auto read = read_value(depth + 1); !read) return read;
    }
  }

  std::span<const std::byte> rest_;
};

Result<void> check_packed(std::span<const std::byte> value, std::uint8_t wire_type) {
  if (wire_type == kFixed32 || wire_type == kFixed64) {
    const std::size_t size = wire_type == kFixed32 ? 4 : 8;
    if (value.size() % size != 0) return malformed("holds a part of a number");
    return {};
  }
  Cursor numbers(value);
  while (!numbers.empty()) {
    if (auto got = numbers.varint(); !got) return got.error();
  }
  return {};
}

}  // namespace

// ---------------------------------------------------------------------------------------------------------------------
// The schema. Field numbers are those of google/protobuf/descriptor.proto.

class PayloadChecker::Maker {
 public:
  Result<void> read_set(std::span<const std::byte> bytes) {
    return for_each(bytes, [this](const Cursor& at) -> Result<void> {
      constexpr std::uint32_t kFile = 1;
      return at.field == kFile && at.type == kLengthDelimited ? read_file(at.value) : Result<void>{};
    });
  }

  Result<PayloadChecker> finish(const std::string& root) {
    const auto found = by_name_.find(root);
    if (found == by_name_.end()) return Error{ErrorCode::not_found, "the schema does not describe " + root};
    checker_.root_ = found->second;
    for (const auto& [type, field, name] : references_) {
      const auto referred = by_name_.find(name);
      if (referred == by_name_.end())
        return Error{ErrorCode::not_found, "the schema refers to " + name + " and does not hold it"};
      checker_.types_[type].fields[field].message_type = referred->second;
    }
    return std::move(checker_);
  }

 private:
  struct Reference {
    std::size_t type;
    std::uint32_t field;
    std::string name;
  };

  template <class Take>
  static Result<void> for_each(std::span<const std::byte> bytes, Take take) {
    Cursor at(bytes);
    while (true) {
      const auto more = at.next();
      if (!more) return more.error().with_context("the schema is no descriptor set");
      if (!*more) return {};
      if (auto taken = take(at); !taken) return taken;
    }
  }

  Result<void> read_file(std::span<const std::byte> bytes) {
    std::string package;
    bool is_proto3 = false;
    std::vector<std::span<const std::byte>> messages;
    auto read = for_each(bytes, [&](const Cursor& at) -> Result<void> {
      if (at.type != kLengthDelimited) return {};
      if (at.field == 2) package = at.text();
      if (at.field == 4) messages.push_back(at.value);
      if (at.field == 12) is_proto3 = at.text() == "proto3";
      return {};
    });
    for (const auto& message : messages) {
      if (!read) return read;
      read = read_message(message, package.empty() ? "" : package + ".", is_proto3, 0);
    }
    return read;
  }

  Result<void> read_message(std::span<const std::byte> bytes, const std::string& scope, bool is_proto3, int depth) {
    if (depth > kMostNesting) return malformed("the schema is nested too deeply");
    const std::size_t index = checker_.types_.size();
    checker_.types_.emplace_back().is_proto3 = is_proto3;
    std::vector<std::span<const std::byte>> nested;
    auto read = for_each(bytes, [&](const Cursor& at) -> Result<void> {
      if (at.type != kLengthDelimited) return {};
      if (at.field == 1) checker_.types_[index].name = scope + at.text();
      if (at.field == 2) return read_field(at.value, index);
      if (at.field == 3) nested.push_back(at.value);
      return {};
    });
    if (!read) return read;
    const std::string name = checker_.types_[index].name;
    by_name_[name] = index;
    for (const auto& one : nested) {
      if (auto inner = read_message(one, name + ".", is_proto3, depth + 1); !inner) return inner;
    }
    return {};
  }

  Result<void> read_field(std::span<const std::byte> bytes, std::size_t type) {
    constexpr std::uint64_t kRepeated = 3;
    Field field;
    std::uint32_t number = 0;
    std::string type_name;
    auto read = for_each(bytes, [&](const Cursor& at) -> Result<void> {
      if (at.field == 1 && at.type == kLengthDelimited) field.name = at.text();
      if (at.field == 3 && at.type == kVarint) number = static_cast<std::uint32_t>(at.number);
      if (at.field == 4 && at.type == kVarint) field.is_repeated = at.number == kRepeated;
      if (at.field == 5 && at.type == kVarint) field.type = at.number;
      if (at.field == 6 && at.type == kLengthDelimited) type_name = at.text();
      return {};
    });
    if (!read) return read;
    if (!wire_type_of(field.type)) return malformed("the schema has a field of a type that protobuf does not have");
    if (field.type == kMessage || field.type == kGroup) {
      if (type_name.starts_with('.')) type_name.erase(0, 1);
      references_.push_back({type, number, std::move(type_name)});
    }
    checker_.types_[type].fields[number] = std::move(field);
    return {};
  }

  PayloadChecker checker_;
  std::map<std::string, std::size_t> by_name_;
  std::vector<Reference> references_;
};

Result<PayloadChecker> PayloadChecker::make(std::string_view descriptor_set, const std::string& message_name) {
  Maker maker;
  if (auto read = maker.read_set(std::as_bytes(std::span(descriptor_set))); !read) return read.error();
  return maker.finish(message_name);
}

// ---------------------------------------------------------------------------------------------------------------------
// Messages

Result<void> PayloadChecker::check(std::span<const std::byte> message) const { return check(message, types_[root_], 0); }

Result<void> PayloadChecker::check(std::span<const std::byte> message, const MessageType& type, int depth) const {
  if (depth > kMostNesting) return malformed("nested too deeply");
  Cursor at(message);
  while (true) {
    const auto more = at.next(depth);
    if (!more) return more.error().with_context(type.name);
    if (!*more) return {};
    if (auto checked = check_field(at.field, at.type, at.value, type, depth); !checked) return checked;
  }
}

Result<void> PayloadChecker::check_field(std::uint32_t number, std::uint8_t wire_type, std::span<const std::byte> value,
                                         const MessageType& type, int depth) const {
  const auto found = type.fields.find(number);
  if (found == type.fields.end()) return {};
  const Field& field = found->second;
  const std::uint8_t expected = *wire_type_of(field.type);
  const auto where = [&] { return type.name + "." + field.name; };
  if (wire_type != expected) {
    const bool may_be_packed = field.is_repeated && expected != kLengthDelimited && expected != kGroupBegin;
    if (wire_type != kLengthDelimited || !may_be_packed) {
      return Error{ErrorCode::corrupt,
                   where() + " has wire type " + std::to_string(wire_type) + " instead of " + std::to_string(expected)};
    }
    auto packed = check_packed(value, expected);
    return packed ? packed : packed.error().with_context(where());
  }
  if (field.type == kMessage || field.type == kGroup) return check(value, types_[field.message_type], depth + 1);
  if (field.type == kString && type.is_proto3 && !is_utf8({reinterpret_cast<const char*>(value.data()), value.size()})) {
    return Error{ErrorCode::corrupt, where() + " is not UTF-8"};
  }
  return {};
}

}  // namespace roseau::schema
