#include "schema/wire.h"

#include <cstring>

#include "schema/utf8.h"

namespace roseau::schema {

namespace {
constexpr std::int64_t kNanosPerSecond = 1'000'000'000;
constexpr std::uint32_t kSecondsField = 1;  // of google.protobuf.Timestamp and Duration
constexpr std::uint32_t kNanosField = 2;

std::size_t put_varint(std::byte* to, std::uint64_t value) {
  std::size_t size = 0;
  while (value >= 0x80) {
    to[size++] = static_cast<std::byte>(value | 0x80);
    value >>= 7;
  }
  to[size++] = static_cast<std::byte>(value);
  return size;
}

constexpr std::size_t kMaxVarint = 10;
}  // namespace

// ---------------------------------------------------------------------------------------------------------------------
// Writer

void Writer::append(const void* bytes, std::size_t size) {
  const auto* begin = static_cast<const std::byte*>(bytes);
  out_.insert(out_.end(), begin, begin + size);
}

void Writer::varint(std::uint64_t value) {
  std::array<std::byte, kMaxVarint> bytes;
  append(bytes.data(), put_varint(bytes.data(), value));
}

void Writer::real(std::uint32_t field, double value) {
  if (std::bit_cast<std::uint64_t>(value) == 0) return;  // -0.0 and NaN are written: every bit comes back
  tag(field, WireType::fixed64);
  append(&value, sizeof value);
}

void Writer::real32(std::uint32_t field, float value) {
  if (std::bit_cast<std::uint32_t>(value) == 0) return;
  tag(field, WireType::fixed32);
  append(&value, sizeof value);
}

void Writer::fixed32(std::uint32_t field, std::uint32_t value) {
  if (value == 0) return;
  tag(field, WireType::fixed32);
  append(&value, sizeof value);
}

void Writer::flag(std::uint32_t field, bool value) {
  if (!value) return;
  tag(field, WireType::varint);
  varint(1);
}

void Writer::text(std::uint32_t field, std::string_view value) {
  if (is_utf8(value)) return bytes(field, std::as_bytes(std::span(value)));
  const std::string repaired = to_utf8(value);
  bytes(field, std::as_bytes(std::span(repaired)));
}

void Writer::bytes(std::uint32_t field, std::span<const std::byte> value) {
  if (value.empty()) return;
  tag(field, WireType::length_delimited);
  varint(value.size());
  append(value.data(), value.size());
}

void Writer::last_bytes(std::uint32_t field, std::span<const std::byte> value) {
  tail_ = value;
  if (value.empty()) return;
  tag(field, WireType::length_delimited);
  varint(value.size());
}

void Writer::seconds_and_nanos(std::uint32_t field, std::int64_t seconds, std::int64_t nanos) {
  std::array<std::byte, 2 + 2 * kMaxVarint> body;
  std::size_t size = 0;
  const auto put = [&](std::uint32_t inner_field, std::int64_t value) {
    if (value == 0) return;
    body[size++] = static_cast<std::byte>(inner_field << 3U);
    size += put_varint(body.data() + size, static_cast<std::uint64_t>(value));  // negative: ten bytes, as protobuf wants
  };
  put(kSecondsField, seconds);
  put(kNanosField, nanos);
  tag(field, WireType::length_delimited);
  varint(size);
  append(body.data(), size);
}

// A Timestamp's nanos count forward from its seconds; a Duration's have the sign of its seconds.
void Writer::time(std::uint32_t field, HostTime value) {
  const std::int64_t time_ns = to_ns(value);
  const std::int64_t nanos = ((time_ns % kNanosPerSecond) + kNanosPerSecond) % kNanosPerSecond;
  const std::int64_t seconds = time_ns / kNanosPerSecond - (time_ns % kNanosPerSecond < 0 ? 1 : 0);
  seconds_and_nanos(field, seconds, nanos);
}

void Writer::duration(std::uint32_t field, Duration value) {
  if (value.count() == 0) return;
  seconds_and_nanos(field, value.count() / kNanosPerSecond, value.count() % kNanosPerSecond);
}

void Writer::device_time(std::uint32_t field, const std::optional<DeviceTime>& value) {
  if (!value) return;
  seconds_and_nanos(field, to_ns(*value) / kNanosPerSecond, to_ns(*value) % kNanosPerSecond);
}

void Writer::floats(std::uint32_t field, const std::vector<float>& values) { bytes(field, std::as_bytes(std::span(values))); }

void Writer::doubles(std::uint32_t field, std::span<const double> values) { bytes(field, std::as_bytes(values)); }

std::size_t Writer::begin_message(std::uint32_t field) {
  tag(field, WireType::length_delimited);
  out_.push_back(std::byte{0});  // length, for the usual short message
  return out_.size();
}

void Writer::end_message(std::size_t begin) {
  const std::size_t size = out_.size() - begin;
  std::array<std::byte, kMaxVarint> length;
  const std::size_t length_size = put_varint(length.data(), size);
  out_[begin - 1] = length[0];
  if (length_size == 1) return;
  const auto at = out_.begin() + static_cast<std::ptrdiff_t>(begin);
  out_.insert(at, length.begin() + 1, length.begin() + static_cast<std::ptrdiff_t>(length_size));
}

// ---------------------------------------------------------------------------------------------------------------------
// Reader

void Reader::fail(ErrorCode code, const std::string& what) {
  if (!fault_) fault_ = Error{code, "field " + std::to_string(field_) + " " + what};
  rest_ = {};
}

std::span<const std::byte> Reader::take(std::uint64_t size) {
  if (size > rest_.size()) {
    fail(ErrorCode::truncated, "runs past the end of the message");
    return {};
  }
  const auto taken = rest_.first(size);
  rest_ = rest_.subspan(size);
  return taken;
}

std::uint64_t Reader::varint() {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < kMaxVarint; ++i) {
    const auto byte = take(1);
    if (byte.empty()) return 0;
    const auto bits = static_cast<std::uint64_t>(byte[0]);
    value |= (bits & 0x7F) << (7 * i);
    if (bits < 0x80) return value;
  }
  fail(ErrorCode::corrupt, "holds a number of more than ten bytes");
  return 0;
}

