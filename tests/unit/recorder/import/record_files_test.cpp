#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "core/wind_statistics.h"
#include "tests/support/data.h"
#include "tests/unit/recorder/import/read_record.h"

namespace roseau::recorder {
namespace {

using ::testing::HasSubstr;

std::string content_of(const std::filesystem::path& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

SonicRecord sonic(std::string_view text, const SonicFileOptions& options) {
  auto record = parse_sonic_file(text, "sonic.csv", options);
  EXPECT_TRUE(record) << record.error().message;
  return record ? *record : SonicRecord{};
}

std::string sonic_error(std::string_view text, const SonicFileOptions& options) {
  const auto record = parse_sonic_file(text, "sonic.csv", options);
  return record ? "no error" : record.error().message;
}

DisplacementRecord displacement(std::string_view text, const DisplacementFileOptions& options) {
  auto record = parse_displacement_file(text, "strain.txt", options);
  EXPECT_TRUE(record) << record.error().message;
  return record ? *record : DisplacementRecord{};
}

std::string displacement_error(std::string_view text, const DisplacementFileOptions& options) {
  const auto record = parse_displacement_file(text, "strain.txt", options);
  return record ? "no error" : record.error().message;
}

TEST(SonicFile, RecognisesUsualNames) {
  for (const char* names :
       {"U,V,W,T_SONIC", "Ux,Uy,Uz,Ts", "u (m/s),v (m/s),w (m/s),T_sonic (C)", "u_mps,v_mps,w_mps,sonic_temperature"}) {
    const auto record = sonic(std::string(names) + "\n1,2,3,20\n-1,-2,-3,21\n", {.rate_hz = 20.0});
    ASSERT_EQ(record.samples.size(), 2U) << names;
    EXPECT_EQ(record.samples[1].u_mps, -1);
    EXPECT_EQ(record.samples[1].v_mps, -2);
    EXPECT_EQ(record.samples[1].w_mps, -3);
    EXPECT_EQ(record.samples[1].sonic_temperature_celsius, 21);
    EXPECT_EQ(record.times.since_first[1], std::chrono::milliseconds{50});
  }
}

TEST(SonicFile, TakesColumnsByName) {
  const auto record = sonic("a,b,c,d,e\n9,1,2,3,340\n", {.columns = "u=b,v=c,w=d,c=e", .rate_hz = 10.0});
  ASSERT_EQ(record.samples.size(), 1U);
  EXPECT_EQ(record.samples[0].w_mps, 3);
  EXPECT_EQ(record.samples[0].speed_of_sound_mps, 340);
  const auto unnamed = sonic("9 1 2\n", {.columns = "u=2,v=3", .rate_hz = 10.0});
  EXPECT_EQ(unnamed.samples.at(0).v_mps, 2);
  EXPECT_TRUE(std::isnan(unnamed.samples[0].w_mps));
  EXPECT_TRUE(unnamed.samples[0].valid) << "a two-dimensional sonic has no w";
}

TEST(SonicFile, AMissingColumnIsNamedWithWhatThereIs) {
  EXPECT_EQ(sonic_error("U,W,T_SONIC\n1,2,3\n", {.columns = "v=V", .rate_hz = 20.0}),
            "sonic.csv: column 'V' for v is missing; the file has: U, W, T_SONIC");
  EXPECT_THAT(
      sonic_error("U,W,T_SONIC\n1,2,3\n", {.rate_hz = 20.0}),
      ::testing::AllOf(HasSubstr("sonic.csv: no column for v"), HasSubstr("the file has: U, W, T_SONIC"), HasSubstr("v=NAME")));
}

TEST(SonicFile, TemperaturesBecomeCelsius) {
  EXPECT_NEAR(sonic("U,V,T_SONIC\n1,2,301.15\n", {.rate_hz = 20.0}).samples[0].sonic_temperature_celsius, 28.0, 1e-9);
  EXPECT_NEAR(sonic("U,V,T_SONIC\n1,2,28\n", {.rate_hz = 20.0}).samples[0].sonic_temperature_celsius, 28.0, 1e-9);
  EXPECT_NEAR(sonic("U,V,Ts\nm/s,m/s,K\n1,2,28\n", {.rate_hz = 20.0}).samples[0].sonic_temperature_celsius, -245.15, 1e-9);
  EXPECT_NEAR(sonic("U,V,Ts\nm/s,m/s,C\n1,2,301\n", {.rate_hz = 20.0}).samples[0].sonic_temperature_celsius, 301, 1e-9);
  const SonicFileOptions kelvin{.rate_hz = 20.0, .temperature_unit = TemperatureUnit::kelvin};
  EXPECT_NEAR(sonic("U,V,Ts\n1,2,28\n", kelvin).samples[0].sonic_temperature_celsius, -245.15, 1e-9);
}

TEST(SonicFile, MissingAndFlaggedRowsAreInvalidSamples) {
  const auto record = sonic("U,V,W,diag\n1,2,3,0\n-9999,2,3,0\n1,NAN,3,0\n1,2,,0\n1,2,3,64\n1,2,3,\n200,2,3,0\n",
                            {.columns = "status=diag", .rate_hz = 20.0});
  ASSERT_EQ(record.samples.size(), 7U);
  EXPECT_TRUE(record.samples[0].valid);
  for (std::size_t i = 1; i < 7; ++i) EXPECT_FALSE(record.samples[i].valid) << i;
  EXPECT_EQ(record.samples[4].device_status, 64);
  EXPECT_EQ(record.invalid_samples, 6U);
}

TEST(SonicFile, ReadsToa5WithItsTimes) {
  const std::string head =
      "\"TOA5\",\"mast\",\"CR3000\",\"2113\",\"CR3000.Std.11\",\"CPU:eddy.CR3\",\"32171\",\"ts_data\"\r\n"
      "\"TIMESTAMP\",\"RECORD\",\"Ux\",\"Uy\",\"Uz\",\"Ts\",\"diag\"\r\n\"TS\",\"RN\",\"m/s\",\"m/s\",\"m/s\",\"C\",\"\"\r\n"
      "\"\",\"\",\"Smp\",\"Smp\",\"Smp\",\"Smp\",\"Smp\"\r\n";
  const auto record = sonic(head +
                                "\"2019-07-30 12:00:00\",100,1.5,-2.5,0.1,21.5,0\r\n"
                                "\"2019-07-30 12:00:00.05\",101,1.6,-2.6,0.2,21.6,0\r\n"
                                "\"2019-07-30 12:00:00.1\",102,\"NAN\",-2.6,0.2,21.6,4\r\n"
                                "\"2019-07-30 12:00:00.2\",104,1.7,-2.7,0.3,21.7,0\r\n",
                            {});
  ASSERT_EQ(record.samples.size(), 4U);
  EXPECT_DOUBLE_EQ(record.times.rate_hz, 20.0);
  EXPECT_THAT(record.remarks, ::testing::Contains("by its times 1 rows are missing"));
  EXPECT_THAT(record.remarks, ::testing::Contains("logger CR3000 'mast', table ts_data"));
  EXPECT_EQ(record.times.since_first[3], std::chrono::milliseconds{200});
  EXPECT_EQ(format_time_stamp(*record.begin), "2019-07-30T12:00:00.000");
  EXPECT_EQ(record.samples[0].sonic_temperature_celsius, 21.5);
  EXPECT_FALSE(record.samples[2].valid);
  EXPECT_TRUE(record.samples[3].valid);
}

TEST(SonicFile, SaysWhereAFileIsWrong) {
  EXPECT_EQ(sonic_error("U,V\n1,2\n1,x\n", {.rate_hz = 20.0}), "sonic.csv:3: column 'V': 'x' is no number");
  EXPECT_THAT(sonic_error("time,U,V\nyesterday,1,2\n", {}), HasSubstr("sonic.csv:2: column 'time': 'yesterday' is no time"));
  EXPECT_THAT(sonic_error("U,V\n1,2\n", {}), HasSubstr("sonic.csv: no column with times, so the rate must be given"));
  EXPECT_THAT(sonic_error("U,V\n1,2\n", {.columns = "q=U"}),
              HasSubstr("'q' is not known; known are u, v, w, t, c, status, time"));
  EXPECT_THAT(sonic_error("", {}), HasSubstr("sonic.csv: the file is empty"));
}

// The same file through EddyPro: SOURCE.txt beside it.
TEST(SonicFile, ReadsHohesHolz) {
  ROSEAU_REQUIRE_DATA(path, "data/sonic_dehoh_rflux/DE-HoH_EC_201907301200_v01.csv");
  const auto record = sonic(content_of(path), {.rate_hz = 20.0});
  ASSERT_EQ(record.samples.size(), 36'000U);
  EXPECT_EQ(record.invalid_samples, 0U);
  EXPECT_EQ(record.times.since_first.back(), std::chrono::milliseconds{35'999 * 50});
  EXPECT_NEAR(record.samples[0].sonic_temperature_celsius, 28.0, 1e-6);
  WindStatistics statistics;
  for (const auto& sample : record.samples) statistics.add(sample);
  EXPECT_NEAR(statistics.mean_vector_mps().x, -1.77889, 5e-6);
  EXPECT_NEAR(statistics.mean_vector_mps().y, 2.81380, 5e-6);
  EXPECT_NEAR(statistics.mean_vector_mps().z, -0.238189, 5e-6);
}

TEST(DisplacementFile, OnePlainColumn) {
  const auto record = displacement("  1.5e-04\r\n -2.5e-04\r\n", {.rate_hz = 4.0, .unit = LengthUnit::strain});
  ASSERT_EQ(record.samples.size(), 2U);
  EXPECT_DOUBLE_EQ(record.samples[1].x, -2.5e-04);
  EXPECT_EQ(record.samples[1].y, 0);
  EXPECT_EQ(record.samples[1].unit, LengthUnit::strain);
  EXPECT_EQ(record.times.since_first[1], std::chrono::milliseconds{250});
}

TEST(DisplacementFile, TwoAxes) {
  for (const char* text : {"1,2\n3,4\n", "x,y\n1,2\n3,4\n", "q,y,x\n9,2,1\n9,4,3\n"}) {
    const auto record = displacement(text, {.rate_hz = 4.0});
    ASSERT_EQ(record.samples.size(), 2U) << text;
    EXPECT_EQ(record.samples[1].x, 3) << text;
    EXPECT_EQ(record.samples[1].y, 4) << text;
  }
}

TEST(DisplacementFile, ManyColumnsNeedAChoice) {
  EXPECT_THAT(
      displacement_error("1 2 3\n4 5 6\n", {.rate_hz = 4.0}),
      ::testing::AllOf(HasSubstr("strain.txt: no column for x"), HasSubstr("the file has: 1, 2, 3"), HasSubstr("x=NAME")));
  EXPECT_EQ(displacement("1 2 3\n4 5 6\n", {.columns = "x=3", .rate_hz = 4.0}).samples[1].x, 6);
}

TEST(DisplacementFile, MissingValuesKeepTheLastGoodOne) {
  const auto record = displacement("1\nNAN\n3\n", {.rate_hz = 4.0});
  ASSERT_EQ(record.samples.size(), 3U);
  EXPECT_FALSE(record.samples[1].valid);
  EXPECT_EQ(record.samples[1].x, 1);
  EXPECT_EQ(record.samples[1].health, 0);
  EXPECT_TRUE(record.samples[2].valid);
  EXPECT_EQ(record.invalid_samples, 1U);
}

TEST(DisplacementFile, SaysWhatIsWrong) {
  EXPECT_THAT(displacement_error("1\n2\n", {}), HasSubstr("the rate must be given in Hz"));
  EXPECT_EQ(displacement_error("1\ntwo\n", {.rate_hz = 4.0}), "strain.txt:2: column '1': 'two' is no number");
  EXPECT_FALSE(length_unit_from_string("furlong"));
  EXPECT_EQ(*length_unit_from_string("strain"), LengthUnit::strain);
}

TEST(DisplacementFile, ReadsPullAndReleaseTests) {
  ROSEAU_REQUIRE_DATA(folder, "data/tree_pull_release");
  const std::vector<std::pair<std::string, std::size_t>> files = {
      {"T14_P1_winter.txt", 501}, {"T14_P3_winter.txt", 601}, {"T16_P2_summer.txt", 101}};
  for (const auto& [name, rows] : files) {
    const auto record = displacement(content_of(folder / name), {.rate_hz = 4.0, .unit = LengthUnit::strain});
    EXPECT_EQ(record.samples.size(), rows) << name;
    EXPECT_EQ(record.invalid_samples, 0U) << name;
    for (const auto& sample : record.samples) ASSERT_LT(std::abs(sample.x), 1e-2) << name;
  }
}

}  // namespace
}  // namespace roseau::recorder
