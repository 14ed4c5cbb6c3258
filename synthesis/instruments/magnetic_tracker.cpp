#include "synthesis/instruments/magnetic_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "drivers/wire/rotations.h"
#include "synthesis/instruments/rotation.h"

namespace roseau::synthesis {

namespace {

constexpr std::uint64_t kTimingStream = 2100;
constexpr std::uint64_t kNoiseStream = 2101;
constexpr std::uint64_t kLineStream = 2102;
constexpr std::uint64_t kErrorStream = 2104;
constexpr std::uint64_t kShiftStream = 2105;
constexpr std::uint64_t kTurnStream = 2106;
constexpr std::uint64_t kNoisesPerRecord = 6;

constexpr double kRadiansPerDegree = std::numbers::pi / 180;
constexpr std::uint16_t kLowSignal = 'k';
constexpr std::string_view kErrorLetters = "jkpuxy";  // saturation, low signal, norms, compensation, out of the box, envelope

// The tracker itself cannot name what is further away; reports stay readable.
constexpr double kFurthest_m = 5;

double growing(double size, double range_m, const MagneticTrackerOptions& options, double floor) {
  return std::max(floor, size * std::pow(range_m / options.noise_range_m, options.noise_exponent));
}

Quaternion unit(const Quaternion& q) {
  const double size = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / size, q.x / size, q.y / size, q.z / size};
}

wire::MagneticTrackerOptions wire_options(const MagneticTrackerOptions& options, const wire::FastrakFormat& format) {
  wire::MagneticTrackerOptions described;
  described.stations.resize(static_cast<std::size_t>(options.station_count));
  std::iota(described.stations.begin(), described.stations.end(), 1);
  described.layout = format.layout;
  described.is_binary = format.is_binary;
  described.unit = format.unit;
  described.delay_s = options.timing.latency_s;
  return described;
}

}  // namespace

MagneticTracker::SmoothField::SmoothField(double rms, double shortest_wavelength_m, RandomStream random)
    // Three components of kWaves sinusoids each: the vector's mean square is 3 kWaves amplitude^2 / 2.
    : amplitude_(rms / std::sqrt(1.5 * static_cast<double>(kWaves))) {
  std::uint64_t index = 0;
  for (auto& component : waves_) {
    for (Wave& wave : component) {
      const Vec3 direction{random.normal(index), random.normal(index + 1), random.normal(index + 2)};
      const double wavelength_m = shortest_wavelength_m * (1 + 2 * random.uniform(1000 + index));
      wave.turns_per_m = direction * (1 / (length(direction) * wavelength_m));
      wave.phase = random.uniform(2000 + index);
      index += 3;
    }
  }
}

double MagneticTracker::SmoothField::component_at(const std::array<Wave, kWaves>& waves, const Vec3& point) const {
  double sum = 0;
  for (const Wave& wave : waves) sum += std::sin(2 * std::numbers::pi * (dot(wave.turns_per_m, point) + wave.phase));
  return amplitude_ * sum;
}

Vec3 MagneticTracker::SmoothField::at(const Vec3& point) const {
  return {component_at(waves_[0], point), component_at(waves_[1], point), component_at(waves_[2], point)};
}

Result<std::shared_ptr<const MagneticTracker>> MagneticTracker::make(std::string name, const MagneticTrackerOptions& options,
                                                                     std::uint64_t seed,
                                                                     std::shared_ptr<const Surroundings> surroundings) {
  auto layout = wire::FastrakLayout::parse(options.items);
  if (!layout) return layout.error();
  const auto unit = wire::fastrak_unit_from_string(options.unit);
  if (!unit) return unit.error();
  if (options.station_count < 1 || options.station_count > wire::kFastrakStations) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("{}: station_count must be 1 to 4, not {}", name, options.station_count)};
  }
  return std::shared_ptr<const MagneticTracker>(new MagneticTracker(
      std::move(name), options, {std::move(*layout), options.is_binary, *unit}, seed, std::move(surroundings)));
}

