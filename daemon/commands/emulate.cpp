#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/host_clock.h"
#include "daemon/scene_file.h"
#include "daemon/stop_signals.h"
#include "drivers/link/link_spec.h"
#include "replay/emulator.h"
#include "synthesis/simulated_rig.h"

namespace roseau::daemon {

namespace {

constexpr std::chrono::milliseconds kStep{50};
constexpr std::chrono::milliseconds kControlInterval{100};
constexpr std::string_view kOwnPseudoTerminal = "pty:";

/// Which instrument speaks where.
struct Placed {
  std::string_view option;
  std::string_view name;
  std::optional<std::string> link;
};

std::vector<Placed> places_of(const EmulateArguments& arguments) {
  return {{"--sonic", "sonic", arguments.sonic},
          {"--tracker", "tracker", arguments.tracker},
          {"--led-board", "led_board", arguments.led_board}};
}

/// Links for the scene's instruments: those asked for, or a pseudo terminal each when nothing is.
Result<std::deque<replay::Emulator>> make_emulators(const EmulateArguments& arguments, const synthesis::SimulatedRig& rig) {
  auto places = places_of(arguments);
  const bool none_given = std::ranges::none_of(places, [](const Placed& placed) { return placed.link.has_value(); });
  auto instruments = rig.emulated_instruments();
  const HostTime start = host_now();
  std::deque<replay::Emulator> emulators;
  for (Placed& placed : places) {
    const auto found = std::ranges::find(instruments, placed.name, [](const auto& each) { return each->name(); });
    if (found == instruments.end()) {
      if (!placed.link) continue;
      return Error{ErrorCode::not_found, fmt::format("{}: the scene has no {}", placed.option, placed.name)};
    }
    if (none_given) placed.link = kOwnPseudoTerminal;
    if (!placed.link) continue;
    auto stream = link::make_byte_stream(*placed.link);
    if (!stream) return stream.error().with_context(std::string(placed.option));
    emulators.emplace_back(std::move(*stream), std::move(*found), start, host_now);
    if (auto opened = emulators.back().open(); !opened) return opened.error().with_context(std::string(placed.option));
    instruments.erase(found);
  }
  return emulators;
}

/// The first thing that went wrong in any thread.
class Failure {
 public:
  void set(const Error& error) {
    const std::scoped_lock lock(mutex_);
    if (!error_) error_ = error;
    happened_ = true;
  }
  bool happened() const { return happened_; }
  const std::optional<Error>& error() const { return error_; }  // when all threads have ended

 private:
  std::mutex mutex_;
  std::atomic<bool> happened_{false};
  std::optional<Error> error_;
};

void play(const std::stop_token& stop, replay::Emulator& emulator, Failure& failure) {
  while (!stop.stop_requested()) {
    if (auto stepped = emulator.step(kStep); !stepped) return failure.set(stepped.error().with_context(emulator.name()));
  }
}

void report(const std::deque<replay::Emulator>& emulators) {
  nlohmann::ordered_json json;
  for (const auto& emulator : emulators) {
    const auto& counters = emulator.counters();
    json[emulator.name()] = {{"records_sent", counters.records_sent},
                             {"bytes_sent", counters.bytes_sent},
                             {"bytes_received", counters.bytes_received}};
  }
  fmt::print("{}\n", json.dump(2));
}

}  // namespace

int emulate_command(const EmulateArguments& arguments) {
  const StopSignals signals;
  const auto scene = load_scene(arguments.scene.value_or(""), arguments.seed);
  if (!scene) return failed(scene.error());
  const auto rig = synthesis::SimulatedRig::create(*scene);
  if (!rig) return failed(rig.error());
  auto emulators = make_emulators(arguments, *rig);
  if (!emulators) return failed(emulators.error());
  for (const auto& emulator : *emulators) {
    fmt::print(stderr, "{}: {}\n", emulator.name(), emulator.description());
  }
  Failure failure;
  {
    std::deque<std::jthread> threads;
    for (auto& emulator : *emulators) {
      threads.emplace_back([&emulator, &failure](const std::stop_token& stop) { play(stop, emulator, failure); });
    }
    const HostTime begin = host_now();
    const auto is_over = [&] { return arguments.seconds && to_seconds(host_now() - begin) >= *arguments.seconds; };
    while (!failure.happened() && !is_over() && !signals.wait(kControlInterval)) {
    }
  }
  if (failure.error()) return failed(*failure.error());
  if (arguments.json) report(*emulators);
  return kExitOk;
}

}  // namespace roseau::daemon
