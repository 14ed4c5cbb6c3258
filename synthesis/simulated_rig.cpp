#include "synthesis/simulated_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <thread>
#include <utility>

#include "synthesis/instruments/led_board.h"
#include "synthesis/instruments/magnetic_tracker.h"
#include "synthesis/instruments/sonic.h"
#include "synthesis/instruments/speaking_instrument.h"
#include "synthesis/rig/simulated_camera.h"
#include "synthesis/rig/simulated_truth.h"
#include "synthesis/rig/tracker.h"
#include "synthesis/rig/world.h"

namespace roseau::synthesis {

namespace {

constexpr Duration kPatience = std::chrono::milliseconds(500);  // how long a camera keeps frames for a reader that stalls
constexpr Duration kBufferWait = std::chrono::milliseconds(1);  // between two looks for a free frame buffer

using Devices = std::vector<std::unique_ptr<SimulatedDevice>>;

Devices make_devices(const std::shared_ptr<const World>& world) {
  Devices devices;
  const Scene& scene = world->scene();
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) devices.push_back(std::make_unique<SimulatedCamera>(world, i));
  devices.push_back(make_sonic_device(std::make_shared<Sonic>("sonic", scene.sonic, scene.seed, world), scene.seed));
  if (auto tracker = make_tracker(world)) devices.push_back(make_magnetic_tracker_device(std::move(tracker), scene.seed));
  if (world->led_board() != nullptr) {
    devices.push_back(make_led_board_device({world, world->led_board()}, scene.seed));
  }
  if (scene.truth.enabled) devices.push_back(std::make_unique<SimulatedTruth>(world));
  return devices;
}

// One device in real time.
class LiveSource final : public SampleSource {
 public:
  LiveSource(std::unique_ptr<SimulatedDevice> device, HostTime start, Pacing pacing)
      : device_(std::move(device)), start_(start), pacing_(std::move(pacing)) {
    if (!pacing_.wait) pacing_.wait = [](Duration duration) { std::this_thread::sleep_for(duration); };
  }

  const std::string& name() const override { return device_->name(); }
  bool is_live() const override { return true; }

  Result<void> open(StreamTable& streams) override {
    device_->declare(streams);
    const Duration now = pacing_.now() - start_;
    if (auto fault = device_->fault_at(now)) return *fault;
    device_->connect_at(now);
    return {};
  }

  Result<ReadStatus> read(SampleSink& sink, std::chrono::milliseconds timeout) override {
    Duration now = pacing_.now() - start_;
    if (auto fault = device_->fault_at(now)) return *fault;
    if (now - device_->next().complete > kPatience) device_->lose_before(now);
    if (const Duration left = device_->next().complete - now; left > Duration{0}) {
      pacing_.wait(std::min<Duration>(left, timeout));
      now = pacing_.now() - start_;
      if (device_->next().complete > now) return ReadStatus::idle;
    }
    if (!device_->produce(start_, sink)) device_->lose_next();
    return ReadStatus::more;
  }

  void close() override {}

 private:
  std::unique_ptr<SimulatedDevice> device_;
  HostTime start_;
  Pacing pacing_;
};

// Some devices in simulated time, in order of arrival, up to `end`.
class SimulatedSource final : public SampleSource {
 public:
  SimulatedSource(std::string name, Devices devices, Duration end)
      : name_(std::move(name)), devices_(std::move(devices)), end_(end) {}

  const std::string& name() const override { return name_; }
  bool is_live() const override { return false; }

  Result<void> open(StreamTable& streams) override {
    for (const auto& device : devices_) device->declare(streams);
    return {};
  }

  Result<ReadStatus> read(SampleSink& sink, std::chrono::milliseconds timeout) override {
    const auto next = std::ranges::min_element(devices_, {}, [](const auto& device) { return device->next().arrival; });
    if ((*next)->next().arrival >= end_) return ReadStatus::finished;
    if ((*next)->produce(SimulatedRig::kSimulatedStart, sink)) return ReadStatus::more;
    // The consumer holds all frame buffers: it gets the time to let go of some.
    std::this_thread::sleep_for(std::min<Duration>(kBufferWait, timeout));
    return ReadStatus::idle;
  }

  void close() override {}

 private:
  std::string name_;
  Devices devices_;
  Duration end_;
};

}  // namespace

Result<SimulatedRig> SimulatedRig::create(const Scene& scene) {
  auto world = World::build(scene);
  if (!world) return world.error();
  return SimulatedRig(std::move(*world));
}

std::vector<OperatorAction> SimulatedRig::targets() const {
  std::vector<OperatorAction> actions;
  for (std::size_t camera = 0; camera < world_->scene().cameras.size(); ++camera) {
    for (const PlacedTarget& target : world_->targets()) {
      actions.push_back({.kind = OperatorAction::Kind::add_target,
                         .text = target.name,
                         .camera = fmt::format("camera{}", camera),
                         .region = world_->target_region(target, camera, {})});
    }
  }
  return actions;
}

std::vector<std::unique_ptr<SampleSource>> SimulatedRig::live_sources(const Pacing& pacing) const {
  Devices devices = make_devices(world_);  // takes a second or so: the scene starts when all is ready
  const HostTime start = pacing.now();
  std::vector<std::unique_ptr<SampleSource>> sources;
  for (auto& device : devices) sources.push_back(std::make_unique<LiveSource>(std::move(device), start, pacing));
  return sources;
}

std::vector<std::unique_ptr<SampleSource>> SimulatedRig::sources(double seconds) const {
  std::vector<std::unique_ptr<SampleSource>> sources;
  for (auto& device : make_devices(world_)) {
    std::string name = device->name();
    Devices alone;
    alone.push_back(std::move(device));
    sources.push_back(std::make_unique<SimulatedSource>(std::move(name), std::move(alone), from_seconds(seconds)));
  }
  return sources;
}

std::unique_ptr<SampleSource> SimulatedRig::merged_source(double seconds) const {
  return std::make_unique<SimulatedSource>("rig", make_devices(world_), from_seconds(seconds));
}

std::vector<std::unique_ptr<EmulatedInstrument>> SimulatedRig::emulated_instruments() const {
  const Scene& scene = world_->scene();
  std::vector<std::unique_ptr<EmulatedInstrument>> instruments;
  instruments.push_back(make_speaking(std::make_shared<Sonic>("sonic", scene.sonic, scene.seed, world_), scene.seed));
  if (auto tracker = make_tracker(world_)) instruments.push_back(make_speaking(std::move(tracker), scene.seed));
  if (const LedBoard* board = world_->led_board()) {
    instruments.push_back(make_speaking(std::shared_ptr<const LedBoard>(world_, board), scene.seed));
  }
  return instruments;
}

Result<void> simulate(const SimulatedRig& rig, double seconds, StreamTable& streams, SampleSink& sink) {
  const auto source = rig.merged_source(seconds);
  if (auto opened = source->open(streams); !opened) return opened;
  while (true) {
    const auto status = source->read(sink, std::chrono::milliseconds(100));
    if (!status) return status.error();
    if (*status == ReadStatus::finished) break;
  }
  sink.flush();
  source->close();
  return {};
}

}  // namespace roseau::synthesis
