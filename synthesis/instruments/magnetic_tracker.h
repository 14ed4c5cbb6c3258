// A Polhemus FASTRAK in the simulated field: up to four stations, sampled one after the other in a cycle of 120 Hz, each
// seen through noise that grows with its distance from the source, space that metal has distorted, and the hemisphere that
// the tracker believes them in; as the bytes that the real one sends.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "core/geometry.h"
#include "core/sample.h"
#include "drivers/wire/magnetic_tracker.h"
#include "synthesis/instruments/device_timing.h"
#include "synthesis/instruments/serial_device.h"
#include "synthesis/instruments/surroundings.h"

namespace roseau::synthesis {

struct MagneticTrackerOptions {
  std::int64_t station_count = 4;  // 1 to 4: stations 1 to this many, each 120 / count times a second
  Vec3 source_position_in_world_m{0, -0.8, 1.5};
  Vec3 source_angles_deg{0, 0, 0};  // azimuth, elevation, roll that turn the world's axes into the source's
  bool is_binary = true;            // else text
  std::string items = "2,11,0";     // what a record holds: the tracker's command O (text as delivered: 2,4,1)
  std::string unit = "cm";          // or "inch"
  double baud = 115200;             // 8N1
  double noise_m = 0.0008;          // standard deviation per axis at noise_range_m from the source ...
  double noise_deg = 0.15;          // ... and of the orientation about each axis
  double noise_range_m = 0.76;
  double noise_exponent = 4;       // noise ~ range^exponent
  double noise_floor_m = 0.00005;  // the least, close to the source
  double noise_floor_deg = 0.01;
  double distortion_m = 0;             // root mean square of how far metal shifts positions: smooth in space, constant in time
  double distortion_deg = 0;           // and of how far it turns orientations
  double distortion_length_m = 1.5;    // how far apart the distortion is another: its shortest wavelength
  double range_m = 3;                  // further away: error letter k (low signal)
  Vec3 hemisphere_in_source{0, 0, 1};  // the half of space that the tracker takes all stations to be in
  double error_probability = 0;        // that a record has an error letter
  double split_probability = 0.15;     // that a record arrives in two pieces
  double byte_error_probability = 0;
  DeviceTiming timing{.latency_s = wire::kFastrakDelay_s, .jitter_s = 0.0003};
};

class MagneticTracker final : public SerialInstrument {
 public:
  /// Errors: items or unit that the tracker does not know, a station count that it does not have.
  static Result<std::shared_ptr<const MagneticTracker>> make(std::string name, const MagneticTrackerOptions& options,
                                                             std::uint64_t seed,
                                                             std::shared_ptr<const Surroundings> surroundings);

  const std::string& name() const override { return name_; }
  StreamInfo raw_stream(const std::string& link) const override;
  const SampleTimes& times() const override { return times_; }
  const SerialLineOptions& line() const override { return line_; }
  std::string record(std::uint64_t number) const override { return record(number, format_); }

  /// The record as a tracker set up otherwise would send it.
  std::string record(std::uint64_t number, const wire::FastrakFormat& format) const;
  const wire::FastrakFormat& format() const { return format_; }

  int station_of(std::uint64_t number) const;
  int station_count() const { return static_cast<int>(options_.station_count); }

  /// What the tracker makes of record `number`; rounding not included.
  StationPose measure(std::uint64_t number) const;

  /// Where the station truly is, in the axes of the source.
  StationPose true_pose(int station, double time_s) const;

  /// How far metal shifts a position in the source's axes.
  Vec3 distortion_m(const Vec3& position_in_source_m) const;

  /// Standard deviation per axis at this distance from the source.
  double noise_m(double range_m) const;
  double noise_deg(double range_m) const;

 private:
  // A smooth vector field: a few waves per component, of random direction and phase.
  class SmoothField {
   public:
    SmoothField(double rms, double shortest_wavelength_m, RandomStream random);
    Vec3 at(const Vec3& point) const;

   private:
    struct Wave {
      Vec3 turns_per_m;
      double phase = 0;
    };
    static constexpr std::size_t kWaves = 4;
    double component_at(const std::array<Wave, kWaves>& waves, const Vec3& point) const;
    double amplitude_ = 0;
    std::array<std::array<Wave, kWaves>, 3> waves_{};
  };

  MagneticTracker(std::string name, const MagneticTrackerOptions& options, wire::FastrakFormat format, std::uint64_t seed,
                  std::shared_ptr<const Surroundings> surroundings);

  std::string name_;
  MagneticTrackerOptions options_;
  wire::FastrakFormat format_;
  std::shared_ptr<const Surroundings> surroundings_;
  Quaternion world_from_source_;
  SampleTimes times_;
  SerialLineOptions line_;
  SmoothField shift_;
  SmoothField turn_;
  RandomStream noise_;
  RandomStream errors_;
};

/// Plays it. Stream: /<name>/raw. A record that the line has no time for is lost, as the tracker loses it.
std::unique_ptr<SimulatedDevice> make_magnetic_tracker_device(std::shared_ptr<const MagneticTracker> tracker,
                                                              std::uint64_t seed);

}  // namespace roseau::synthesis
