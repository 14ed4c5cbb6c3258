// Result<T>: a value or an Error, spelled like std::expected (C++23) so that it can be replaced by it.
//
// Run-time failures (a missing file, an unplugged cable, a full disk) are Results. Bugs are CHECKs. Bad data is a sample
// status.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "core/check.h"

namespace roseau {

enum class ErrorCode {
  invalid_argument,  // the caller or the user asked for something that cannot be
  not_found,         // file, device, key or topic does not exist
  permission,        // exists, but we may not
  busy,              // in use by someone else
  io,                // the operating system or a device failed
  no_space,          // the disk is full
  corrupt,           // the bytes do not say what they should
  truncated,         // the bytes end too early
  unsupported,       // valid, but not something this program or build can do
  timeout,
  disconnected,
};

/// What went wrong, in words for the operator: names the file, key or device and says what to do.
struct [[nodiscard]] Error {
  ErrorCode code;
  std::string message;

  /// The same error seen from further out: "context: message".
  Error with_context(const std::string& context) const { return {code, context + ": " + message}; }
};

template <class T>
class [[nodiscard]] Result {
 public:
  using value_type = T;

  // Implicit on purpose, as in std::expected: `return value;` and `return Error{...};`.
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  T& value() & {
    ROSEAU_CHECK(has_value());
    return *std::get_if<0>(&state_);
  }
  const T& value() const& {
    ROSEAU_CHECK(has_value());
    return *std::get_if<0>(&state_);
  }
  T&& value() && {
    ROSEAU_CHECK(has_value());
    return std::move(*std::get_if<0>(&state_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const& {
    ROSEAU_CHECK(!has_value());
    return *std::get_if<1>(&state_);
  }
  Error&& error() && {
    ROSEAU_CHECK(!has_value());
    return std::move(*std::get_if<1>(&state_));
  }

 private:
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  using value_type = void;

  Result() = default;
  Result(Error error) : state_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  const Error& error() const& {
    ROSEAU_CHECK(!has_value());
    return *std::get_if<1>(&state_);
  }
  Error&& error() && {
    ROSEAU_CHECK(!has_value());
    return std::move(*std::get_if<1>(&state_));
  }

 private:
  std::variant<std::monostate, Error> state_;
};

}  // namespace roseau
