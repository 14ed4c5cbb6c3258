#include "synthesis/instruments/device_timing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"

namespace roseau::synthesis {

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kFastestPerSlowest = 16;
constexpr double kPartsPerMillion = 1e-6;

// Random streams behind a device's own: far from the next device's.
constexpr std::uint64_t kWanderStream = 500'000;
constexpr std::uint64_t kSpikeStream = 500'001;
constexpr std::uint64_t kDropStream = 500'002;
constexpr std::uint64_t kStreamsPerDevice = 8;

std::uint64_t own_stream(std::uint64_t stream, std::uint64_t what) { return what + kStreamsPerDevice * stream; }

}  // namespace

SimulatedClock::SimulatedClock(const DeviceTiming& timing, std::uint64_t seed, std::uint64_t stream)
    : rate_(1 + timing.frequency_offset_ppm * kPartsPerMillion),
      start_offset_s_(timing.start_offset_s),
      counter_offset_s_(timing.counter_offset_s),
      wanders_(timing.wander_ppm > 0) {
  if (!wanders_) return;
  const RandomStream random(seed, own_stream(stream, kWanderStream));
  double power = 0;
  for (std::size_t i = 0; i < kWaves; ++i) {
    // Within its own share of the logarithmic axis each wave lies at random, so that they never fall into step.
    const double place = (static_cast<double>(i) + random.uniform(2 * i)) / static_cast<double>(kWaves);
    Wave& wave = waves_[i];
    wave.frequency_hz = std::pow(kFastestPerSlowest, place) / timing.wander_time_s;
    wave.fraction = 1 / std::sqrt(wave.frequency_hz);  // spectrum ~ f^-2, bandwidth of a wave ~ f
    wave.phase_rad = kTwoPi * random.uniform(2 * i + 1);
    power += wave.fraction * wave.fraction / 2;
  }
  for (Wave& wave : waves_) wave.fraction *= timing.wander_ppm * kPartsPerMillion / std::sqrt(power);
}

double SimulatedClock::wander_s(double time_s) const {
  if (!wanders_) return 0;
  double sum_s = 0;
  for (const Wave& wave : waves_) {
    const double turn_rad = kTwoPi * wave.frequency_hz;
    sum_s += wave.fraction / turn_rad * (std::sin(turn_rad * time_s + wave.phase_rad) - std::sin(wave.phase_rad));
  }
  return sum_s;
}

double SimulatedClock::device_time_s(double time_s) const {
  return counter_offset_s_ + (time_s - start_offset_s_) * rate_ + wander_s(time_s) - wander_s(start_offset_s_);
}

double SimulatedClock::time_of_s(double device_time_s) const {
  const double elapsed_s = device_time_s - counter_offset_s_;
  double time_s = start_offset_s_ + elapsed_s / rate_;
  if (!wanders_) return time_s;
  // A contraction by the wander's rate, some 1e-5: three steps leave nothing of it.
  const double start_wander_s = wander_s(start_offset_s_);
  for (int i = 0; i < 4; ++i) time_s = start_offset_s_ + (elapsed_s - wander_s(time_s) + start_wander_s) / rate_;
  return time_s;
}

double SimulatedClock::frequency_offset_ppm(double time_s) const {
  double fraction = rate_ - 1;
  if (wanders_) {
    for (const Wave& wave : waves_) fraction += wave.fraction * std::cos(kTwoPi * wave.frequency_hz * time_s + wave.phase_rad);
  }
  return fraction / kPartsPerMillion;
}

double SimulatedClock::allan_deviation(double averaging_s) const {
  if (!wanders_) return 0;
  double variance = 0;
  for (const Wave& wave : waves_) {
    const double half_turn_rad = std::numbers::pi * wave.frequency_hz * averaging_s;
    const double transfer = std::sin(half_turn_rad) * std::sin(half_turn_rad) / half_turn_rad;
    variance += wave.fraction * wave.fraction * transfer * transfer;
  }
  return std::sqrt(variance);
}

ClockState SimulatedClock::state(const std::string& device, HostTime start, double time_s) const {
  return {.device = device,
          .offset_s = to_seconds(start.time_since_epoch()) + time_s - device_time_s(time_s),
          .offset_sd_s = 0,
          .frequency_offset_ppm = frequency_offset_ppm(time_s)};
}

// ---------------------------------------------------------------------------------------------------------------------

SampleTimes::SampleTimes(double rate_hz, const DeviceTiming& timing, std::uint64_t seed, std::uint64_t stream)
    : rate_hz_(rate_hz),
      interval_s_(1 / (rate_hz * (1 + timing.frequency_offset_ppm * kPartsPerMillion))),
      timing_(timing),
      clock_(timing, seed, stream),
      delays_(seed, stream),
      spikes_(seed, own_stream(stream, kSpikeStream)),
      drops_(seed, own_stream(stream, kDropStream)) {
  ROSEAU_CHECK(timing.cable_pulls_s.size() % 2 == 0 && std::ranges::is_sorted(timing.cable_pulls_s));
  if (timing.drop_probability <= 0) return;
  const double burst = std::clamp(timing.drop_burst, 1.0, 100.0);
  burst_goes_on_ = 1 - 1 / burst;
  longest_burst_ = static_cast<std::uint64_t>(std::ceil(8 * burst));
  // A sample survives when no burst that began before it reaches it: exp(-begin * burst) for rare bursts.
  burst_probability_ = std::min(1.0, -std::log1p(-std::min(timing.drop_probability, 0.999)) / burst);
  if (burst == 1) burst_probability_ = std::min(1.0, timing.drop_probability);
}

double SampleTimes::sample_time_s(std::uint64_t number) const {
  if (timing_.wander_ppm > 0) return clock_.time_of_s(timing_.counter_offset_s + static_cast<double>(number) / rate_hz_);
  return timing_.start_offset_s + static_cast<double>(number) * interval_s_;
}

double SampleTimes::delay_s(std::uint64_t number) const {
  double delay_s = timing_.latency_s - timing_.jitter_s * std::log(delays_.uniform(number));
  if (spikes_.uniform(2 * number) < timing_.spike_probability) {
    delay_s -= timing_.spike_s * std::log(spikes_.uniform(2 * number + 1));
  }
  return delay_s;
}

bool SampleTimes::is_dropped(std::uint64_t number) const {
  if (burst_probability_ <= 0) return false;
  double reaches = 1;  // the chance of a burst to be longer than `back`
  for (std::uint64_t back = 0; back < longest_burst_ && back <= number; ++back) {
    // One number decides both whether a burst begins there and how long it is: below burst_probability * P(length > back).
    if (drops_.uniform(number - back) < burst_probability_ * reaches) return true;
    reaches *= burst_goes_on_;
  }
  return false;
}

std::uint64_t SampleTimes::first_from(double time_s) const {
  auto number = static_cast<std::uint64_t>(std::max(0.0, std::ceil((time_s - timing_.start_offset_s) / interval_s_)));
  if (timing_.wander_ppm <= 0) return number;
  while (number > 0 && sample_time_s(number - 1) >= time_s) --number;
  while (sample_time_s(number) < time_s) ++number;
  return number;
}

double SampleTimes::pulled_until_s(double time_s) const {
  const auto& pulls = timing_.cable_pulls_s;
  for (std::size_t i = 0; i + 1 < pulls.size(); i += 2) {
    if (time_s >= pulls[i] && time_s < pulls[i + 1]) return pulls[i + 1];
  }
  return time_s;
}

}  // namespace roseau::synthesis
