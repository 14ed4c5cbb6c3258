#include "estimation/estimation_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/sway_simulation.h"

namespace roseau::estimation {
namespace {

using testing::Sway;
using testing::SwayOptions;

struct Collector : SampleSink {
  std::vector<Sample> samples;
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
};

constexpr std::int64_t kBegin_ns = 5'000'000'000;

// A camera that sees one or more swaying targets, and a sonic mounted with its mark to 70 degrees.
class Field {
 public:
  explicit Field(EstimationOptions options = {}) : stage(streams, std::move(options)) {}

  StreamId stream(const std::string& topic, SampleKind kind) {
    StreamInfo info{topic, std::string(to_string(kind)), StreamRole::derived, topic.substr(1, topic.find('/', 1) - 1), {}};
    if (kind == SampleKind::wind) info.metadata["north_offset_deg"] = "70";
    return streams.add(std::move(info));
  }

  void displacement(const std::string& topic, double time_s, Vec2 at, bool valid = true) {
    Sample sample;
    sample.header.stream = stream(topic, SampleKind::displacement);
    sample.header.sample_time = time_at(time_s);
    sample.header.arrival_time = time_at(time_s + 0.02);
    Displacement displacement;
    displacement.x = at.x;
    displacement.y = at.y;
    displacement.valid = valid;
    sample.payload = displacement;
    stage.process(sample, out);
  }

  void wind(const std::string& topic, double time_s, double speed_mps, double from_deg, bool valid = true) {
    Sample sample;
    sample.header.stream = stream(topic, SampleKind::wind);
    sample.header.sample_time = time_at(time_s);
    const Vec2 seen = wind_components_mps(speed_mps, from_deg, 70);
    WindSample wind;
    wind.u_mps = seen.x;
    wind.v_mps = seen.y;
    wind.valid = valid;
    sample.payload = wind;
    stage.process(sample, out);
  }

  static HostTime time_at(double seconds) { return host_time_from_ns(kBegin_ns + std::llround(seconds * 1e9)); }
  static double seconds_of(const Sample& sample) {
    return static_cast<double>(to_ns(sample.header.sample_time) - kBegin_ns) * 1e-9;
  }

  template <class T>
  std::vector<std::pair<double, T>> results(const std::string& topic) const {
    std::vector<std::pair<double, T>> found;
    for (const Sample& sample : out.samples) {
      if (streams.info(sample.header.stream).topic != topic) continue;
      found.emplace_back(seconds_of(sample), std::get<T>(sample.payload));
    }
    return found;
  }

