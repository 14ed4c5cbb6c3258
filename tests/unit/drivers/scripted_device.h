// A byte stream whose other side is a script in the test, on a clock of the test's own.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/link/byte_stream.h"

namespace roseau::testing {

/// What both sides see.
struct ScriptedDevice {
  HostTime now = host_time_from_ns(1'000'000'000);
  std::string to_host;       // comes with the next read
  std::string commands;      // what the host has said since it was last looked at
  bool is_connected = true;  // false: writes fail
  bool is_live = true;
  int openings = 0;
  std::function<void(const std::string& command)> on_command;  // may add to to_host

  std::string take_commands() { return std::exchange(commands, {}); }
};

class ScriptedStream : public link::ByteStream {
 public:
  explicit ScriptedStream(std::shared_ptr<ScriptedDevice> device) : device_(std::move(device)) {}

  Result<void> open() override {
    ++device_->openings;
    return {};
  }
  Result<link::Received> read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) override {
    if (device_->to_host.empty()) device_->now += timeout;
    const std::string text = std::exchange(device_->to_host, {});
    std::ranges::copy(std::as_bytes(std::span(text)), buffer.begin());
    return link::Received{.size = text.size(), .first_byte_time = device_->now};
  }
  Result<void> write(std::span<const std::byte> bytes) override {
    if (!device_->is_connected) return Error{ErrorCode::disconnected, "nobody is connected"};
    const std::string command(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    device_->commands += command;
    if (device_->on_command) device_->on_command(command);
    return {};
  }
  void close() override {}
  std::string description() const override { return "scripted port"; }
  Duration byte_time() const override { return Duration{86'806}; }
  bool is_live() const override { return device_->is_live; }

 private:
  std::shared_ptr<ScriptedDevice> device_;
};

}  // namespace roseau::testing
