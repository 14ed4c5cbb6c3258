#include "synthesis/rig/simulated_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "synthesis/instruments/rotation.h"
#include "synthesis/instruments/sonic.h"
#include "synthesis/rig/tracker.h"

namespace roseau::synthesis {

namespace {

constexpr double kIdentificationRateHz = 0.1;
constexpr double kFastrakCycleHz = 120;
constexpr double kSmallDisplacement_m = 1e-3;  // the picture's displacement is linear in so small a one

}  // namespace

SimulatedTruth::SimulatedTruth(std::shared_ptr<const World> world) : world_(std::move(world)) {
  // The times are needed before streams have numbers: declare() makes the series anew with them.
  StreamTable scratch;
  declare(scratch);
}

StreamId SimulatedTruth::add(StreamTable& streams, std::string topic, SampleKind kind,
                             std::map<std::string, std::string> metadata) const {
  return streams.add(
      {.topic = std::move(topic), .kind = std::string(to_string(kind)), .device = name_, .metadata = std::move(metadata)});
}

void SimulatedTruth::declare(StreamTable& streams) {
  std::vector<std::uint64_t> numbers;
  for (const Series& series : series_) numbers.push_back(series.number);
  series_.clear();
  add_identifications(streams);
  add_winds(streams);
  for (std::size_t i = 0; i < world_->scene().cameras.size(); ++i) add_camera(streams, i);
  add_markers(streams);
  add_stations(streams);
  add_clocks(streams);
  for (std::size_t i = 0; i < numbers.size(); ++i) series_[i].number = numbers[i];  // reopened: it goes on
}

void SimulatedTruth::add_identifications(StreamTable& streams) {
  const World& world = *world_;
  std::vector<std::pair<StreamId, Identification>> found;
  for (const PlacedTarget& target : world.targets()) {
    const Vec2 moved = world.target_displacement_px(target, 0, target.axis * kSmallDisplacement_m);
    const double length = std::max(std::hypot(moved.x, moved.y), 1e-12);
    found.emplace_back(add(streams, fmt::format("/truth/target/{}/identification", target.name), SampleKind::identification),
                       Identification{.natural_frequency_hz = target.natural_frequency_hz,
                                      .natural_frequency_sd_hz = 0,
                                      .damping_ratio = target.damping_ratio,
                                      .damping_ratio_sd = 0,
                                      .axis = {moved.x / length, moved.y / length},
                                      .accepted = true});
  }
  series_.push_back(
      {SampleTimes(kIdentificationRateHz, {}, world.scene().seed, 0), [found = std::move(found)](double, const Send& send) {
         for (const auto& [stream, identification] : found) send(stream, identification);
       }});
}

void SimulatedTruth::add_winds(StreamTable& streams) {
  const Scene& scene = world_->scene();
  const auto metadata = [&scene](double rate_hz) {
    return std::map<std::string, std::string>{{"axes", "gill_spar"},
                                              {"north_offset_deg", fmt::format("{}", scene.sonic.north_offset_deg)},
                                              {"rate_hz", fmt::format("{}", rate_hz)}};
  };
  const StreamId here = add(streams, "/truth/wind", SampleKind::wind, metadata(scene.truth.wind_rate_hz));
  series_.push_back({SampleTimes(scene.truth.wind_rate_hz, {}, scene.seed, 0), [this, here](double time_s, const Send& send) {
                       send(here, world_->wind_in_sonic_axes(world_->wind_point(), time_s));
                     }});
  const StreamId sonic = add(streams, "/truth/sonic/wind", SampleKind::wind, metadata(scene.sonic.rate_hz));
  const Sonic instrument("sonic", scene.sonic, scene.seed, world_);
  series_.push_back({instrument.times(), [this, sonic](double time_s, const Send& send) {
                       send(sonic, world_->wind_in_sonic_axes(world_->scene().sonic.position_in_world_m, time_s));
                     }});
}

void SimulatedTruth::add_camera(StreamTable& streams, std::size_t camera) {
  struct Streams {
    StreamId displacement;
    StreamId force;
  };
  std::vector<Streams> of_targets;
  for (const PlacedTarget& target : world_->targets()) {
    const std::string prefix = fmt::format("/truth/camera{}/target/{}", camera, target.name);
    of_targets.push_back({add(streams, prefix + "/displacement", SampleKind::displacement),
                          add(streams, prefix + "/force", SampleKind::wind_estimate)});
  }
  const StreamId exposure = add(streams, fmt::format("/truth/camera{}/exposure", camera), SampleKind::clock_state,
                                {{"rate_hz", fmt::format("{}", world_->scene().cameras[camera].rate_hz)}});
  series_.push_back(
      {world_->camera_times(camera),
       [this, camera, exposure, of_targets, clock = world_->camera_times(camera).clock()](double time_s, const Send& send) {
         send(exposure, clock.state(fmt::format("camera{}", camera), start_, time_s));
         world_->tree_motion().amplitudes(time_s, amplitudes_);
         for (std::size_t i = 0; i < of_targets.size(); ++i) {
           const PlacedTarget& target = world_->targets()[i];
           const Vec3 moved_m = target.displacement_m(amplitudes_);
           const Vec2 moved_px = world_->target_displacement_px(target, camera, moved_m);
           send(of_targets[i].displacement,
                Displacement{.x = moved_px.x, .y = moved_px.y, .region = world_->target_region(target, camera, moved_m)});
           send(of_targets[i].force, force(target, camera, time_s));
         }
       }});
}

void SimulatedTruth::add_markers(StreamTable& streams) {
  const Scene& scene = world_->scene();
  const StreamId tree = add(streams, "/truth/tree", SampleKind::modal_state);
  const StreamId balls_stream = add(streams, "/truth/balls", SampleKind::marker_positions);
  const StreamId rig = world_->bar_rig() ? add(streams, "/truth/bar_rig", SampleKind::marker_positions) : StreamId{0};
  series_.push_back({SampleTimes(scene.truth.marker_rate_hz, {}, scene.seed, 0),
                     [this, tree, balls_stream, rig](double time_s, const Send& send) {
                       send(tree, modes(time_s));
                       if (!world_->balls().empty()) send(balls_stream, balls(time_s));
                       if (!world_->bar_rig()) return;
                       MarkerPositions targets;
                       const auto places = world_->bar_rig()->targets_in_world_m(time_s);
                       for (std::size_t i = 0; i < places.size(); ++i) {
                         targets.markers.push_back(
                             {.name = std::string(BarRigMotion::kNames.at(i)), .position_m = places.at(i)});
                       }
                       send(rig, std::move(targets));
                     }});
}

void SimulatedTruth::add_stations(StreamTable& streams) {
  const auto tracker = make_tracker(world_);
  if (!tracker) return;
  std::vector<StreamId> stations;
  for (int station = 1; station <= tracker->station_count(); ++station) {
    stations.push_back(add(streams, fmt::format("/truth/tracker/station{}/pose", station), SampleKind::station_pose,
                           {{"rate_hz", fmt::format("{}", kFastrakCycleHz / tracker->station_count())}}));
  }
  // One record after the other, a station each.
  series_.push_back({tracker->times(), [stations, tracker, number = std::uint64_t{0}](double time_s, const Send& send) mutable {
                       const int station = tracker->station_of(number++);
                       send(stations.at(static_cast<std::size_t>(station - 1)), tracker->true_pose(station, time_s));
                     }});
}

void SimulatedTruth::add_clocks(StreamTable& streams) {
  struct Clock {
    StreamId stream;
    std::string device;
    SimulatedClock clock;
  };
  std::vector<Clock> clocks;
  const auto add_clock = [&](const std::string& device, const SimulatedClock& clock) {
    clocks.push_back({add(streams, fmt::format("/truth/{}/clock", device), SampleKind::clock_state), device, clock});
  };
  const Scene& scene = world_->scene();
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) add_clock(fmt::format("camera{}", i), world_->camera_times(i).clock());
  add_clock("sonic", Sonic("sonic", scene.sonic, scene.seed, world_).times().clock());
  if (const auto tracker = make_tracker(world_)) add_clock("tracker", tracker->times().clock());
  if (world_->led_board() != nullptr) add_clock("led_board", world_->led_board()->clock());
  series_.push_back({SampleTimes(1, {}, scene.seed, 0), [this, clocks = std::move(clocks)](double time_s, const Send& send) {
                       for (const Clock& clock : clocks) send(clock.stream, clock.clock.state(clock.device, start_, time_s));
                     }});
}