MagneticTracker::MagneticTracker(std::string name, const MagneticTrackerOptions& options, wire::FastrakFormat format,
                                 std::uint64_t seed, std::shared_ptr<const Surroundings> surroundings)
    : name_(std::move(name)),
      options_(options),
      format_(std::move(format)),
      surroundings_(std::move(surroundings)),
      world_from_source_(wire::quaternion_from_angles_deg(options.source_angles_deg.x, options.source_angles_deg.y,
                                                          options.source_angles_deg.z)),
      times_(wire::kFastrakCycleHz, options.timing, seed, kTimingStream),
      line_{.baud = options.baud,
            .split_probability = options.split_probability,
            .byte_error_probability = options.byte_error_probability,
            .discards_when_busy = true},
      shift_(options.distortion_m, options.distortion_length_m, RandomStream(seed, kShiftStream)),
      turn_(options.distortion_deg * kRadiansPerDegree, options.distortion_length_m, RandomStream(seed, kTurnStream)),
      noise_(seed, kNoiseStream),
      errors_(seed, kErrorStream) {}

StreamInfo MagneticTracker::raw_stream(const std::string& link) const {
  return wire::raw_stream(name_, wire_options(options_, format_), link);
}

int MagneticTracker::station_of(std::uint64_t number) const {
  return 1 + static_cast<int>(number % static_cast<std::uint64_t>(options_.station_count));
}

double MagneticTracker::noise_m(double range_m) const {
  return growing(options_.noise_m, range_m, options_, options_.noise_floor_m);
}

double MagneticTracker::noise_deg(double range_m) const {
  return growing(options_.noise_deg, range_m, options_, options_.noise_floor_deg);
}

Vec3 MagneticTracker::distortion_m(const Vec3& position_in_source_m) const { return shift_.at(position_in_source_m); }

StationPose MagneticTracker::true_pose(int station, double time_s) const {
  const StationPlace place = surroundings_->station_place(static_cast<std::size_t>(station), time_s);
  const Quaternion source_from_world = conjugated(world_from_source_);
  return {.station = static_cast<std::uint8_t>(station),
          .position_in_source_m = rotated(source_from_world, place.position_in_world_m - options_.source_position_in_world_m),
          .source_from_station = source_from_world * place.world_from_station};
}

StationPose MagneticTracker::measure(std::uint64_t number) const {
  StationPose pose = true_pose(station_of(number), times_.sample_time_s(number));
  const Vec3 truth = pose.position_in_source_m;
  const double range_m = length(truth);
  const std::uint64_t first = number * kNoisesPerRecord;
  const auto random = [&](std::uint64_t index) {
    return Vec3{noise_.normal(first + index), noise_.normal(first + index + 1), noise_.normal(first + index + 2)};
  };
  Vec3 seen = truth + shift_.at(truth) + random(0) * noise_m(range_m);
  // A dipole's field is the same at opposite points: the tracker takes the one in its hemisphere.
  if (dot(seen, options_.hemisphere_in_source) < 0) seen = seen * -1.0;
  if (const double far = length(seen); far > kFurthest_m) seen = seen * (kFurthest_m / far);
  pose.position_in_source_m = seen;
  const Vec3 turn = turn_.at(truth) + random(3) * (noise_deg(range_m) * kRadiansPerDegree);
  pose.source_from_station = unit(quaternion_from_rotation_vector(turn) * pose.source_from_station);
  if (range_m > options_.range_m) {
    pose.device_status = kLowSignal;
  } else if (errors_.uniform(2 * number) < options_.error_probability) {
    pose.device_status = static_cast<std::uint8_t>(kErrorLetters[errors_.bits(2 * number + 1) % kErrorLetters.size()]);
  }
  pose.valid = pose.device_status == 0;
  return pose;
}

std::string MagneticTracker::record(std::uint64_t number, const wire::FastrakFormat& format) const {
  return wire::encode_fastrak(measure(number), format);
}

std::unique_ptr<SimulatedDevice> make_magnetic_tracker_device(std::shared_ptr<const MagneticTracker> tracker,
                                                              std::uint64_t seed) {
  return std::make_unique<SerialDevice>(std::move(tracker), seed, kLineStream);
}

}  // namespace roseau::synthesis
