// Writing and reading a stage's state as bytes, bit for bit. The reader never trusts a length or a count that it has read.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

namespace roseau::tracking {

static_assert(std::endian::native == std::endian::little, "checkpoints are written in the byte order of memory");

class CheckpointWriter {
 public:
  explicit CheckpointWriter(std::vector<std::byte>& out) : out_(out) {}

  template <class T>
    requires std::is_arithmetic_v<T>
  void put(T value) {
    put_bytes(std::as_bytes(std::span(&value, 1)));
  }
  void put_bytes(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    const std::size_t before = out_.size();
    out_.resize(before + bytes.size());
    std::memcpy(out_.data() + before, bytes.data(), bytes.size());
  }
  void put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    put_bytes(std::as_bytes(std::span(text)));
  }
  template <class Scalar, int Rows, int Columns>
  void put(const Eigen::Matrix<Scalar, Rows, Columns>& matrix) {
    for (int i = 0; i < Rows * Columns; ++i) put(matrix.data()[i]);
  }

 private:
  std::vector<std::byte>& out_;
};

/// Once something did not fit, ok() is false and everything read is zero or empty.
class CheckpointReader {
 public:
  explicit CheckpointReader(std::span<const std::byte> in) : in_(in) {}

  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && in_.empty(); }

  template <class T>
    requires std::is_arithmetic_v<T>
  void get(T& value) {
    value = T{};
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      get(byte);
      value = byte != 0;  // any other bit pattern in a bool would be undefined
    } else {
      const auto bytes = take(sizeof(T));
      if (ok_) std::memcpy(&value, bytes.data(), sizeof(T));
    }
  }
  std::span<const std::byte> take(std::size_t count) {
    if (!ok_ || count > in_.size()) {
      ok_ = false;
      return {};
    }
    const auto bytes = in_.first(count);
    in_ = in_.subspan(count);
    return bytes;
  }
  void get(std::string& text) {
    std::uint32_t size = 0;
    get(size);
    const auto bytes = take(size);
    text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  template <class Scalar, int Rows, int Columns>
  void get(Eigen::Matrix<Scalar, Rows, Columns>& matrix) {
    for (int i = 0; i < Rows * Columns; ++i) get(matrix.data()[i]);
  }
  /// A count of items that take at least `least_bytes` each: more than could follow is an error.
  std::size_t get_count(std::size_t least_bytes) {
    std::uint32_t count = 0;
    get(count);
    if (ok_ && count > in_.size() / least_bytes) ok_ = false;
    return ok_ ? count : 0;
  }
  void fail() { ok_ = false; }

 private:
  std::span<const std::byte> in_;
  bool ok_ = true;
};

}  // namespace roseau::tracking
