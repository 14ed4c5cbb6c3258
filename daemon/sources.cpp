#include "daemon/sources.h"

#include <set>
#include <string>
#include <utility>

#include "daemon/host_clock.h"
#include "daemon/scene_file.h"
#include "drivers/camera/file/video_file.h"
#include "drivers/camera/jpeg/jpeg_camera.h"
#include "drivers/led_sync/led_board_source.h"
#include "drivers/link/link_spec.h"
#include "drivers/magnetic_tracker/magnetic_tracker_source.h"
#include "drivers/sonic/sonic_source.h"
#include "synthesis/simulated_rig.h"

namespace roseau::daemon {

namespace {

void add_camera(std::unique_ptr<SampleSource> camera, const ImageStorageConfig& images, Sources& sources) {
  sources.cameras.push_back(camera->name());
  sources.image_storage[camera->name()] = images.storage;
  if (images.storage == ImageStorage::jpeg) {
    camera = std::make_unique<camera::JpegCamera>(std::move(camera), camera::JpegOptions{.quality = images.jpeg_quality});
  }
  sources.sources.push_back(std::move(camera));
}

Result<void> add_cameras(const Config& config, Sources& sources) {
  for (const auto& camera : config.cameras) {
    camera::VideoFileOptions options;
    options.name = camera.name;
    options.path = camera.path.string();
    options.format = camera.grey ? PixelFormat::mono8 : PixelFormat::bgr8;
    if (camera.rate_hz > 0) options.rate_hz = camera.rate_hz;
    options.is_paced = true;
    options.buffer_count = 64;
    auto video = camera::make_video_file(options);
    if (!video) return video.error();
    add_camera(std::move(*video), camera.images, sources);
  }
  return {};
}

Result<void> add_sonics(const Config& config, Sources& sources) {
  for (const auto& sonic : config.sonics) {
    auto stream = link::make_byte_stream(sonic.port);
    if (!stream) return stream.error();
    sources.sources.push_back(std::make_unique<sonic::SonicSource>(sonic.options, std::move(*stream)));
  }
  return {};
}

Result<void> add_magnetic_trackers(const Config& config, Sources& sources) {
  for (const auto& tracker : config.magnetic_trackers) {
    auto stream = link::make_byte_stream(tracker.port);
    if (!stream) return stream.error();
    sources.sources.push_back(std::make_unique<magnetic_tracker::MagneticTrackerSource>(tracker.options, std::move(*stream)));
  }
  return {};
}

Result<void> add_led_boards(const Config& config, Sources& sources) {
  for (const auto& board : config.led_boards) {
    auto stream = link::make_byte_stream(board.port);
    if (!stream) return stream.error();
    sources.sources.push_back(std::make_unique<led_sync::LedBoardSource>(board.options, std::move(*stream)));
  }
  return {};
}

Result<void> add_simulation(const SimulationConfig& simulation, const ImageStorageConfig& images, Sources& sources) {
  auto scene = load_scene(simulation.scene, simulation.seed);
  if (!scene) return scene.error();
  const auto rig = synthesis::SimulatedRig::create(*scene);
  if (!rig) return rig.error();
  std::set<std::string> cameras;
  for (std::size_t i = 0; i < scene->cameras.size(); ++i) cameras.insert("camera" + std::to_string(i));
  for (auto& source : rig->live_sources({.now = host_now})) {
    if (cameras.contains(source->name())) {
      add_camera(std::move(source), images, sources);
    } else {
      sources.sources.push_back(std::move(source));
    }
  }
  sources.first_actions = rig->targets();
  return {};
}

}  // namespace

Result<Sources> make_sources(const Config& config) {
  Sources sources;
  auto made =
      config.simulation ? add_simulation(*config.simulation, config.recording.images, sources) : add_cameras(config, sources);
  if (made) made = add_sonics(config, sources);
  if (made) made = add_magnetic_trackers(config, sources);
  if (made) made = add_led_boards(config, sources);
  if (!made) return made.error();
  if (sources.sources.empty()) {
    return Error{ErrorCode::invalid_argument,
                 "the configuration names no device: add a [[camera]], a [[sonic]], a [[magnetic_tracker]], an [[led_board]] "
                 "or a [simulation] "
                 "(config/reference.toml)"};
  }
  return sources;
}

}  // namespace roseau::daemon