  StreamTable streams;
  EstimationStage stage;
  Collector out;
};

const std::string kTarget = "/camera0/target/branch";
constexpr double kFrom_deg = 310;

// Feeds frames [first, last) of a sway seen at a slant, and the wind that drives it.
void feed(Field& field, const Sway& sway, std::size_t first, std::size_t last, bool with_sonic = true,
          const std::string& target = kTarget) {
  for (std::size_t i = first; i < last; ++i) {
    const double time_s = static_cast<double>(i) * sway.sample_period_s;
    if (with_sonic) field.wind("/sonic/wind", time_s, sway.wind_mps[i], kFrom_deg);
    field.displacement(target + "/displacement", time_s, {0.8 * sway.displacement_px[i], 0.6 * sway.displacement_px[i]});
  }
}

TEST(EstimationTopics, FollowTheDisplacements) {
  EXPECT_EQ(result_topic("/camera0/target/branch/displacement", "wind"), "/camera0/target/branch/wind");
  EXPECT_EQ(result_topic("/displacement/tree14", "identification"), "/displacement/tree14/identification");
  EXPECT_TRUE(is_displacement_topic("/camera0/target/a/displacement"));
  EXPECT_TRUE(is_displacement_topic("/displacement/tree"));
  EXPECT_FALSE(is_displacement_topic("/truth/camera0/target/a/displacement"));
  EXPECT_FALSE(is_displacement_topic("/sonic/wind"));
}

TEST(EstimationStage, FindsTheTargetEarlySettlesAndFollowsTheWind) {
  SwayOptions options;
  options.duration_s = 300;
  const Sway sway = testing::simulate_sway(1, options);
  Field field;
  feed(field, sway, 0, sway.displacement_px.size());

  const auto identified = field.results<Identification>(kTarget + "/identification");
  ASSERT_FALSE(identified.empty());
  EXPECT_NEAR(identified.front().first, 15, 0.1);
  EXPECT_TRUE(identified.front().second.accepted);
  const Identification& last = identified.back().second;
  EXPECT_NEAR(last.natural_frequency_hz, 1, 3 * last.natural_frequency_sd_hz);
  EXPECT_NEAR(last.damping_ratio, 0.05, 3 * last.damping_ratio_sd);
  EXPECT_LT(last.damping_ratio_sd, 0.15 * 0.05);  // rests on far more than one window, which would give 0.21
  EXPECT_NEAR(last.axis.x, 0.8, 0.01);
  EXPECT_NEAR(last.window_s, 60, 0.5);

  const auto winds = field.results<WindEstimate>(kTarget + "/wind");
  ASSERT_GT(winds.size(), 8000U);
  EXPECT_LT(winds.front().first, 15.1);
  EXPECT_TRUE(winds.front().second.accepted);
  EXPECT_TRUE(winds.front().second.settling);
  EXPECT_FALSE(winds.front().second.scale_known);
  std::vector<double> estimate;
  std::vector<double> truth;
  std::vector<double> force;
  std::vector<double> true_force;
  for (const auto& [time_s, wind] : winds) {
    if (time_s > 60) {
      EXPECT_TRUE(wind.scale_known);
    }
    if (time_s < 120) continue;
    EXPECT_FALSE(wind.settling);
    const auto frame = static_cast<std::size_t>(std::llround(time_s / sway.sample_period_s));
    estimate.push_back(wind.wind_mps);
    truth.push_back(sway.wind_mps[frame]);
    force.push_back(wind.force_per_mass);
    true_force.push_back(sway.force[frame]);
  }
  const auto slow = [&](const std::vector<double>& series) {
    return testing::zero_phase_low_pass(series, sway.sample_period_s, 1);
  };
  EXPECT_GT(testing::correlation(slow(estimate), slow(truth)), 0.99);
  EXPECT_LT(testing::rms_difference(slow(estimate), slow(truth)), 0.2);
  EXPECT_GT(testing::correlation(slow(force), slow(true_force)), 0.99);

  const auto calibrations = field.results<WindCalibration>(kTarget + "/calibration");
  ASSERT_FALSE(calibrations.empty());
  const WindCalibration& calibration = calibrations.back().second;
  EXPECT_EQ(calibration.reference, "/sonic/wind");
  EXPECT_NEAR(calibration.direction_deg, kFrom_deg, 5);
  EXPECT_NEAR(calibration.exponent, 2, 0.15);
  EXPECT_GT(calibration.explained, 0.95);
  // a f + b with f in px/s^2: the published gain is about force per mass.
  const double drag = calibration.gain * winds.back().second.force_per_mass + calibration.offset;
  EXPECT_NEAR(signed_power(drag, 1 / calibration.exponent), winds.back().second.wind_mps, 0.3);

  const auto spectra = field.results<ForceSpectrum>(kTarget + "/spectrum");
  EXPECT_EQ(spectra.size(), identified.size());
  EXPECT_EQ(spectra.back().second.trust_low_hz, 0);
  EXPECT_GT(spectra.back().second.trust_high_hz, 1);
}

TEST(EstimationStage, HeadersTellWhenAndInWhichOrder) {
  SwayOptions options;
  options.duration_s = 40;
  const Sway sway = testing::simulate_sway(1, options);
  Field field;
  feed(field, sway, 0, sway.displacement_px.size());
  std::map<StreamId, std::uint32_t> next;
  double last_wind_s = 0;
  for (const Sample& sample : field.out.samples) {
    EXPECT_EQ(sample.header.sequence, next[sample.header.stream]++);
    EXPECT_EQ(field.streams.info(sample.header.stream).role, StreamRole::derived);
    if (field.streams.info(sample.header.stream).topic != kTarget + "/wind") continue;
    const double lag_s = std::get<WindEstimate>(sample.payload).lag_s;
    // Known when the frame `lag` later arrived (0.02 s after it was exposed).
    EXPECT_NEAR(static_cast<double>(to_ns(sample.header.arrival_time) - kBegin_ns) * 1e-9 - 0.02 - Field::seconds_of(sample),
                lag_s, 1e-3);
    EXPECT_GT(Field::seconds_of(sample), last_wind_s);
    last_wind_s = Field::seconds_of(sample);
  }
  EXPECT_NEAR(last_wind_s, 40, 0.6);
}

TEST(EstimationStage, LagFollowsTheFrequencyOrTheOption) {
  for (const double frequency_hz : {0.4, 0.7, 2.0}) {
    SwayOptions options;
    options.natural_frequency_hz = frequency_hz;
    options.duration_s = 60;
    const Sway sway = testing::simulate_sway(2, options);
    Field field;
    feed(field, sway, 0, sway.displacement_px.size());
    const auto winds = field.results<WindEstimate>(kTarget + "/wind");
    ASSERT_FALSE(winds.empty()) << frequency_hz;
    const double expected_s = frequency_hz >= 1 ? 0.25 : std::max(0.5, 0.25 / frequency_hz);
    EXPECT_NEAR(winds.back().second.lag_s, expected_s, 0.15 * expected_s) << frequency_hz;
    EstimationOptions fixed;
    fixed.lag_s = 0.1;
    Field other(fixed);
    feed(other, sway, 0, sway.displacement_px.size());
    EXPECT_NEAR(other.results<WindEstimate>(kTarget + "/wind").back().second.lag_s, 0.1, 1e-6);
  }
}

TEST(EstimationStage, WithoutAReferenceTheScaleIsOnlyStated) {
  SwayOptions options;
  options.duration_s = 60;
  const Sway sway = testing::simulate_sway(3, options);
  EstimationOptions estimation;
  estimation.uncalibrated_scale = 2;
  Field field(estimation);
  feed(field, sway, 0, sway.displacement_px.size(), false);
  const auto winds = field.results<WindEstimate>(kTarget + "/wind");
  ASSERT_FALSE(winds.empty());
  const WindEstimate& wind = winds.back().second;
  EXPECT_TRUE(wind.accepted);
  EXPECT_FALSE(wind.scale_known);
  const double w0 =
      2 * std::numbers::pi * field.results<Identification>(kTarget + "/identification").back().second.natural_frequency_hz;
  EXPECT_NEAR(wind.wind_mps, 2 * signed_power(wind.force_per_mass / (w0 * w0), 0.5), 0.05);
  EXPECT_TRUE(field.results<WindCalibration>(kTarget + "/calibration").empty());
  EXPECT_TRUE(field.results<WindEstimate>("/wind/estimate").empty());
}

TEST(EstimationStage, AFinalCalibrationNoLongerListensToTheReference) {
  SwayOptions options;
  options.duration_s = 120;
  const Sway sway = testing::simulate_sway(3, options);
  EstimationOptions estimation;
  estimation.calibration_final_after_s = 40;
  Field field(estimation);
  const std::size_t half = sway.displacement_px.size() / 2;
  feed(field, sway, 0, half);
  const auto before = field.results<WindCalibration>(kTarget + "/calibration");
  ASSERT_FALSE(before.empty());
  EXPECT_GE(before.back().second.seconds_used, 40);
  EXPECT_LT(before.back().second.seconds_used, 46);
  // The reference goes mad.
  for (std::size_t i = half; i < sway.displacement_px.size(); ++i) {
    field.wind("/sonic/wind", static_cast<double>(i) * sway.sample_period_s, 30, 100);
    feed(field, sway, i, i + 1, false);
  }
  EXPECT_EQ(field.results<WindCalibration>(kTarget + "/calibration").size(), before.size());
  EXPECT_TRUE(field.results<WindEstimate>(kTarget + "/wind").back().second.scale_known);
}

TEST(EstimationStage, TakesTheReferenceItIsTold) {
  SwayOptions options;
  options.duration_s = 60;
  const Sway sway = testing::simulate_sway(3, options);
  const auto run = [&](const std::string& wanted) {
    EstimationOptions estimation;
    estimation.reference_topic = wanted;
    Field field(estimation);
    for (std::size_t i = 0; i < sway.displacement_px.size(); ++i) {
      const double time_s = static_cast<double>(i) * sway.sample_period_s;
      field.wind("/truth/wind", time_s, sway.wind_mps[i], 100);
      field.wind("/sonic/wind", time_s, sway.wind_mps[i], kFrom_deg);
      field.wind("/sonic2/wind", time_s, sway.wind_mps[i], 20);
      feed(field, sway, i, i + 1, false);
    }
    return field.results<WindCalibration>(kTarget + "/calibration").back().second;
  };
  EXPECT_EQ(run("").reference, "/sonic/wind");
  EXPECT_EQ(run("/sonic2/wind").reference, "/sonic2/wind");
  EXPECT_NEAR(run("/sonic2/wind").direction_deg, 20, 6);
  EXPECT_EQ(run("/truth/wind").reference, "/truth/wind");
}

TEST(EstimationStage, BadWindIsNoReference) {
  Field field;
  for (int i = 0; i < 100; ++i) field.wind("/sonic/wind", 0.05 * i, 3, 20, false);
  EXPECT_TRUE(field.stage.reference_topic().empty());
  field.wind("/sonic/wind", 6, 3, 20);
  EXPECT_EQ(field.stage.reference_topic(), "/sonic/wind");
}

TEST(EstimationStage, ALostTargetGivesNoEstimateAndComesBackWithItsParameters) {
  SwayOptions options;
  options.duration_s = 120;
  const Sway sway = testing::simulate_sway(4, options);
  Field field;
  const auto is_lost = [](double time_s) { return (time_s > 70 && time_s < 80) || (time_s > 50 && time_s < 50.3); };
  for (std::size_t i = 0; i < sway.displacement_px.size(); ++i) {
    const double time_s = static_cast<double>(i) * sway.sample_period_s;
    // While it is lost the tracker repeats its last good value.
    field.displacement(kTarget + "/displacement", time_s, {is_lost(time_s) ? 3.0 : sway.displacement_px[i], 0},
                       !is_lost(time_s));
  }
  double first_after = 1e9;
  for (const auto& [time_s, wind] : field.results<WindEstimate>(kTarget + "/wind")) {
    EXPECT_FALSE(is_lost(time_s)) << time_s;
    if (time_s > 80) first_after = std::min(first_after, time_s);
    const auto frame = static_cast<std::size_t>(std::llround(time_s / sway.sample_period_s));
    if (time_s > 40) {
      EXPECT_NEAR(wind.force_per_mass, sway.force[frame], 0.5 * std::abs(sway.force[frame]) + 60) << time_s;
    }
  }
  // The filter runs in for five seconds; no new identification is waited for.
  EXPECT_LT(first_after, 87);
}

TEST(EstimationStage, AShortHoleLeavesAHoleNotASpike) {
  SwayOptions options;
  options.duration_s = 150;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Sway sway = testing::simulate_sway(seed, options);
    Field field;
    const auto is_missing = [](double time_s) { return time_s > 80 && std::fmod(time_s, 10) < 0.3; };
    for (std::size_t i = 0; i < sway.displacement_px.size(); ++i) {
      const double time_s = static_cast<double>(i) * sway.sample_period_s;
      field.wind("/sonic/wind", time_s, sway.wind_mps[i], kFrom_deg);
      if (!is_missing(time_s)) field.displacement(kTarget + "/displacement", time_s, {sway.displacement_px[i], 0});
    }
    double squares_before = 0;
    double squares_after = 0;
    int count_before = 0;
    int count_after = 0;
    for (const auto& [time_s, wind] : field.results<WindEstimate>(kTarget + "/wind")) {
      if (time_s < 60) continue;
      // The first samples behind a hole are news of the state, not of the force: nothing is claimed from them.
      const double behind_hole_s = std::fmod(time_s, 10) - 0.3;
      EXPECT_FALSE(time_s > 80 && behind_hole_s > -0.02 && behind_hole_s < 0.05) << time_s;
      const auto frame = static_cast<std::size_t>(std::llround(time_s / sway.sample_period_s));
      const double error = wind.force_per_mass - sway.force[frame];
      const bool near_a_hole = time_s > 80 && std::fmod(time_s, 10) < 2;
      (near_a_hole ? squares_after : squares_before) += error * error;
      ++(near_a_hole ? count_after : count_before);
    }
    EXPECT_GT(count_after, 100) << "it comes back";
    EXPECT_LT(std::sqrt(squares_after / count_after), 1.5 * std::sqrt(squares_before / count_before)) << "seed " << seed;
  }
}

TEST(EstimationStage, WhatDoesNotSwayIsNeverAccepted) {
  testing::GaussianSource random(8);
  Field field;
  for (int i = 0; i < 3600; ++i) {
    field.displacement(kTarget + "/displacement", i / 30.0, {0.2 * random.normal(), 0.2 * random.normal()});
    field.displacement("/camera0/target/still/displacement", i / 30.0, {1, 2});
  }
  const auto identified = field.results<Identification>(kTarget + "/identification");
  ASSERT_GT(identified.size(), 8U);
  for (const auto& [time_s, identification] : identified) EXPECT_FALSE(identification.accepted);
  EXPECT_TRUE(field.results<WindEstimate>(kTarget + "/wind").empty());
  for (const auto& [time_s, identification] : field.results<Identification>("/camera0/target/still/identification")) {
    EXPECT_FALSE(identification.accepted);
    EXPECT_TRUE(std::isnan(identification.natural_frequency_hz));
  }
}

TEST(EstimationStage, ParametersThatAreNoLongerConfirmedLoseTheirAcceptance) {
  SwayOptions options;
  options.duration_s = 60;
  const Sway sway = testing::simulate_sway(4, options);
  EstimationOptions estimation;
  estimation.hold_s = 30;
  Field field(estimation);
  feed(field, sway, 0, sway.displacement_px.size(), false);
  testing::GaussianSource random(1);
  for (int i = 1800; i < 5400; ++i) field.displacement(kTarget + "/displacement", i / 30.0, {8 + 0.3 * random.normal(), 6});
  const auto winds = field.results<WindEstimate>(kTarget + "/wind");
  for (const auto& [time_s, wind] : winds) {
    if (time_s >= 60) break;
    EXPECT_TRUE(wind.accepted);
  }
  EXPECT_GT(winds.back().first, 170);
  EXPECT_FALSE(winds.back().second.accepted);
}

TEST(EstimationStage, ASuddenFrequencyMustBeSeenTwice) {
  SwayOptions options;
  options.duration_s = 200;
  const Sway before = testing::simulate_sway(4, options);
  options.natural_frequency_hz = 1.6;
  const Sway after = testing::simulate_sway(4, options);
  EstimationOptions estimation;
  estimation.window_s = 40;
  Field field(estimation);
  feed(field, before, 0, 3000, false);
  feed(field, after, 3000, 6000, false);
  std::vector<bool> accepted;  // of the identifications that found the new frequency
  for (const auto& [time_s, identification] : field.results<Identification>(kTarget + "/identification")) {
    if (time_s > 100 && std::abs(identification.natural_frequency_hz - 1.6) < 0.15) accepted.push_back(identification.accepted);
  }
  ASSERT_GT(accepted.size(), 4U);
  EXPECT_FALSE(accepted.front());
  EXPECT_TRUE(accepted.back());
  const auto winds = field.results<WindEstimate>(kTarget + "/wind");
  EXPECT_NEAR(winds.back().second.force_per_mass, after.force[5990], 0.4 * std::abs(after.force[5990]));
}

TEST(EstimationStage, NotANumberIsAMissingSample) {
  SwayOptions options;
  options.duration_s = 40;
  const Sway sway = testing::simulate_sway(4, options);
  Field field;
  for (std::size_t i = 0; i < sway.displacement_px.size(); ++i) {
    const double x = i % 11 == 4 ? std::nan("") : sway.displacement_px[i];
    field.displacement(kTarget + "/displacement", static_cast<double>(i) * sway.sample_period_s, {x, 0});
  }
  const auto winds = field.results<WindEstimate>(kTarget + "/wind");
  ASSERT_GT(winds.size(), 600U);
  for (const auto& [time_s, wind] : winds) ASSERT_TRUE(std::isfinite(wind.wind_mps) && std::isfinite(wind.wind_sd_mps));
}

// The bits of everything that came out.
std::vector<double> bits(const Collector& out, std::size_t first = 0) {
  std::vector<double> result;
  for (std::size_t i = first; i < out.samples.size(); ++i) {
    const Sample& sample = out.samples[i];
    result.push_back(static_cast<double>(to_ns(sample.header.sample_time)));
    result.push_back(sample.header.sequence);
    if (const auto* wind = std::get_if<WindEstimate>(&sample.payload)) {
      result.insert(result.end(), {wind->wind_mps, wind->wind_sd_mps, wind->lag_s, wind->settling ? 1.0 : 0.0});
    } else if (const auto* identification = std::get_if<Identification>(&sample.payload)) {
      result.insert(result.end(),
                    {identification->natural_frequency_hz, identification->damping_ratio, identification->axis.x});
    } else if (const auto* calibration = std::get_if<WindCalibration>(&sample.payload)) {
      result.insert(result.end(), {calibration->gain, calibration->delay_s, calibration->seconds_used});
    } else if (const auto* spectrum = std::get_if<ForceSpectrum>(&sample.payload)) {
      for (const float power : spectrum->force_power) result.push_back(power);
    }
  }
  return result;
}

TEST(EstimationStage, ContinuesFromACheckpointWithTheSameBits) {
  SwayOptions options;
  options.duration_s = 100;
  const Sway sway = testing::simulate_sway(7, options);
  SwayOptions slower = options;
  slower.natural_frequency_hz = 0.6;
  const Sway second = testing::simulate_sway(7, slower);
  const auto feed_both = [&](Field& field, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      feed(field, sway, i, i + 1);
      feed(field, second, i, i + 1, false, "/camera1/target/top");
    }
  };
  // Before the rate is known; before the first identification; in mid-run.
  for (const std::size_t cut : {5U, 300U, 2000U}) {
    Field whole;
    feed_both(whole, 0, cut);
    const std::size_t before = whole.out.samples.size();
    std::vector<std::byte> state;
    whole.stage.save(state);
    feed_both(whole, cut, sway.displacement_px.size());

    Field resumed;
    resumed.stream("/another/topic/first", SampleKind::wind);  // stream numbers differ between sessions
    ASSERT_TRUE(resumed.stage.load(state));
    feed_both(resumed, cut, sway.displacement_px.size());
    EXPECT_EQ(bits(whole.out, before), bits(resumed.out)) << "cut at frame " << cut;

    std::vector<std::byte> again;
    Field copy;
    ASSERT_TRUE(copy.stage.load(state));
    copy.stage.save(again);
    EXPECT_EQ(state, again);
  }
}

