#include "recorder/tools/export/export_session.h"

#include <gmock/gmock.h>

#include <sstream>

#include "core/image_coding/image_decoder.h"
#include "recorder/tools/export/output_file.h"
#include "recorder/tools/export/sample_table.h"
#include "recorder/tools/import/import_session.h"
#include "tests/support/session_file.h"
#include "tests/support/temporary_folder.h"

namespace roseau::recorder {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

class ExportTest : public ::testing::Test {
 protected:
  std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }
  void SetUp() override { testing::SessionFile().write(path("s.mcap"), 2); }
  static std::vector<std::string> lines(const std::filesystem::path& file) {
    std::istringstream text(testing::read_text_file(file));
    std::vector<std::string> all;
    for (std::string line; std::getline(text, line);) all.push_back(line);
    return all;
  }
  const testing::TemporaryFolder folder_;
};

TEST(SampleTable, EveryKindFillsItsColumns) {
  StreamTable streams;
  FramePool pool(8, 1000);
  for (std::size_t i = 0; i < kSampleKindCount; ++i) {
    const auto kind = static_cast<SampleKind>(i);
    const auto rows = rows_of(testing::filled_sample(kind, streams, pool));
    ASSERT_FALSE(rows.empty()) << to_string(kind);
    EXPECT_FALSE(columns_of(kind).empty()) << to_string(kind);
    EXPECT_EQ(rows.front().size(), columns_of(kind).size()) << to_string(kind);
  }
}

TEST(CsvField, IsQuotedWhereItMustBe) {
  EXPECT_EQ(csv_field("plain"), "plain");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("say \"x\"\n"), "\"say \"\"x\"\"\n\"");
}

TEST_F(ExportTest, CsvHasOneFilePerTopicWithNamesUnitsAndTimes) {
  const auto report = export_csv(path("s.mcap"), {.from = "1"}, path("csv"));
  ASSERT_TRUE(report) << report.error().message;
  const auto rows = lines(path("csv") / "sonic_wind.csv");
  ASSERT_EQ(rows.size(), 1U + 20U);
  EXPECT_EQ(rows[0],
            "utc,time_s,arrival_s,sequence,status,u_mps,v_mps,w_mps,sonic_temperature_celsius,speed_of_sound_mps,device_status,"
            "valid\r");
  // 1.7e9 s civil at host time 0, the session begins at 1000 s, the sample time is 1 ms before the arrival.
  EXPECT_THAT(rows[1], StartsWith("2023-11-14T22:30:00.999"));
  EXPECT_THAT(rows[1], HasSubstr(",20,0,2,-1,0.25,20,343,0,1\r"));
  EXPECT_TRUE(std::filesystem::exists(path("csv") / "camera0_image.csv"));
}

TEST_F(ExportTest, WhatIsNotANumberIsAnEmptyField) {
  testing::SessionFile file;
  file.open(path("n.mcap"));
  file.add("/sonic/wind", 0, 0, WindSample{.u_mps = 1, .valid = false});
  file.close();
  ASSERT_TRUE(export_csv(path("n.mcap"), {}, path("csv")));
  EXPECT_THAT(lines(path("csv") / "sonic_wind.csv").at(1), HasSubstr(",0,0,1,,,,,0,0"));
}

TEST_F(ExportTest, NothingIsOverwritten) {
  ASSERT_TRUE(export_csv(path("s.mcap"), {}, path("csv")));
  const auto before = testing::read_text_file(path("csv") / "sonic_wind.csv");
  const auto again = export_csv(path("s.mcap"), {.to = "1"}, path("csv"));
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().message, HasSubstr("is not overwritten"));
  EXPECT_EQ(testing::read_text_file(path("csv") / "sonic_wind.csv"), before);
  folder_.write("o.nc", "precious");
  EXPECT_FALSE(export_netcdf(path("s.mcap"), {}, path("o.nc")));
  EXPECT_EQ(testing::read_text_file(path("o.nc")), "precious");
}

