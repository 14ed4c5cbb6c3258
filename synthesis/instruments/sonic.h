// A Gill WindMaster in the simulated field: the air along its three sound paths, with everything that goes wrong on the way to
// the host, as the bytes that the real one sends.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/sample.h"
#include "synthesis/instruments/device_timing.h"
#include "synthesis/instruments/serial_device.h"
#include "synthesis/instruments/surroundings.h"

namespace roseau::synthesis {

struct SonicOptions {
  Vec3 position_in_world_m{1.35, 0.1, 2.6};
  double north_offset_deg = 0;  // azimuth that the head's north mark points to, clockwise from true north
  double rate_hz = 20;          // one of the instrument's: 1, 2, 4, 5, 8, 10, 16, 20, 32
  double baud = 38400;          // 8N1
  double noise_mps = 0.02;      // standard deviation per component
  double air_temperature_celsius = 15;
  double temperature_noise_celsius = 0.02;
  double split_probability = 0.15;        // that a record arrives in two pieces
  bool averages_paths = true;             // false: measures at its position alone
  double path_length_m = 0.15;            // of each of the three sound paths, which cross in the head's middle
  double tilt_about_u_deg = 0;            // the head leans: turned about its north axis (u) ...
  double tilt_about_v_deg = 0;            // ... and about its west axis (v); the north offset says nothing of it
  double range_mps = 50;                  // faster air is not measured: status 07
  bool high_resolution = false;           // 0.001 m/s instead of 0.01
  double fault_probability = 0;           // that a record says that one or two paths failed, without values
  double marginal_probability = 0;        // that a record is good, but says that the signal was weak (0A, 0B)
  double byte_error_probability = 0;      // that one bit of a byte is turned over on the line
  std::vector<double> fault_intervals_s;  // from, to, ...: rain on the transducers, every path fails; ascending
  DeviceTiming timing{.latency_s = 0.05, .jitter_s = 0.0005};  // 0.05: one period of its internal sampling, as the real one
};

/// The rates that a WindMaster has.
bool is_wind_master_rate(double rate_hz);

/// Warm air rises, cool air sinks: sonic temperature of air that moves upwards this fast, degrees Celsius.
double air_temperature_celsius(const SonicOptions& options, double upwards_mps);
double speed_of_sound_mps(double sonic_temperature_celsius);

/// Air moving so in the world's axes, as a perfect instrument with this mounting shows it. `level`: as if it stood upright.
enum class Mounting : std::uint8_t { level, tilted };
Vec3 wind_in_head_axes(const SonicOptions& options, const Vec3& wind_in_world_mps, Mounting mounting);

class Sonic final : public SerialInstrument {
 public:
  /// `name`: becomes the first part of its topics.
  Sonic(std::string name, const SonicOptions& options, std::uint64_t seed, std::shared_ptr<const Surroundings> surroundings);

  const std::string& name() const override { return name_; }
  StreamInfo raw_stream(const std::string& link) const override;
  const SampleTimes& times() const override { return times_; }
  const SerialLineOptions& line() const override { return line_; }
  std::string record(std::uint64_t number) const override;

  /// What the instrument makes of the air for record `number`: noise and status included, rounding not.
  WindSample measure(std::uint64_t number) const;

  /// The same without noise and faults: what its paths see, in the axes of the head as it really stands.
  Vec3 path_wind_mps(double time_s) const;

 private:
  std::uint16_t status(std::uint64_t number, double time_s, const Vec3& wind_mps) const;

  std::string name_;
  SonicOptions options_;
  std::shared_ptr<const Surroundings> surroundings_;
  SampleTimes times_;
  SerialLineOptions line_;
  RandomStream noise_;
  RandomStream faults_;
};

/// Plays it. Stream: /<name>/raw.
std::unique_ptr<SimulatedDevice> make_sonic_device(std::shared_ptr<const Sonic> sonic, std::uint64_t seed);

}  // namespace roseau::synthesis
