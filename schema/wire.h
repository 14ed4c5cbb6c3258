// The protobuf wire format, by hand: roseau's messages are few and flat, and the hot ones (pixels, bytes, wind) must cost
// nanoseconds and no copy. libprotobuf is the judge in the tests, not a part of the program.
//
// messages.h describes each message once, as a function over an "io": Writer, Reader and Clear below are the three. Field
// presence is proto3's: a field whose value is zero is not written; sub-messages (times included) always are.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/check.h"
#include "core/result.h"
#include "core/time.h"

namespace roseau::schema {

static_assert(std::endian::native == std::endian::little, "the wire format's fixed-size fields are copied as they are");

enum class WireType : std::uint8_t { varint = 0, fixed64 = 1, length_delimited = 2, fixed32 = 5 };

/// Appends fields to a buffer.
class Writer {
 public:
  template <class T>
  using Ref = const T&;

  explicit Writer(std::vector<std::byte>& out) : out_(out) {}

  void real(std::uint32_t field, double value);
  void real32(std::uint32_t field, float value);
  void fixed32(std::uint32_t field, std::uint32_t value);
  void flag(std::uint32_t field, bool value);
  void text(std::uint32_t field, std::string_view value);
  void bytes(std::uint32_t field, std::span<const std::byte> value);
  void time(std::uint32_t field, HostTime value);
  void duration(std::uint32_t field, Duration value);
  void device_time(std::uint32_t field, const std::optional<DeviceTime>& value);
  void floats(std::uint32_t field, const std::vector<float>& values);
  void doubles(std::uint32_t field, std::span<const double> values);

  /// The first `size` bytes of a fixed store.
  template <std::size_t N>
  void piece(std::uint32_t field, const std::array<std::byte, N>& store, std::uint16_t size) {
    bytes(field, std::span(store).first(size));
  }

  template <std::unsigned_integral T>
  void uint(std::uint32_t field, T value) {
    if (value == 0) return;
    tag(field, WireType::varint);
    varint(value);
  }

  /// Enums are written counted from 1, so that 0 stays "not said".
  template <class E>
  void choice(std::uint32_t field, E value, E first, E last) {
    ROSEAU_CHECK(value >= first && value <= last);
    uint(field, static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(first) + 1U);
  }

  template <class T>
  void message(std::uint32_t field, const T& value) {
    const std::size_t begin = begin_message(field);
    describe(*this, value);
    end_message(begin);
  }

  template <class T>
  void repeated(std::uint32_t field, const std::vector<T>& values) {
    for (const T& value : values) message(field, value);
  }

  /// The last field of a message, whose bytes are not copied: writes what stands before them and keeps the view (tail()).
  void last_bytes(std::uint32_t field, std::span<const std::byte> value);
  std::span<const std::byte> tail() const { return tail_; }

 private:
  void tag(std::uint32_t field, WireType type) { varint((field << 3U) | static_cast<std::uint32_t>(type)); }
  void varint(std::uint64_t value);
  void append(const void* bytes, std::size_t size);
  void seconds_and_nanos(std::uint32_t field, std::int64_t seconds, std::int64_t nanos);
  std::size_t begin_message(std::uint32_t field);
  void end_message(std::size_t begin);

  std::vector<std::byte>& out_;
  std::span<const std::byte> tail_;
};

/// Sets every field to what proto3 means by an absent one. Readers start from that, not from the C++ defaults.
class Clear {
 public:
  template <class T>
  using Ref = T&;

  void real(std::uint32_t, double& value) { value = 0; }
  void real32(std::uint32_t, float& value) { value = 0; }
  void fixed32(std::uint32_t, std::uint32_t& value) { value = 0; }
  void flag(std::uint32_t, bool& value) { value = false; }
  void text(std::uint32_t, std::string& value) { value.clear(); }
  void time(std::uint32_t, HostTime& value) { value = HostTime{}; }
  void duration(std::uint32_t, Duration& value) { value = Duration{0}; }
  void device_time(std::uint32_t, std::optional<DeviceTime>& value) { value.reset(); }
  void floats(std::uint32_t, std::vector<float>& values) { values.clear(); }
  void doubles(std::uint32_t, std::vector<double>& values) { values.clear(); }
  void last_bytes(std::uint32_t, std::span<const std::byte>& value) { value = {}; }
  template <std::size_t N>
  void piece(std::uint32_t, std::array<std::byte, N>&, std::uint16_t& size) {
    size = 0;
  }
  template <std::unsigned_integral T>
  void uint(std::uint32_t, T& value) {
    value = 0;
  }
  template <class E>
  void choice(std::uint32_t, E& value, E first, E) {
    value = first;
  }
  template <class T>
  void message(std::uint32_t, T& value) {
    describe(*this, value);
  }
  template <class T>
  void repeated(std::uint32_t, std::vector<T>& values) {
    values.clear();
  }
};

/// Reads fields in any order; skips those it does not know. After read(), fault() says whether the bytes were a message.
/// Allocates in proportion to the message, never by a number in it. Views (last_bytes) point into the message.
class Reader {
 public:
  template <class T>
  using Ref = T&;