TEST_F(ExportTest, Toa5IsReadAgainByTheImporter) {
  testing::SessionFile file;
  file.open(path("t.mcap"));
  for (std::uint32_t i = 0; i < 40; ++i) {
    WindSample wind = testing::SessionFile::wind(0.1 * i);
    if (i == 7) wind = {.device_status = 3, .valid = false};
    file.add("/sonic/wind", 0.05 * i, i, wind);
  }
  file.close();
  const auto report = export_toa5(path("t.mcap"), {}, path("t.dat"));
  ASSERT_TRUE(report) << report.error().message;
  const auto head = lines(path("t.dat"));
  EXPECT_THAT(head[0], StartsWith("\"TOA5\",\"storm\""));
  ImportPlan plan;
  plan.sonics.push_back({.path = path("t.dat").string()});
  plan.sonics.back().file.format = SonicFormat::toa5;
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import) << import.error().message;
  struct : SampleSink {
    bool receive(Sample sample) override {
      samples.push_back(std::move(sample));
      return true;
    }
    std::vector<Sample> samples;
  } sink;
  ASSERT_TRUE(import->run(sink));
  ASSERT_EQ(sink.samples.size(), 40U);
  const auto wind = [&sink](std::size_t i) { return std::get<WindSample>(sink.samples[i].payload); };
  EXPECT_FALSE(wind(7).valid);
  EXPECT_TRUE(wind(8).valid);
  EXPECT_DOUBLE_EQ(wind(11).u_mps, 1.1);
  EXPECT_DOUBLE_EQ(wind(11).sonic_temperature_celsius, 20);
  EXPECT_DOUBLE_EQ(wind(11).speed_of_sound_mps, 343);
  const Duration civil = sink.samples[0].header.sample_time.time_since_epoch() + *import->utc_minus_host_time();
  EXPECT_EQ(civil.count(), 1'700'000'999'999'000'000) << "the first sample's civil time";
}

TEST_F(ExportTest, Toa5NeedsOneWindAndCivilTime) {
  testing::SessionFile file;
  file.description.utc_minus_host_time.reset();
  file.write(path("u.mcap"), 1);
  const auto no_time = export_toa5(path("u.mcap"), {}, path("u.dat"));
  ASSERT_FALSE(no_time);
  EXPECT_THAT(no_time.error().message, HasSubstr("civil time"));
  EXPECT_FALSE(std::filesystem::exists(path("u.dat")));
  EXPECT_FALSE(export_toa5(path("s.mcap"), {.topics = {"/camera0/*"}}, path("u.dat")));
}

TEST_F(ExportTest, FramesAreLosslessPngWithTheirTimes) {
  const auto report = export_frames(path("s.mcap"), {.from = "0.5", .to = "1"}, path("png"));
  ASSERT_TRUE(report) << report.error().message;
  const auto index = lines(path("png") / "camera0_image.csv");
  ASSERT_EQ(index.size(), 1U + 5U);
  EXPECT_THAT(index[1], StartsWith("camera0_image_00000000.png,2023-"));
  EXPECT_THAT(index[1], HasSubstr(",5,0,100,50,0.004"));
  const std::string png = testing::read_text_file(path("png") / "camera0_image_00000000.png");
  std::vector<std::byte> pixels(5000);
  image::ImageDecoder decoder;
  const auto decoded = decoder.decode(std::as_bytes(std::span(png)), pixels);
  ASSERT_TRUE(decoded) << decoded.error().message;
  FramePool pool(1, 5000);
  const auto expected = testing::filled_frame(pool, 100, 50, 100);
  EXPECT_TRUE(std::ranges::equal(pixels, expected.bytes()));
}

TEST_F(ExportTest, AFailureLeavesNothingBehind) {
  EXPECT_FALSE(export_video(path("s.mcap"), {.topics = {"/camera0/image"}}, path("v.xyz"))) << "no such container";
  EXPECT_FALSE(std::filesystem::exists(path("v.xyz.csv")));
  EXPECT_FALSE(export_netcdf(path("s.mcap"), {.topics = {"/camera0/image"}}, path("v.nc")));
  EXPECT_FALSE(std::filesystem::exists(path("v.nc")));
}

}  // namespace
}  // namespace roseau::recorder
