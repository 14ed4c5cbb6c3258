#include "synthesis/rig/simulated_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace roseau::synthesis {

namespace {
constexpr double kIdentificationRateHz = 0.1;
constexpr double kSmallDeflection_m = 1e-3;  // the picture's displacement is linear in so small a one

DeviceTiming undelayed(const DeviceTiming& timing) {
  return {.frequency_offset_ppm = timing.frequency_offset_ppm, .start_offset_s = timing.start_offset_s};
}
}  // namespace

SimulatedTruth::SimulatedTruth(std::shared_ptr<const World> world)
    : world_(std::move(world)), branch_(world_->branch_motion()) {
  const Scene& scene = world_->scene;
  series_.push_back({Series::What::identification, 0, SampleTimes(kIdentificationRateHz, {}, scene.seed, 0)});
  series_.push_back({Series::What::wind, 0, SampleTimes(scene.truth.wind_rate_hz, {}, scene.seed, 0)});
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
    const CameraScene& camera = scene.cameras[i];
    series_.push_back({Series::What::camera, i, SampleTimes(camera.rate_hz, undelayed(camera.timing), scene.seed, 0)});
  }
}

void SimulatedTruth::declare(StreamTable& streams) {
  const auto add = [&](std::string topic, SampleKind kind) {
    StreamInfo info{.topic = std::move(topic), .kind = std::string(to_string(kind)), .device = name_};
    if (kind == SampleKind::wind) {
      info.metadata = {{"axes", "gill_spar"},
                       {"north_offset_deg", fmt::format("{}", world_->scene.sonic.north_offset_deg)},
                       {"rate_hz", fmt::format("{}", world_->scene.truth.wind_rate_hz)}};
    }
    return streams.add(std::move(info));
  };
  for (Series& series : series_) {
    switch (series.what) {
      case Series::What::identification:
        series.streams = {add("/truth/target/branch/identification", SampleKind::identification)};
        break;
      case Series::What::wind:
        series.streams = {add("/truth/wind", SampleKind::wind), add("/truth/sonic/wind", SampleKind::wind)};
        break;
      case Series::What::camera:
        series.streams = {
            add(fmt::format("/truth/camera{}/target/branch/displacement", series.camera), SampleKind::displacement),
            add(fmt::format("/truth/camera{}/target/branch/force", series.camera), SampleKind::wind_estimate)};
        break;
    }
  }
}

const SimulatedTruth::Series& SimulatedTruth::next_series() const {
  return *std::ranges::min_element(series_, {}, [](const Series& series) { return from_seconds(series.next_s()); });
}

Due SimulatedTruth::next() const {
  const Duration time = from_seconds(next_series().next_s());
  return {time, time};
}

bool SimulatedTruth::produce(HostTime start, SampleSink& sink) {
  Series& series = series_[static_cast<std::size_t>(&next_series() - series_.data())];
  emit(series, start + from_seconds(series.next_s()), sink);
  ++series.number;
  return true;
}

void SimulatedTruth::emit(const Series& series, HostTime time, SampleSink& sink) {
  const double time_s = series.next_s();
  const auto send = [&](std::size_t stream, Payload payload) {
    sink.receive({{.stream = series.streams.at(stream),
                   .sequence = static_cast<std::uint32_t>(series.number),
                   .arrival_time = time,
                   .sample_time = time},
                  std::move(payload)});
  };
  switch (series.what) {
    case Series::What::identification:
      send(0, identification());
      break;
    case Series::What::wind:
      send(0, world_->wind_in_sonic_axes(world_->drag_point, time_s));
      send(1, world_->wind_in_sonic_axes(world_->scene.sonic.position_in_world_m, time_s));
      break;
    case Series::What::camera:
      send(0, displacement(series.camera, branch_.deflection_m(time_s)));
      send(1, force(series.camera, time_s));
      break;
  }
}

Displacement SimulatedTruth::displacement(std::size_t camera, double deflection_m) const {
  const Scene& scene = world_->scene;
  const Vec2 moved = target_displacement_px(scene, scene.cameras[camera], deflection_m);
  return {.x = moved.x, .y = moved.y, .region = target_region(scene, scene.cameras[camera], deflection_m)};
}

WindEstimate SimulatedTruth::force(std::size_t camera, double time_s) const {
  const Scene& scene = world_->scene;
  const Vec2 small = target_displacement_px(scene, scene.cameras[camera], kSmallDeflection_m);
  const double px_per_m = std::hypot(small.x, small.y) / kSmallDeflection_m;
  return {.wind_mps = branch_.wind_along_axis_mps(time_s),
          .wind_sd_mps = 0,
          .force_per_mass = px_per_m * branch_.force_per_mass_mps2(time_s),
          .force_per_mass_sd = 0,
          .accepted = true,
          .settling = false,
          .scale_known = true};
}

Identification SimulatedTruth::identification() const {
  const Scene& scene = world_->scene;
  const Vec2 small = target_displacement_px(scene, scene.cameras.front(), kSmallDeflection_m);
  const double length = std::hypot(small.x, small.y);
  return {.natural_frequency_hz = scene.branch.natural_frequency_hz,
          .natural_frequency_sd_hz = 0,
          .damping_ratio = scene.branch.damping_ratio,
          .damping_ratio_sd = 0,
          .axis = {small.x / length, small.y / length},
          .accepted = true};
}

}  // namespace roseau::synthesis
