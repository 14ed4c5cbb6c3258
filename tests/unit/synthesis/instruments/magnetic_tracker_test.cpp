#include "synthesis/instruments/magnetic_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "synthesis/instruments/rotation.h"
#include "tests/unit/synthesis/instruments/simulated_field.h"

namespace roseau::synthesis {
namespace {

constexpr double kRadian = std::numbers::pi / 180;

MagneticTrackerOptions quiet() {
  MagneticTrackerOptions options;
  options.source_position_in_world_m = {0, 0, 0};
  options.noise_m = options.noise_deg = options.noise_floor_m = options.noise_floor_deg = 0;
  options.timing = {.latency_s = wire::kFastrakDelay_s};
  return options;
}

std::shared_ptr<const MagneticTracker> tracker_of(const MagneticTrackerOptions& options,
                                                  std::function<StationPlace(std::size_t, double)> place) {
  auto field = std::make_shared<TestField>();
  field->place = std::move(place);
  auto tracker = MagneticTracker::make("tracker", options, 1, field);
  EXPECT_TRUE(tracker) << tracker.error().message;
  return *tracker;
}

StationPlace at(const Vec3& position) { return {position, {1, 0, 0, 0}}; }

TEST(MagneticTracker, PosesAreInTheAxesOfTheSource) {
  MagneticTrackerOptions options = quiet();
  options.source_position_in_world_m = {1, 2, 3};
  options.source_angles_deg = {90, 0, 0};  // its x axis points north
  const auto tracker = tracker_of(options, [](std::size_t, double) {
    return StationPlace{{1, 2.5, 3.25}, {std::cos(45 * kRadian), 0, 0, std::sin(45 * kRadian)}};
  });
  const StationPose pose = tracker->true_pose(1, 0);
  EXPECT_NEAR(pose.position_in_source_m.x, 0.5, 1e-12);
  EXPECT_NEAR(pose.position_in_source_m.y, 0, 1e-12);
  EXPECT_NEAR(pose.position_in_source_m.z, 0.25, 1e-12);
  EXPECT_NEAR(std::abs(pose.source_from_station.w), 1, 1e-12) << "turned as the source is: no rotation between them";
}

struct Form {
  bool is_binary;
  const char* items;
  const char* unit;
  double tolerance_m;
};
void PrintTo(const Form& form, std::ostream* out) { *out << form.items << " in " << form.unit; }

class Forms : public ::testing::TestWithParam<Form> {};

TEST_P(Forms, BytesDecodeToWhereTheStationsWere) {
  MagneticTrackerOptions options = quiet();
  options.is_binary = GetParam().is_binary;
  options.items = GetParam().items;
  options.unit = GetParam().unit;
  options.baud = 230400;  // so that the longest fits the cycle, too
  const auto place = [](std::size_t station, double t) {
    return StationPlace{{0.2 * static_cast<double>(station), 0.1 * std::sin(2 * t), 0.5 + 0.05 * std::cos(t)},
                        quaternion_from_rotation_vector({0.3 * std::sin(t), 0.2, -0.4 * t})};
  };
  auto device = make_magnetic_tracker_device(tracker_of(options, place), 1);
  const auto decoded = play_and_decode(*device, 10);
  EXPECT_EQ(decoded->counters.bad_records, 0U);
  EXPECT_EQ(decoded->counters.skipped_bytes, 0U);
  ASSERT_NEAR(static_cast<double>(decoded->samples.size()), 1200, 1);
  for (std::size_t i = 0; i < decoded->samples.size(); ++i) {
    const Sample& sample = decoded->samples[i];
    const auto& pose = std::get<StationPose>(sample.payload);
    ASSERT_EQ(pose.station, 1 + i % 4) << "one after the other";
    EXPECT_EQ(decoded->topic(sample), "/tracker/station" + std::to_string(pose.station) + "/pose");
    const double t = to_seconds(sample.header.sample_time - kSceneStart);
    EXPECT_NEAR(t, static_cast<double>(i) / 120, 2e-9) << "less the tracker's own delay";
    const StationPlace truth = place(pose.station, t);
    EXPECT_NEAR(length(pose.position_in_source_m - truth.position_in_world_m), 0, GetParam().tolerance_m);
    const Quaternion turn = conjugated(truth.world_from_station) * pose.source_from_station;
    EXPECT_NEAR(std::abs(turn.w), 1, 1e-7);
  }
}
INSTANTIATE_TEST_SUITE_P(All, Forms,
                         ::testing::Values(Form{true, "2,11,0", "cm", 1e-6}, Form{true, "2,11,0", "inch", 1e-6},
                                           Form{false, "2,4,1", "cm", 1e-4}, Form{false, "52,61,1", "inch", 1e-5}));

TEST(MagneticTracker, ASlowLineLosesRecordsAndKeepsTheirOrder) {
  // 47 bytes take 12.2 ms at 38400 baud and the cycle has 8.3: every other solution is lost, as the manual says.
  MagneticTrackerOptions options = quiet();
  options.is_binary = false;
  options.items = "2,4,1";
  options.baud = 38400;
  options.station_count = 3;
  auto device = make_magnetic_tracker_device(tracker_of(options, [](std::size_t, double) { return at({0, 0, 0.5}); }), 1);
  const auto decoded = play_and_decode(*device, 10);
  EXPECT_NEAR(static_cast<double>(decoded->samples.size()), 600, 2);
  EXPECT_EQ(decoded->counters.bad_records, 0U);
}

double measured_noise_m(const MagneticTracker& tracker, const Vec3& truth) {
  double sum = 0;
  constexpr int kRecords = 4000;
  for (std::uint64_t i = 0; i < kRecords; ++i) {
    const Vec3 error = tracker.measure(i).position_in_source_m - truth;
    sum += dot(error, error) / 3;
  }
  return std::sqrt(sum / kRecords);
}

TEST(MagneticTracker, NoiseGrowsWithTheFourthPowerOfTheRange) {
  MagneticTrackerOptions options = quiet();
  options.noise_m = 0.0008;
  options.noise_deg = 0.15;
  const auto noise_at = [&](double range_m) {
    return measured_noise_m(*tracker_of(options, [=](std::size_t, double) { return at({0, 0, range_m}); }), {0, 0, range_m});
  };
  EXPECT_NEAR(noise_at(0.76), 0.0008, 0.00003);
  EXPECT_NEAR(noise_at(1.52), 0.0128, 0.0004);
  const auto tracker = tracker_of(options, [](std::size_t, double) { return at({0, 0, 0.76}); });
  double sum = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) sum += std::pow(2 * tracker->measure(i).source_from_station.x / kRadian, 2);
  EXPECT_NEAR(std::sqrt(sum / 4000), 0.15, 0.006);
}

TEST(MagneticTracker, CloseToTheSourceSomeNoiseIsLeft) {
  MagneticTrackerOptions options;
  options.source_position_in_world_m = {0, 0, 0};
  const auto tracker = tracker_of(options, [](std::size_t, double) { return at({0, 0, 0.1}); });
  EXPECT_NEAR(measured_noise_m(*tracker, {0, 0, 0.1}), 0.00005, 0.000003);
}

TEST(MagneticTracker, DistortionIsSmoothConstantAndAsLargeAsStated) {
  MagneticTrackerOptions options = quiet();
  options.distortion_m = 0.02;
  const auto tracker = tracker_of(options, [](std::size_t, double t) { return at({0.3, 0.1 + 0 * t, 0.4}); });
  double sum = 0;
  int count = 0;
  double steepest = 0;
  for (double x = -6; x < 6; x += 0.4) {
    for (double y = -6; y < 6; y += 0.4) {
      for (double z = 0; z < 6; z += 0.4, ++count) {
        const Vec3 shift = tracker->distortion_m({x, y, z});
        sum += dot(shift, shift);
        steepest = std::max(steepest, length(tracker->distortion_m({x + 0.01, y, z}) - shift) / 0.01);
      }
    }
  }
  EXPECT_NEAR(std::sqrt(sum / count), 0.02, 0.003);
  // A wave of amplitude a and length L is at most 2 pi a / L steep.
  EXPECT_LT(steepest, 2 * std::numbers::pi * 0.02 * std::sqrt(6.0) / 1.5);
  const Vec3 early = tracker->measure(0).position_in_source_m;
  const Vec3 late = tracker->measure(120'000).position_in_source_m;
  EXPECT_EQ(early.x, late.x);
  EXPECT_GT(length(early - Vec3{0.3, 0.1, 0.4}), 0.001);
}

TEST(MagneticTracker, TheWrongHemisphereMirrorsPositions) {
  MagneticTrackerOptions options = quiet();
  options.hemisphere_in_source = {1, 0, 0};
  const auto tracker = tracker_of(options, [](std::size_t, double) { return at({-0.3, 0.1, 0.4}); });
  const Vec3 seen = tracker->measure(0).position_in_source_m;
  EXPECT_NEAR(seen.x, 0.3, 1e-12);
  EXPECT_NEAR(seen.y, -0.1, 1e-12);
  EXPECT_NEAR(seen.z, -0.4, 1e-12);
}

TEST(MagneticTracker, BeyondItsRangeItComplains) {
  const auto tracker = tracker_of(quiet(), [](std::size_t station, double) { return at({0, 0, station == 2 ? 3.5 : 2.5}); });
  EXPECT_TRUE(tracker->measure(0).valid);
  const StationPose far = tracker->measure(1);
  EXPECT_FALSE(far.valid);
  EXPECT_EQ(far.device_status, 'k');
  MagneticTrackerOptions options = quiet();
  options.error_probability = 0.1;
  const auto troubled = tracker_of(options, [](std::size_t, double) { return at({0, 0, 1}); });
  int errors = 0;
  for (std::uint64_t i = 0; i < 5000; ++i) errors += troubled->measure(i).valid ? 0 : 1;
  EXPECT_NEAR(errors, 500, 80);
}

TEST(MagneticTracker, AStationOutOfThisWorldStillGivesARecord) {
  const auto tracker = tracker_of(quiet(), [](std::size_t, double) { return at({0, 0, 1000}); });
  EXPECT_EQ(tracker->record(0).size(), 32U);
  auto device = make_magnetic_tracker_device(tracker, 1);
  const auto decoded = play_and_decode(*device, 1);
  EXPECT_EQ(decoded->counters.bad_records, 0U);
}

TEST(MagneticTracker, WhatItDoesNotKnowIsRefused) {
  const auto refused = [](auto change) {
    MagneticTrackerOptions options;
    change(options);
    const auto tracker = MagneticTracker::make("tracker", options, 1, std::make_shared<TestField>());
    return !tracker && !tracker.error().message.empty();
  };
  EXPECT_TRUE(refused([](auto& options) { options.items = "99"; }));
  EXPECT_TRUE(refused([](auto& options) { options.unit = "furlong"; }));
  EXPECT_TRUE(refused([](auto& options) { options.station_count = 5; }));
}

}  // namespace
}  // namespace roseau::synthesis
