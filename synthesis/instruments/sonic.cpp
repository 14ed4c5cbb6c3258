#include "synthesis/instruments/sonic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/wire/anemometer.h"
#include "drivers/wire/wind_master.h"
#include "synthesis/instruments/rotation.h"

namespace roseau::synthesis {

namespace {

constexpr std::uint64_t kTimingStream = 2000;
constexpr std::uint64_t kNoiseStream = 2001;
constexpr std::uint64_t kLineStream = 2002;
constexpr std::uint64_t kFaultStream = 2004;
constexpr std::uint64_t kNoisesPerRecord = 4;

constexpr double kCelsiusPerMpsUp = 0.15;
constexpr double kRadiansPerDegree = std::numbers::pi / 180;

constexpr std::uint16_t kAllPathsFailed = 0x07;
constexpr std::uint16_t kLargestGain = 0x0A;
constexpr std::uint16_t kRetriesUsed = 0x0B;

// Three paths through the middle of the head, at 45 degrees to the horizontal, 120 degrees apart, the first towards the north
// mark: a1 + a2 + a3 = 2.1213 w, 2 a1 - a2 - a3 = 2.1213 u, a3 - a2 = 1.2247 v, as Gill's manuals have it.
const double kSlope = std::sqrt(0.5);
const std::array<Vec3, 3> kPaths = {Vec3{kSlope, 0, kSlope}, Vec3{-kSlope / 2, -kSlope* std::sqrt(0.75), kSlope},
                                    Vec3{-kSlope / 2, kSlope* std::sqrt(0.75), kSlope}};

// Columns: the head's axes (north mark, west of it, up) in the world. As level as it was meant to be, or as it stands.
Rotation world_from_head(const SonicOptions& options, Mounting mounting) {
  const double azimuth_rad = options.north_offset_deg * kRadiansPerDegree;
  const Rotation level{Vec3{std::sin(azimuth_rad), -std::cos(azimuth_rad), 0},
                       Vec3{std::cos(azimuth_rad), std::sin(azimuth_rad), 0}, Vec3{0, 0, 1}};
  if (mounting == Mounting::level) return level;
  return level * rotation_about_x(options.tilt_about_u_deg * kRadiansPerDegree) *
         rotation_about_y(options.tilt_about_v_deg * kRadiansPerDegree);
}

bool is_inside(const std::vector<double>& intervals, double time_s) {
  for (std::size_t i = 0; i + 1 < intervals.size(); i += 2) {
    if (time_s >= intervals[i] && time_s < intervals[i + 1]) return true;
  }
  return false;
}

}  // namespace

bool is_wind_master_rate(double rate_hz) {
  constexpr std::array kRates{1.0, 2.0, 4.0, 5.0, 8.0, 10.0, 16.0, 20.0, 32.0};
  return std::ranges::find(kRates, rate_hz) != kRates.end();
}

double air_temperature_celsius(const SonicOptions& options, double upwards_mps) {
  return options.air_temperature_celsius + kCelsiusPerMpsUp * upwards_mps;
}

// c^2 = 402.684 T, as NCAR NIDAS has it for sonics.
double speed_of_sound_mps(double sonic_temperature_celsius) {
  return std::sqrt(402.684 * (sonic_temperature_celsius + 273.15));
}

Vec3 wind_in_head_axes(const SonicOptions& options, const Vec3& wind_in_world_mps, Mounting mounting) {
  return transposed(world_from_head(options, mounting)) * wind_in_world_mps;
}

Sonic::Sonic(std::string name, const SonicOptions& options, std::uint64_t seed,
             std::shared_ptr<const Surroundings> surroundings)
    : name_(std::move(name)),
      options_(options),
      surroundings_(std::move(surroundings)),
      times_(options.rate_hz, options.timing, seed, kTimingStream),
      line_{.baud = options.baud,
            .split_probability = options.split_probability,
            .byte_error_probability = options.byte_error_probability},
      noise_(seed, kNoiseStream),
      faults_(seed, kFaultStream) {}

StreamInfo Sonic::raw_stream(const std::string& link) const {
  return wire::raw_stream(name_,
                          wire::AnemometerOptions{.model = wire::AnemometerModel::gill_windmaster,
                                                  .north_offset_deg = options_.north_offset_deg,
                                                  .rate_hz = options_.rate_hz,
                                                  .delay_s = options_.timing.latency_s},
                          link);
}

Vec3 Sonic::path_wind_mps(double time_s) const {
  const Vec3& middle = options_.position_in_world_m;
  const Rotation world_from_own = world_from_head(options_, Mounting::tilted);
  if (!options_.averages_paths) return transposed(world_from_own) * surroundings_->wind_mps(middle, time_s);
  std::array<double, 3> along{};
  for (std::size_t i = 0; i < kPaths.size(); ++i) {
    const Vec3 direction = world_from_own * kPaths[i];
    const Vec3 half = direction * (options_.path_length_m / 2);
    along[i] = dot(direction, surroundings_->path_mean_wind_mps(middle - half, middle + half, time_s));
  }
  const double sum = along[0] + along[1] + along[2];
  return {(3 * along[0] - sum) / (3 * kSlope), (along[2] - along[1]) / (std::sqrt(3.0) * kSlope), sum / (3 * kSlope)};
}

std::uint16_t Sonic::status(std::uint64_t number, double time_s, const Vec3& wind_mps) const {
  if (is_inside(options_.fault_intervals_s, time_s)) return kAllPathsFailed;
  if (std::max({std::abs(wind_mps.x), std::abs(wind_mps.y), std::abs(wind_mps.z)}) > options_.range_mps) return kAllPathsFailed;
  const double lot = faults_.uniform(2 * number);
  const std::uint64_t which = faults_.bits(2 * number + 1);
  // One path or two of the three: 01 to 06.
  if (lot < options_.fault_probability) return static_cast<std::uint16_t>(1 + which % 6);
  if (lot < options_.fault_probability + options_.marginal_probability) return which % 2 == 0 ? kLargestGain : kRetriesUsed;
  return 0;
}

WindSample Sonic::measure(std::uint64_t number) const {
  const double time_s = times_.sample_time_s(number);
  const Vec3 wind = path_wind_mps(time_s);
  const std::uint64_t first = number * kNoisesPerRecord;
  WindSample sample;
  sample.u_mps = wind.x + options_.noise_mps * noise_.normal(first);
  sample.v_mps = wind.y + options_.noise_mps * noise_.normal(first + 1);
  sample.w_mps = wind.z + options_.noise_mps * noise_.normal(first + 2);
  const double temperature_celsius = air_temperature_celsius(options_, wind.z);
  sample.speed_of_sound_mps = speed_of_sound_mps(temperature_celsius);
  sample.sonic_temperature_celsius = temperature_celsius + options_.temperature_noise_celsius * noise_.normal(first + 3);
  sample.device_status = status(number, time_s, wind);
  if (!wire::wind_master_status_is_good(sample.device_status)) {
    return WindSample{.device_status = sample.device_status, .valid = false};
  }
  return sample;
}

std::string Sonic::record(std::uint64_t number) const {
  const auto bytes = wire::encode_wind_master(measure(number), {.high_resolution = options_.high_resolution});
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::unique_ptr<SimulatedDevice> make_sonic_device(std::shared_ptr<const Sonic> sonic, std::uint64_t seed) {
  return std::make_unique<SerialDevice>(std::move(sonic), seed, kLineStream);
}

}  // namespace roseau::synthesis