MarkerPositions SimulatedTruth::balls(double time_s) {
  world_->tree_motion().amplitudes(time_s, amplitudes_);
  MarkerPositions positions;
  for (std::size_t i = 0; i < world_->balls().size(); ++i) {
    positions.markers.push_back({.name = world_->balls()[i].name, .position_m = world_->ball_in_world_m(i, amplitudes_)});
  }
  return positions;
}

ModalState SimulatedTruth::modes(double time_s) {
  const structure::ModalModel& model = world_->tree_motion().model();
  world_->tree_motion().amplitudes(time_s, amplitudes_);
  world_->tree_motion().forces(time_s, forces_);
  ModalState state{.structure = "tree"};
  for (std::size_t mode = 0; mode < model.mode_count(); ++mode) {
    state.natural_frequency_hz.push_back(model.natural_frequency_hz(mode));
    state.damping_ratio.push_back(model.damping_ratio(mode));
    state.amplitude.push_back(amplitudes_[static_cast<Eigen::Index>(mode)]);
    state.modal_force.push_back(forces_[static_cast<Eigen::Index>(mode)]);
  }
  return state;
}

WindEstimate SimulatedTruth::force(const PlacedTarget& target, std::size_t camera, double time_s) {
  const structure::ModalModel& model = world_->tree_motion().model();
  world_->tree_motion().forces(time_s, forces_);
  const Vec3 held_m = target.displacement_m(model.static_amplitudes(forces_));
  const Vec2 moved = world_->target_displacement_px(target, camera, target.axis * kSmallDisplacement_m);
  const double px_per_m = std::hypot(moved.x, moved.y) / kSmallDisplacement_m;
  const double w0 = 2 * M_PI * target.natural_frequency_hz;
  return {.wind_mps = dot(world_->wind().velocity_mps(world_->wind_point(), time_s), target.axis),
          .wind_sd_mps = 0,
          .force_per_mass = w0 * w0 * px_per_m * dot(held_m, target.axis),
          .force_per_mass_sd = 0,
          .accepted = true,
          .settling = false,
          .scale_known = true};
}

const SimulatedTruth::Series& SimulatedTruth::next_series() const {
  return *std::ranges::min_element(series_, {}, [](const Series& series) { return from_seconds(series.next_s()); });
}

Due SimulatedTruth::next() const {
  const Duration time = from_seconds(next_series().next_s());
  return {time, time};
}

bool SimulatedTruth::produce(HostTime start, SampleSink& sink) {
  start_ = start;
  Series& series = series_[static_cast<std::size_t>(&next_series() - series_.data())];
  const HostTime time = start + from_seconds(series.next_s());
  series.emit(series.next_s(), [&](StreamId stream, Payload payload) {
    sink.receive(
        {{.stream = stream, .sequence = static_cast<std::uint32_t>(series.number), .arrival_time = time, .sample_time = time},
         std::move(payload)});
  });
  ++series.number;
  return true;
}

}  // namespace roseau::synthesis