TEST(EstimationStage, RefusesADamagedCheckpoint) {
  SwayOptions options;
  options.duration_s = 40;
  const Sway sway = testing::simulate_sway(7, options);
  Field field;
  feed(field, sway, 0, sway.displacement_px.size());
  std::vector<std::byte> state;
  field.stage.save(state);
  for (std::size_t size = 0; size < state.size(); size += 997) {
    Field other;
    const auto loaded = other.stage.load(std::span(state).first(size));
    ASSERT_FALSE(loaded);
    EXPECT_EQ(loaded.error().code, ErrorCode::corrupt);
  }
  state.push_back(std::byte{0});
  Field other;
  EXPECT_FALSE(other.stage.load(state));
  state.pop_back();
  state[0] = std::byte{99};
  EXPECT_THAT(other.stage.load(state).error().message, ::testing::HasSubstr("version"));
}

TEST(EstimationStage, ATargetPutElsewhereBeginsAnew) {
  SwayOptions options;
  options.duration_s = 60;
  const Sway sway = testing::simulate_sway(7, options);
  Field field;
  feed(field, sway, 0, 900);
  const auto count = field.results<WindEstimate>(kTarget + "/wind").size();
  EXPECT_GT(count, 300U);
  Sample action;
  action.header.stream = field.stream("/operator", SampleKind::operator_action);
  action.payload = OperatorAction{OperatorAction::Kind::add_target, "branch", "camera1", {}};
  field.stage.process(action, field.out);
  feed(field, sway, 900, 930);
  EXPECT_EQ(field.results<WindEstimate>(kTarget + "/wind").size(), count + 30);  // another camera's
  action.payload = OperatorAction{OperatorAction::Kind::add_target, "branch", "camera0", {}};
  field.stage.process(action, field.out);
  feed(field, sway, 930, 1200);
  EXPECT_EQ(field.results<WindEstimate>(kTarget + "/wind").size(), count + 30);
  feed(field, sway, 1200, 1800);
  EXPECT_GT(field.results<WindEstimate>(kTarget + "/wind").size(), count + 300);
}