  explicit Reader(std::span<const std::byte> message) : rest_(message) {}

  /// Calls describe_all(*this) once per field on the wire; the description takes the field that it knows.
  template <class DescribeAll>
  void read(DescribeAll describe_all) {
    while (next_field()) {
      describe_all(*this);
      if (!taken_) skip_field();
    }
  }
  const std::optional<Error>& fault() const { return fault_; }

  void real(std::uint32_t field, double& value);
  void real32(std::uint32_t field, float& value);
  void fixed32(std::uint32_t field, std::uint32_t& value);
  void flag(std::uint32_t field, bool& value);
  void text(std::uint32_t field, std::string& value);
  void time(std::uint32_t field, HostTime& value);
  void duration(std::uint32_t field, Duration& value);
  void device_time(std::uint32_t field, std::optional<DeviceTime>& value);
  void floats(std::uint32_t field, std::vector<float>& values);
  void doubles(std::uint32_t field, std::vector<double>& values);
  void last_bytes(std::uint32_t field, std::span<const std::byte>& value);

  template <std::size_t N>
  void piece(std::uint32_t field, std::array<std::byte, N>& store, std::uint16_t& size) {
    if (!takes(field, WireType::length_delimited)) return;
    const auto bytes = length_delimited();
    if (bytes.size() > N) return fail(ErrorCode::unsupported, "is longer than the " + std::to_string(N) + " bytes it may have");
    std::ranges::copy(bytes, store.begin());
    size = static_cast<std::uint16_t>(bytes.size());
  }

  template <std::unsigned_integral T>
  void uint(std::uint32_t field, T& value) {
    if (!takes(field, WireType::varint)) return;
    const std::uint64_t number = varint();
    if (number > std::numeric_limits<T>::max()) return fail(ErrorCode::corrupt, "holds a number that is too large");
    value = static_cast<T>(number);
  }

  template <class E>
  void choice(std::uint32_t field, E& value, E first, E last) {
    if (!takes(field, WireType::varint)) return;
    const std::uint64_t number = varint();
    const auto offset = static_cast<std::uint64_t>(first);
    if (number < 1 || number + offset - 1 > static_cast<std::uint64_t>(last)) {
      return fail(ErrorCode::unsupported, "holds choice " + std::to_string(number) + ", which this program does not know");
    }
    value = static_cast<E>(number + offset - 1);
  }

  template <class T>
  void message(std::uint32_t field, T& value) {
    if (!takes(field, WireType::length_delimited)) return;
    Clear clear;
    describe(clear, value);
    read_nested(value);
  }

  template <class T>
  void repeated(std::uint32_t field, std::vector<T>& values) {
    if (!takes(field, WireType::length_delimited)) return;
    Clear clear;
    describe(clear, values.emplace_back());
    read_nested(values.back());
  }

 private:
  bool next_field();
  void skip_field();
  bool takes(std::uint32_t field, WireType type) {
    if (taken_ || field != field_ || type != type_ || fault_) return false;
    taken_ = true;
    return true;
  }
  template <class T>
  void read_nested(T& value) {
    Reader nested(length_delimited());
    nested.read([&value](Reader& io) { describe(io, value); });
    if (nested.fault_ && !fault_) fault_ = nested.fault_->with_context("field " + std::to_string(field_));
  }
  template <class T>
  T fixed();
  template <class T>
  void numbers(std::uint32_t field, WireType single, std::vector<T>& values);
  std::int64_t seconds_and_nanos();
  std::uint64_t varint();
  std::span<const std::byte> length_delimited();
  std::span<const std::byte> take(std::uint64_t size);
  void fail(ErrorCode code, const std::string& what);

  std::span<const std::byte> rest_;
  std::uint32_t field_ = 0;
  WireType type_ = WireType::varint;
  bool taken_ = false;
  std::optional<Error> fault_;
};

}  // namespace roseau::schema
