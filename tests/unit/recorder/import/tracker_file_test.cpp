#include "recorder/tools/import/tracker_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/wire/fastrak.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/recorder/import/imported.h"

namespace roseau::recorder {
namespace {

using roseau::testing::TemporaryFolder;
using ::testing::HasSubstr;

const std::string kPose = "/tracker/station1/pose";

// Turned by 90 degrees about z.
const std::string kMatrix = "0 -1 0 1.5\n1  0 0 -2\n0 0 1 0.25\n0 0 0 1\n\n";

TEST(TrackerFile, ReadsMatrices) {
  const TemporaryFolder folder;
  Imported imported;
  ASSERT_EQ(imported.run(tracker_plan(folder.write("a.traj", kMatrix + kMatrix + kMatrix))), "");
  ASSERT_EQ(imported.samples.at(kPose).size(), 3U);
  const auto& pose = imported.payload<StationPose>(kPose, 2);
  EXPECT_TRUE(pose.valid);
  EXPECT_EQ(pose.position_in_source_m.x, 1.5);
  EXPECT_EQ(pose.position_in_source_m.y, -2);
  EXPECT_NEAR(std::abs(pose.source_from_station.w), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(pose.source_from_station.z * pose.source_from_station.w, 0.5, 1e-12) << "from x to y";
  EXPECT_DOUBLE_EQ(imported.seconds_after_first(kPose, 2), 0.02) << "100 Hz unless told";
  EXPECT_THAT(imported.remarks(), HasSubstr("lengths as m"));
}

TEST(TrackerFile, AMatrixThatIsNoRotationIsFlagged) {
  const TemporaryFolder folder;
  Imported imported;
  const std::string wrong = "0 -2 0 1.5\n1 0 0 -2\n0 0 1 0.25\n0 0 0 1\n\n0 -1 0 1.5\n1 0 0 -2\n0 0 1 0.25\n0 0 0 2\n\n";
  ASSERT_EQ(imported.run(tracker_plan(folder.write("a.traj", kMatrix + wrong))), "");
  EXPECT_FALSE(imported.payload<StationPose>(kPose, 1).valid);
  EXPECT_FALSE(imported.payload<StationPose>(kPose, 2).valid);
  EXPECT_NE(imported.samples.at(kPose)[1].header.status & kStatusMalformed, 0);
  EXPECT_EQ(imported.report.streams.at(0).invalid_samples, 2U);
}

TEST(TrackerFile, SaysWhatIsWrongWithMatrices) {
  const TemporaryFolder folder;
  const auto error_of = [&](const std::string& text) {
    Imported imported;
    return imported.run(tracker_plan(folder.write("a.traj", text), TrackerFormat::fastrak_matrices));
  };
  EXPECT_THAT(error_of("1 2 3\n"), HasSubstr("a.traj:1: 3 numbers in a row of a 4x4 matrix"));
  EXPECT_THAT(error_of(kMatrix + "0 -1 x 1\n"), HasSubstr("a.traj:6: 'x' is no number"));
  EXPECT_THAT(error_of(""), HasSubstr("no rows"));
  Imported cut;
  ASSERT_EQ(cut.run(tracker_plan(folder.write("a.traj", kMatrix + "0 -1 0 1.5\n1 0"))), "");
  EXPECT_EQ(cut.samples.at(kPose).size(), 1U);
  EXPECT_THAT(cut.remarks(), HasSubstr("cut short"));
}

std::string liberty_row(double time_s, double x1, double x2) {
  return std::to_string(time_s) + ",1,0,0,0,0.6,0,0.8,0," + std::to_string(x1) + ",0,0," + std::to_string(x2) + ",1,2\r\n";
}
const std::string kLibertyHead = "Time,w1,x1,y1,z1,w2,x2,y2,z2,loc1_x,loc1_y,loc1_z,loc2_x,loc2_y,loc2_z\r\n";

TEST(TrackerFile, ReadsLibertyAndFlagsRepeatedValues) {
  const TemporaryFolder folder;
  const auto path =
      folder.write("liberty.csv", kLibertyHead + liberty_row(1686230371.0, 1, 5) + liberty_row(1686230371.01, 1, 6) +
                                      liberty_row(1686230371.0101, 2, 6) + liberty_row(1686230371.5, 2, 6));
  Imported imported;
  ASSERT_EQ(imported.run(tracker_plan(path)), "");
  const auto status = [&](int station, std::size_t i) {
    return imported.samples.at("/tracker/station" + std::to_string(station) + "/pose").at(i).header.status;
  };
  EXPECT_EQ(status(1, 0), kStatusOk);
  EXPECT_EQ(status(1, 1), kStatusDuplicate);
  EXPECT_EQ(status(1, 2), kStatusOk);
  EXPECT_EQ(status(1, 3), kStatusDuplicate);
  EXPECT_EQ(status(2, 1), kStatusOk);
  EXPECT_EQ(status(2, 2), kStatusDuplicate);
  const auto& pose = imported.payload<StationPose>("/tracker/station2/pose", 1);
  EXPECT_EQ(pose.station, 2);
  EXPECT_NEAR(pose.position_in_source_m.x, 6 * 0.0254, 1e-12) << "inch unless told";
  EXPECT_NEAR(pose.source_from_station.w, 0.6, 1e-12);
  EXPECT_NEAR(pose.source_from_station.y, 0.8, 1e-12);
  EXPECT_NEAR(imported.seconds_after_first(kPose, 2), 0.0101, 1e-6) << "irregular times are kept";
  EXPECT_THAT(imported.remarks(), HasSubstr("lengths taken as inch"));
  auto plan = tracker_plan(path);
  plan.trackers[0].file.unit = TrackerUnit::centimetre;
  Imported centimetres;
  ASSERT_EQ(centimetres.run(plan), "");
  EXPECT_NEAR(centimetres.payload<StationPose>("/tracker/station2/pose", 1).position_in_source_m.x, 0.06, 1e-12);
}

TEST(TrackerFile, LibertyNeedsItsColumns) {
  const TemporaryFolder folder;
  Imported imported;
  EXPECT_THAT(imported.run(tracker_plan(folder.write("a.csv", "Time,w1,x1\n1,2,3\n"), TrackerFormat::liberty)),
              HasSubstr("no column for y1"));
}

TEST(TrackerFile, FastrakBytesBecomeRawAndPoses) {
  for (const bool is_binary : {false, true}) {
    wire::FastrakFormat format;
    if (is_binary) format = {.layout = wire::quaternion_fastrak_layout(), .is_binary = true, .unit = wire::FastrakUnit::inch};
    std::string bytes = "garbage\r\n";
    for (int i = 0; i < 100; ++i) {
      bytes += wire::encode_fastrak({.station = static_cast<std::uint8_t>(1 + i % 2),
                                     .position_in_source_m = {0.1 + 0.001 * i, 0.2, 0.3},
                                     .source_from_station = {1, 0, 0, 0}},
                                    format);
    }
    const TemporaryFolder folder;
    Imported imported;
    ASSERT_EQ(imported.run(tracker_plan(folder.write("capture.bin", bytes))), "") << is_binary;
    ASSERT_EQ(imported.samples.at("/tracker/station1/pose").size(), 50U) << is_binary;
    ASSERT_EQ(imported.samples.at("/tracker/station2/pose").size(), 50U) << is_binary;
    EXPECT_NEAR(imported.payload<StationPose>("/tracker/station1/pose", 10).position_in_source_m.x, 0.12, 2e-4);
    EXPECT_NEAR(imported.seconds_after_first("/tracker/station1/pose", 49), 49 / 60.0, 0.02) << "120 Hz shared by two";
    std::size_t size = 0;
    for (const auto& sample : imported.samples.at("/tracker/raw")) size += std::get<RawBytes>(sample.payload).size;
    EXPECT_EQ(size, bytes.size());
  }
}

TEST(TrackerFile, WhatIsNoneIsRefused) {
  const TemporaryFolder folder;
  Imported imported;
  EXPECT_THAT(imported.run(tracker_plan(folder.write("a.txt", "hello there\n"))),
              HasSubstr("'hello there': say which with --format"));
  EXPECT_THAT(imported.run(tracker_plan(folder.write("a.txt", "hello there\n"), TrackerFormat::fastrak)),
              HasSubstr("no record of a FASTRAK"));
}

}  // namespace
}  // namespace roseau::recorder