std::span<const std::byte> Reader::length_delimited() { return take(varint()); }

template <class T>
T Reader::fixed() {
  const auto bytes = take(sizeof(T));
  T value{};
  if (bytes.size() == sizeof(T)) std::memcpy(&value, bytes.data(), sizeof(T));
  return value;
}

bool Reader::next_field() {
  if (fault_ || rest_.empty()) return false;
  const std::uint64_t tag = varint();
  constexpr std::uint64_t kMaxField = (1U << 29U) - 1;
  if (!fault_ && (tag >> 3U < 1 || tag >> 3U > kMaxField)) fail(ErrorCode::corrupt, "is followed by an impossible number");
  field_ = static_cast<std::uint32_t>(tag >> 3U);
  type_ = static_cast<WireType>(tag & 7U);
  taken_ = false;
  return !fault_;
}

void Reader::skip_field() {
  switch (type_) {
    case WireType::varint:
      varint();
      return;
    case WireType::fixed64:
      take(8);
      return;
    case WireType::length_delimited:
      length_delimited();
      return;
    case WireType::fixed32:
      take(4);
      return;
  }
  fail(ErrorCode::corrupt, "has a wire type that no message of ours or Foxglove's has");
}

void Reader::real(std::uint32_t field, double& value) {
  if (takes(field, WireType::fixed64)) value = fixed<double>();
}

void Reader::real32(std::uint32_t field, float& value) {
  if (takes(field, WireType::fixed32)) value = fixed<float>();
}

void Reader::fixed32(std::uint32_t field, std::uint32_t& value) {
  if (takes(field, WireType::fixed32)) value = fixed<std::uint32_t>();
}

void Reader::flag(std::uint32_t field, bool& value) {
  if (takes(field, WireType::varint)) value = varint() != 0;
}

void Reader::text(std::uint32_t field, std::string& value) {
  if (!takes(field, WireType::length_delimited)) return;
  const auto bytes = length_delimited();
  value.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

void Reader::last_bytes(std::uint32_t field, std::span<const std::byte>& value) {
  if (takes(field, WireType::length_delimited)) value = length_delimited();
}

/// Of a Timestamp or a Duration: both have the same two fields.
std::int64_t Reader::seconds_and_nanos() {
  std::int64_t seconds = 0;
  std::int64_t nanos = 0;
  Reader nested(length_delimited());
  while (nested.next_field()) {
    if (nested.takes(kSecondsField, WireType::varint)) {
      seconds = static_cast<std::int64_t>(nested.varint());
    } else if (nested.takes(kNanosField, WireType::varint)) {
      nanos = static_cast<std::int64_t>(nested.varint());
    } else {
      nested.skip_field();
    }
  }
  if (nested.fault_ && !fault_) fault_ = nested.fault_->with_context("field " + std::to_string(field_));
  std::int64_t total_ns = 0;
  if (nanos <= -kNanosPerSecond || nanos >= kNanosPerSecond ||
      // Seconds and nanos of opposite sign can lie on the far side of the range only for a moment: add in the safe order.
      __builtin_mul_overflow(seconds + (seconds < 0 && nanos > 0 ? 1 : 0), kNanosPerSecond, &total_ns) ||
      __builtin_add_overflow(total_ns, nanos - (seconds < 0 && nanos > 0 ? kNanosPerSecond : 0), &total_ns)) {
    fail(ErrorCode::corrupt, "holds a time that does not fit nanoseconds in 64 bits");
    return 0;
  }
  return total_ns;
}

void Reader::time(std::uint32_t field, HostTime& value) {
  if (takes(field, WireType::length_delimited)) value = host_time_from_ns(seconds_and_nanos());
}

void Reader::duration(std::uint32_t field, Duration& value) {
  if (takes(field, WireType::length_delimited)) value = Duration{seconds_and_nanos()};
}

void Reader::device_time(std::uint32_t field, std::optional<DeviceTime>& value) {
  if (takes(field, WireType::length_delimited)) value = device_time_from_ns(seconds_and_nanos());
}

/// proto3 writes repeated numbers packed; a reader must take them one by one as well.
template <class T>
void Reader::numbers(std::uint32_t field, WireType single, std::vector<T>& values) {
  if (takes(field, single)) {
    values.push_back(fixed<T>());
    return;
  }
  if (!takes(field, WireType::length_delimited)) return;
  const auto bytes = length_delimited();
  if (bytes.size() % sizeof(T) != 0) return fail(ErrorCode::corrupt, "holds a part of a number");
  const std::size_t before = values.size();
  values.resize(before + bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(values.data() + before, bytes.data(), bytes.size());
}

void Reader::floats(std::uint32_t field, std::vector<float>& values) { numbers(field, WireType::fixed32, values); }

void Reader::doubles(std::uint32_t field, std::vector<double>& values) { numbers(field, WireType::fixed64, values); }

}  // namespace roseau::schema
