#include "daemon/truth_judge.h"

#include <gtest/gtest.h>

#include <cmath>

#include "daemon/topic_names.h"

namespace roseau::daemon {
namespace {

class TruthJudgeTest : public ::testing::Test {
 protected:
  template <class T>
  void see(const std::string& topic, double time_s, T payload) {
    Sample sample;
    sample.header.stream = streams_.add({.topic = topic, .kind = "x"});
    sample.header.sample_time = HostTime{from_seconds(time_s)};
    sample.payload = std::move(payload);
    judge_.see(sample);
  }
  StreamTable streams_;
  TruthJudge judge_{streams_};
};

TEST_F(TruthJudgeTest, DisplacementIsComparedAboutTheMeanWhicheverComesFirst) {
  for (int i = 0; i < 100; ++i) {
    const double time_s = i / 30.0;
    const double truth = std::sin(0.3 * i);
    const double error = i % 2 == 0 ? 0.1 : -0.1;
    const bool truth_first = i % 3 == 0;
    if (truth_first) see("/truth/camera0/target/branch/displacement", time_s, Displacement{.x = truth});
    see("/camera0/target/branch/displacement", time_s, Displacement{.x = truth + 5 + error});
    if (!truth_first) see("/truth/camera0/target/branch/displacement", time_s, Displacement{.x = truth});
  }
  const auto figures = judge_.figures().at("displacement_x/camera0/branch");
  EXPECT_EQ(figures.count, 100U);
  EXPECT_NEAR(figures.rms, 0.1, 1e-9);
  EXPECT_NEAR(figures.max, 0.1, 1e-9);
  EXPECT_EQ(figures.unit, "px");
}

TEST_F(TruthJudgeTest, LostTargetsAndStrangersAreNotCompared) {
  see("/truth/camera0/target/branch/displacement", 1, Displacement{});
  see("/camera0/target/branch/displacement", 1, Displacement{.x = 100, .valid = false});
  see("/camera0/target/other/displacement", 1, Displacement{.x = 100});
  EXPECT_TRUE(judge_.figures().empty());
}

TEST_F(TruthJudgeTest, NaturalFrequencyOfAcceptedIdentificationsOnly) {
  see("/truth/target/branch/identification", 0, Identification{.natural_frequency_hz = 1.2});
  see("/camera1/target/branch/identification", 1, Identification{.natural_frequency_hz = 1.3, .accepted = true});
  see("/camera1/target/branch/identification", 2, Identification{.natural_frequency_hz = 9.9, .accepted = false});
  const auto figures = judge_.figures().at("natural_frequency/camera1/branch");
  EXPECT_EQ(figures.count, 1U);
  EXPECT_NEAR(figures.max, 0.1, 1e-12);
}

TEST_F(TruthJudgeTest, WindIsComparedAlongTheCalibratedDirectionAtItsOwnTime) {
  // Truth: from the west (270), growing by 1 m/s each second; u = -s cos(270) = 0, v = s sin(270) = -s.
  for (int i = 0; i <= 10; ++i) see("/truth/wind", i, WindSample{.u_mps = 0, .v_mps = -(3.0 + i), .w_mps = 0});
  see("/camera0/target/branch/calibration", 10, WindCalibration{.reference = "/sonic/wind", .direction_deg = 270});
  see("/camera0/target/branch/wind", 4.5, WindEstimate{.wind_mps = 7.7, .accepted = true, .scale_known = true});
  see("/camera0/target/branch/wind", 4.6, WindEstimate{.wind_mps = 99, .accepted = true, .scale_known = false});
  const auto figures = judge_.figures().at("wind/camera0/branch");
  EXPECT_EQ(figures.count, 1U);
  EXPECT_NEAR(figures.max, 0.2, 1e-9);
}

TEST_F(TruthJudgeTest, FramesAreHeldAgainstTheirTrueExposure) {
  for (int i = 0; i < 50; ++i) {
    see("/truth/camera0/exposure", i / 20.0, ClockState{});
    if (i % 5 != 4) see("/camera0/motion", i / 20.0 + 0.014, ImageMotion{});  // every fifth frame was lost
  }
  const auto figures = judge_.figures().at("clock/camera0");
  EXPECT_NEAR(static_cast<double>(figures.count), 40, 1);
  EXPECT_NEAR(figures.max, 0.014, 1e-9);
  EXPECT_EQ(figures.unit, "s");
}

TEST_F(TruthJudgeTest, RecordsAreHeldAgainstTheNearestTrueTime) {
  for (int i = 0; i < 100; ++i) {
    see("/truth/sonic/wind", i / 20.0, WindSample{});
    if (i % 7 != 0) see("/sonic/wind", i / 20.0 + (i % 2 == 0 ? 0.003 : -0.004), WindSample{});
  }
  const auto figures = judge_.figures().at("clock/sonic");
  EXPECT_NEAR(static_cast<double>(figures.count), 84, 2);  // the last ones wait for the truth behind them
  EXPECT_NEAR(figures.max, 0.004, 1e-9);
  EXPECT_NEAR(figures.rms, std::sqrt((9e-6 + 16e-6) / 2), 5e-5);
}

TEST(TopicNames, TargetsAreNamedByCameraAndName) {
  EXPECT_EQ(target_of_topic("/camera0/target/branch/wind", "wind"), "camera0/branch");
  EXPECT_EQ(target_of_topic("/displacement/oak/identification", "identification"), "oak");
  EXPECT_FALSE(target_of_topic("/sonic/wind", "wind"));
  EXPECT_FALSE(target_of_topic("/wind/estimate", "wind"));
  EXPECT_FALSE(target_of_topic("/truth/target/branch/identification", "wind"));
}

}  // namespace
}  // namespace roseau::daemon