TEST(EstimationStage, JoinsTargetsThatLookTheSameWay) {
  SwayOptions options;
  options.duration_s = 200;
  options.noise_px = 3;
  const Sway first = testing::simulate_sway(7, options);
  // The same air on a second oscillator seen by a camera half a frame later.
  const auto second = testing::oscillator_response(first.force, first.sample_period_s, 2 * std::numbers::pi * 0.6, 0.4);
  testing::GaussianSource random(5);
  Field field;
  for (std::size_t i = 0; i < first.displacement_px.size(); ++i) {
    const double time_s = static_cast<double>(i) * first.sample_period_s;
    feed(field, first, i, i + 1);
    field.displacement("/camera1/target/top/displacement", time_s + 0.4 / 30, {second[i] + 3 * random.normal(), 0});
  }
  const auto fused = field.results<WindEstimate>("/wind/estimate");
  ASSERT_GT(fused.size(), 4000U);
  const auto error_of = [&](const std::vector<std::pair<double, WindEstimate>>& winds) {
    double square = 0;
    int count = 0;
    for (const auto& [time_s, wind] : winds) {
      if (time_s < 100 || time_s > 190) continue;
      const auto frame = static_cast<std::size_t>(std::llround(time_s / first.sample_period_s));
      square += std::pow(wind.wind_mps - first.wind_mps[frame], 2);
      ++count;
    }
    return std::sqrt(square / count);
  };
  const double alone = error_of(field.results<WindEstimate>(kTarget + "/wind"));
  const double other = error_of(field.results<WindEstimate>("/camera1/target/top/wind"));
  EXPECT_LT(error_of(fused), std::max(alone, other));
  EXPECT_LT(error_of(fused), 1.05 * std::min(alone, other));
  EXPECT_TRUE(fused.back().second.accepted && fused.back().second.scale_known);
  EXPECT_TRUE(std::isnan(fused.back().second.force_per_mass));
  double last_s = 0;
  for (const auto& [time_s, wind] : fused) {
    EXPECT_GT(time_s, last_s);
    last_s = time_s;
  }
}

TEST(EstimationStage, ReportsIntervalsAtTheEnd) {
  SwayOptions options;
  options.duration_s = 150;
  const Sway sway = testing::simulate_sway(9, options);
  Field field;
  feed(field, sway, 0, sway.displacement_px.size());
  const auto calibrations = field.stage.calibrations(40);
  ASSERT_EQ(calibrations.size(), 1U);
  EXPECT_EQ(calibrations[0].topic, kTarget + "/displacement");
  ASSERT_TRUE(calibrations[0].fit.exponent_interval);
  EXPECT_LE(calibrations[0].fit.exponent_interval->low, calibrations[0].fit.exponent);
}

}  // namespace
}  // namespace roseau::estimation
