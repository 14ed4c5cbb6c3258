// A stage's state as bytes: for the checkpoint with which a recording begins that was started in mid-run. The bytes are read
// by the same program on the same kind of machine, so numbers are stored as they lie in memory, field by field (no padding).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace roseau::estimation {

template <class T>
concept StoredNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class StateWriter {
 public:
  explicit StateWriter(std::vector<std::byte>& out) : out_(out) {}

  template <StoredNumber T>
  void operator()(const T& value) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    out_.insert(out_.end(), bytes, bytes + sizeof(T));
  }
  void operator()(const std::string& text) {
    (*this)(static_cast<std::uint64_t>(text.size()));
    for (const char c : text) (*this)(c);
  }
  template <class T>
  void operator()(const std::vector<T>& values) {
    (*this)(static_cast<std::uint64_t>(values.size()));
    for (const T& value : values) (*this)(value);
  }
  template <class T>
  void operator()(const std::optional<T>& value) {
    (*this)(value.has_value());
    if (value) (*this)(*value);
  }
  /// A class of ours lists its fields once, for both ways: template <class Archive> void archive(Archive& a) { a(x), a(y); }
  template <class T>
    requires std::is_class_v<T>
  void operator()(const T& value) {
    const_cast<T&>(value).archive(*this);  // the writer changes nothing
  }

 private:
  std::vector<std::byte>& out_;
};

/// After a failure (bytes that end early, an impossible size) every further read gives nothing and ok() is false.
class StateReader {
 public:
  explicit StateReader(std::span<const std::byte> in) : in_(in) {}
  bool ok() const { return ok_; }
  bool at_end() const { return in_.empty(); }

  template <StoredNumber T>
  void operator()(T& value) {
    if (!take(sizeof(T))) return;
    std::memcpy(&value, taken_.data(), sizeof(T));
  }
  void operator()(bool& value) {
    std::uint8_t byte = 0;
    (*this)(byte);
    value = byte != 0;
  }
  void operator()(std::string& text) {
    std::uint64_t size = 0;
    (*this)(size);
    if (!take(size)) return;
    text.assign(reinterpret_cast<const char*>(taken_.data()), taken_.size());
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    std::uint64_t size = 0;
    (*this)(size);
    if (size > in_.size()) ok_ = false;  // every element takes at least a byte
    values.clear();
    for (std::uint64_t i = 0; ok_ && i < size; ++i) (*this)(values.emplace_back());
  }
  template <class T>
  void operator()(std::optional<T>& value) {
    bool has = false;
    (*this)(has);
    value.reset();
    if (ok_ && has) (*this)(value.emplace());
  }
  template <class T>
    requires std::is_class_v<T>
  void operator()(T& value) {
    value.archive(*this);
  }

 private:
  bool take(std::uint64_t size) {
    if (!ok_ || size > in_.size()) {
      ok_ = false;
      return false;
    }
    taken_ = in_.first(size);
    in_ = in_.subspan(size);
    return true;
  }

  std::span<const std::byte> in_;
  std::span<const std::byte> taken_;
  bool ok_ = true;
};

}  // namespace roseau::estimation
