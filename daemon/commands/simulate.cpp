#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/progress.h"
#include "daemon/scene_file.h"
#include "daemon/version.h"
#include "drivers/camera/jpeg/jpeg_camera.h"
#include "recorder/recorder.h"
#include "synthesis/simulated_rig.h"

namespace roseau::daemon {

namespace {

// The targets are known before the first frame, not with it.
constexpr Duration kLead = std::chrono::milliseconds(1);

/// Passes samples to the recorder and shows how far the scene has come.
class ProgressSink : public SampleSink {
 public:
  ProgressSink(recorder::Recorder& recorder, double seconds) : recorder_(recorder), seconds_(seconds) {}
  bool receive(Sample sample) override {
    const Duration since = sample.header.arrival_time - synthesis::SimulatedRig::kSimulatedStart;
    progress_.update(to_seconds(since) / seconds_);
    ++samples_;
    return recorder_.receive(std::move(sample));
  }
  std::uint64_t samples() const { return samples_; }

 private:
  recorder::Recorder& recorder_;
  const double seconds_;
  std::uint64_t samples_ = 0;
  Progress progress_{"simulate"};
};

/// The targets that the scene knows of, as what an operator would have said before the first frame.
void record_targets(const synthesis::SimulatedRig& rig, StreamTable& streams, SampleSink& sink) {
  const auto stream = streams.add({.topic = "/roseau/operator", .kind = "operator_action"});
  std::uint32_t sequence = 0;
  for (auto& action : rig.targets()) {
    Sample sample;
    sample.header.stream = stream;
    sample.header.sequence = sequence++;
    sample.header.arrival_time = synthesis::SimulatedRig::kSimulatedStart - kLead;
    sample.header.sample_time = sample.header.arrival_time;
    sample.payload = std::move(action);
    sink.receive(std::move(sample));
  }
}

}  // namespace

int simulate_command(const SimulateArguments& arguments) {
  const auto scene = load_scene(arguments.scene.value_or(""), arguments.seed);
  if (!scene) return failed(scene.error());
  const auto rig = synthesis::SimulatedRig::create(*scene);
  if (!rig) return failed(rig.error());
  StreamTable streams;
  const auto storage = image_storage_from_string(arguments.image_storage);
  if (!storage) return failed(storage.error());
  recorder::RecorderOptions options{.wait_when_full = true, .reproducible = true};
  for (std::size_t i = 0; i < scene->cameras.size(); ++i) options.image_storage["camera" + std::to_string(i)] = *storage;
  recorder::Recorder recorder(streams, options);
  recorder::SessionDescription description;
  description.program_version = kVersion;
  description.config_text = scene_config_text();
  // Of the scene, not of the file: the same scene and seed give the same bytes wherever they go.
  description.other["name"] = arguments.scene ? arguments.scene->stem().string() : "demo";
  description.other["scene_seed"] = std::to_string(scene->seed);
  if (auto opened = recorder.open(arguments.output, description); !opened) return failed(opened.error());
  ProgressSink sink(recorder, arguments.seconds);
  record_targets(*rig, streams, sink);
  camera::FrameCoder coder(arguments.jpeg_quality);
  camera::CodedBuffers buffers;
  camera::JpegSink jpeg(sink, coder, buffers);
  SampleSink& entrance = *storage == ImageStorage::jpeg ? static_cast<SampleSink&>(jpeg) : sink;
  const auto simulated = synthesis::simulate(*rig, arguments.seconds, streams, entrance);
  if (auto closed = recorder.close(); !closed) return failed(closed.error());
  if (!simulated) return failed(simulated.error());
  const auto state = recorder.state();
  if (arguments.json) {
    const nlohmann::ordered_json json = {{"path", state.path},
                                         {"bytes", state.bytes},
                                         {"seconds", arguments.seconds},
                                         {"samples", sink.samples()},
                                         {"seed", scene->seed}};
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{}: {:.1f} s, {} samples, {:.1f} MB, seed {}\n", state.path, arguments.seconds, sink.samples(),
               static_cast<double>(state.bytes) * 1e-6, scene->seed);
  }
  return kExitOk;
}

}  // namespace roseau::daemon
