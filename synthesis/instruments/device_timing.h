// How a simulated device's own clock and its way to the host behave: offset, frequency offset, wander; latency, jitter, spikes;
// lost samples and pulled cables. Everything is a pure function of time or of a sample's number, so that devices can begin
// anywhere and the truth is known.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/random.h"
#include "core/sample.h"
#include "core/time.h"

namespace roseau::synthesis {

/// Times are seconds of the scene, which begins at 0.
struct DeviceTiming {
  double frequency_offset_ppm = 0;  // the device's clock is fast: it samples that much more often than it says
  double start_offset_s = 0;        // its first sample comes this long after the scene's start
  double latency_s = 0;             // from the sample time to the arrival at the host, at least
  double jitter_s = 0;              // mean of the random (exponential) delay on top of that

  double counter_offset_s = 0;        // what its counter shows at start_offset_s
  double wander_ppm = 0;              // standard deviation of its frequency's slow changes about the frequency offset
  double wander_time_s = 600;         // their longest period; the shortest is a sixteenth of it
  double spike_probability = 0;       // that a sample is held up on its way (a busy host, a USB hub)
  double spike_s = 0.1;               // mean of that further (exponential) delay
  double drop_probability = 0;        // share of samples that are lost
  double drop_burst = 1;              // mean number lost in a row, from 1 to 100
  std::vector<double> cable_pulls_s;  // from, to, from, to, ...: the device is gone; ascending
};

/// A device's clock. Thread-safe.
class SimulatedClock {
 public:
  /// `stream`: of the random numbers, the device's own.
  SimulatedClock(const DeviceTiming& timing, std::uint64_t seed, std::uint64_t stream);

  /// What the device's counter shows at a time of the scene, seconds.
  double device_time_s(double time_s) const;

  /// When it shows that: the inverse, to 1e-12 s.
  double time_of_s(double device_time_s) const;

  /// How much it runs fast at that time, wander included.
  double frequency_offset_ppm(double time_s) const;

  /// By how much its wander has put it ahead since the scene's start.
  double wander_s(double time_s) const;

  /// Two-sample (Allan) deviation of its frequency over an averaging time, as a fraction: what its wander amounts to.
  double allan_deviation(double averaging_s) const;

  /// The truth about it: offset_s = host - device. `start`: the host time at which the scene began.
  ClockState state(const std::string& device, HostTime start, double time_s) const;

 private:
  // Frequency changes as a sum of sinusoids, log-spaced in frequency and stronger the slower they are, as random-walk
  // frequency noise has it.
  struct Wave {
    double frequency_hz = 0;
    double fraction = 0;  // amplitude of the frequency's change
    double phase_rad = 0;
  };
  static constexpr std::size_t kWaves = 9;

  double rate_ = 1;  // device seconds per second, without wander
  double start_offset_s_ = 0;
  double counter_offset_s_ = 0;
  bool wanders_ = false;
  std::array<Wave, kWaves> waves_{};
};

/// Times of a device that samples at a steady rate on its own clock. Thread-safe.
class SampleTimes {
 public:
  /// `stream`: of the random numbers, the device's own.
  SampleTimes(double rate_hz, const DeviceTiming& timing, std::uint64_t seed, std::uint64_t stream);

  /// When sample `number` is taken, in the scene's time.
  double sample_time_s(std::uint64_t number) const;

  /// From the sample time to the arrival.
  double delay_s(std::uint64_t number) const;

  /// It never reaches the host (drop_probability).
  bool is_dropped(std::uint64_t number) const;

  /// First sample whose time is not before this.
  std::uint64_t first_from(double time_s) const;

  /// The cable is out at this time; then also until when.
  bool is_pulled(double time_s) const { return pulled_until_s(time_s) > time_s; }
  double pulled_until_s(double time_s) const;

  const SimulatedClock& clock() const { return clock_; }
  const DeviceTiming& timing() const { return timing_; }

 private:
  double rate_hz_;
  double interval_s_;
  DeviceTiming timing_;
  SimulatedClock clock_;
  RandomStream delays_;
  RandomStream spikes_;
  RandomStream drops_;
  double burst_probability_ = 0;  // that a burst of lost samples begins at a sample
  double burst_goes_on_ = 0;      // that it takes one more
  std::uint64_t longest_burst_ = 1;
};

}  // namespace roseau::synthesis
