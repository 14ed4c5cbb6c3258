// Real recordings. Skipped where they are absent.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <regex>
#include <set>

#include "core/wind_geometry.h"
#include "recorder/tools/import/record_times.h"
#include "tests/support/data.h"
#include "tests/unit/recorder/import/imported.h"

namespace roseau::recorder {
namespace {

using ::testing::HasSubstr;

// The text logs, read here by other means.
struct Line {
  std::uint32_t millis = 0;
  std::uint32_t gps_time = 0;
  bool has_fix = false;
  bool is_whole = false;
  double u = 0;
  double v = 0;
  double w = 0;
  double t = 0;
};

std::vector<Line> read_lines(const std::filesystem::path& path) {
  static const std::regex kWhole(
      R"(^S2 +[-0-9.]+ D +\d+ U +([-0-9.]+) V +([-0-9.]+) W +([-0-9.]+) T +([-0-9.]+) H +[0-9.]+ AD +[0-9.]+ AX +-?\d+ AY +-?\d+ AZ +-?\d+ MD +\d+\s*$)");
  std::vector<Line> lines;
  std::ifstream file(path);
  for (std::string text; std::getline(file, text);) {
    if (text.starts_with("#")) continue;
    Line line;
    std::size_t begin = 0;
    std::array<std::string, 5> fields;
    for (auto& field : fields) {
      const auto comma = text.find(',', begin);
      field = text.substr(begin, comma - begin);
      begin = comma + 1;
    }
    line.millis = static_cast<std::uint32_t>(std::stoul(fields[0]));
    line.has_fix = std::stod(fields[1]) < 91;
    line.gps_time = static_cast<std::uint32_t>(std::stoul(fields[3]));
    std::smatch match;
    const auto rest = text.substr(begin);
    line.is_whole = std::regex_match(rest, match, kWhole);
    if (line.is_whole) {
      line.u = std::stod(match[1]);
      line.v = std::stod(match[2]);
      line.w = std::stod(match[3]);
      line.t = std::stod(match[4]);
    }
    lines.push_back(line);
  }
  return lines;
}

TEST(RealTriSonica, EveryWholeLineBecomesItsWind) {
  ROSEAU_REQUIRE_DATA(folder, "data/sonic_trisonica_array");
  Imported imported;
  ASSERT_EQ(imported.run(sonic_plan((folder / "sensor_A.txt").string())), "");
  const auto lines = read_lines(folder / "sensor_A.txt");
  ASSERT_EQ(lines.size(), 21'120U);
  EXPECT_EQ(imported.samples.at("/sonic/raw").size(), lines.size());
  ASSERT_EQ(imported.samples.at("/sonic/wind").size(), 21'118U) << "two merged parts of lines are no records";
  std::size_t next = 0;
  for (const auto& line : lines) {
    if (!line.is_whole) continue;
    const auto& wind = imported.payload<WindSample>("/sonic/wind", next++);
    ASSERT_TRUE(wind.u_mps == line.u && wind.v_mps == line.v && wind.w_mps == line.w &&
                wind.sonic_temperature_celsius == line.t)
        << next;
  }
  EXPECT_EQ(next, 21'118U);
}

TEST(RealTriSonica, TheLoggersOwnFilesGiveTheSameAndOneMore) {
  ROSEAU_REQUIRE_DATA(folder, "data/sonic_trisonica_array");
  Imported text;
  ASSERT_EQ(text.run(sonic_plan((folder / "sensor_A.txt").string())), "");
  Imported blocks;
  ASSERT_EQ(blocks.run(sonic_plan((folder / "raw" / "A").string())), "");
  // There the line that was cut in two is one again.
  ASSERT_EQ(blocks.samples.at("/sonic/wind").size(), 21'119U);
  for (std::size_t i = 0; i < 21'118; ++i) {
    const auto& a = text.payload<WindSample>("/sonic/wind", i);
    const auto& b = blocks.payload<WindSample>("/sonic/wind", i + 1);
    ASSERT_TRUE(a.u_mps == b.u_mps && a.v_mps == b.v_mps && a.w_mps == b.w_mps) << i;
  }
  const auto shift = text.civil("/sonic/wind", 21'000) - blocks.civil("/sonic/wind", 21'001);
  EXPECT_LT(std::abs(shift.count()), 1'000'000);
}

TEST(RealTriSonica, BothSensorsLieOnGpsTime) {
  ROSEAU_REQUIRE_DATA(folder, "data/sonic_trisonica_array");
  ImportPlan plan;
  plan.sonics.push_back({.name = "a", .path = (folder / "sensor_A.txt").string()});
  plan.sonics.push_back({.name = "b", .path = (folder / "sensor_B.txt").string()});
  Imported imported;
  ASSERT_EQ(imported.run(plan), "");
  EXPECT_EQ(imported.samples.at("/b/wind").size(), 21'120U) << "a good line behind noise is found";
  for (const std::string name : {"a", "b"}) {
    const auto lines = read_lines(folder / ("sensor_" + std::string(name == "a" ? "A" : "B") + ".txt"));
    const auto topic = "/" + name + "/raw";
    // A's receiver had the leap seconds wrong at first, by two, and three of its sentences were misread (latitude 0.016667).
    const std::uint32_t settled_millis = name == "a" ? 190'069 : 0;
    std::size_t compared = 0;
    std::size_t current = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!lines[i].has_fix || lines[i].millis < settled_millis || lines[i].gps_time < 17'000'000) continue;
      const auto gps = *parse_time_stamp("2021-07-07 00:00:00") + std::chrono::hours{lines[i].gps_time / 1'000'000} +
                       std::chrono::minutes{lines[i].gps_time / 10'000 % 100} +
                       std::chrono::seconds{lines[i].gps_time / 100 % 100};
      const double age_s = to_seconds(imported.civil(topic, i) - gps);
      ASSERT_GT(age_s, -0.15) << name << i << ": a second of the future";
      ++compared;
      if (age_s < 1.15) ++current;
    }
    EXPECT_GT(compared, 19'000U) << name;
    EXPECT_GT(static_cast<double>(current) / static_cast<double>(compared), 0.97) << name << ": the rest are seconds left out";
    for (std::size_t i = 1; i < lines.size(); ++i)
      ASSERT_LE(imported.civil(topic, i - 1), imported.civil(topic, i)) << name << i;
  }
  EXPECT_THAT(imported.remarks(), HasSubstr("laid on GPS time"));
}

TEST(RealFastrak, MatricesAreRotations) {
  ROSEAU_REQUIRE_DATA(folder, "data/em_polhemus_fastrak");
  std::size_t samples = 0;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".traj") continue;
    std::ifstream file(entry.path());
    std::vector<double> numbers;
    for (double number = 0; file >> number;) numbers.push_back(number);
    Imported imported;
    ASSERT_EQ(imported.run(tracker_plan(entry.path().string())), "") << entry.path();
    const auto& poses = imported.samples.at("/tracker/station1/pose");
    ASSERT_EQ(poses.size() * 16, numbers.size()) << entry.path();
    samples += poses.size();
    ++files;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto& pose = std::get<StationPose>(poses[i].payload);
      const double* m = &numbers[i * 16];
      ASSERT_TRUE(pose.valid) << entry.path() << i;
      EXPECT_EQ(pose.position_in_source_m.x, m[3]);
      EXPECT_EQ(pose.position_in_source_m.z, m[11]);
      // The first column of the matrix is the station's x axis: turned by the quaternion it must come out the same.
      const auto& q = pose.source_from_station;
      EXPECT_NEAR(1 - 2 * (q.y * q.y + q.z * q.z), m[0], 5e-6);
      EXPECT_NEAR(2 * (q.x * q.y + q.w * q.z), m[4], 5e-6);
      EXPECT_NEAR(2 * (q.x * q.z - q.w * q.y), m[8], 5e-6);
      // The rows are of length 1 and square to each other, as the data's description says, to 1.7e-6.
      EXPECT_NEAR(m[0] * m[0] + m[1] * m[1] + m[2] * m[2], 1, 5e-6);
      EXPECT_NEAR(m[0] * m[4] + m[1] * m[5] + m[2] * m[6], 0, 5e-6);
    }
    EXPECT_NEAR(imported.seconds_after_first("/tracker/station1/pose", poses.size() - 1),
                0.01 * static_cast<double>(poses.size() - 1), 1e-9);
  }
  EXPECT_EQ(files, 20U);
  EXPECT_EQ(samples, 5'611U);
}

TEST(RealLiberty, PolledAt360AndUniqueAt240) {
  ROSEAU_REQUIRE_DATA(folder, "data/em_polhemus_liberty");
  for (const char* name : {"Polhemus_90degX(clean)_2data.csv", "Polhemus_90degX(clean)_data.csv", "Polhemus_90degY_2data.csv",
                           "Polhemus_90degZ_1data.csv"}) {
    Imported imported;
    ASSERT_EQ(imported.run(tracker_plan((folder / name).string())), "");
    std::size_t unique = 0;
    double largest_angle_deg = 0;
    const auto& first = imported.samples.at("/tracker/station1/pose");
    const auto& second = imported.samples.at("/tracker/station2/pose");
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      unique += (first[i].header.status & kStatusDuplicate) == 0 ? 1U : 0U;
      unique += (second[i].header.status & kStatusDuplicate) == 0 ? 1U : 0U;
      const auto& a = std::get<StationPose>(first[i].payload).source_from_station;
      const auto& b = std::get<StationPose>(second[i].payload).source_from_station;
      const double cosine = std::abs(a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z);
      largest_angle_deg = std::max(largest_angle_deg, 2 * std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi);
    }
    const double span_s = imported.seconds_after_first("/tracker/station1/pose", first.size() - 1);
    EXPECT_NEAR(static_cast<double>(first.size()) / span_s, 360, 1.5) << name;
    EXPECT_NEAR(static_cast<double>(unique) / span_s, 240, 1.5) << name;
    EXPECT_GT(largest_angle_deg, 80) << name;
    EXPECT_LT(largest_angle_deg, 95) << name;
  }
}

}  // namespace
}  // namespace roseau::recorder
