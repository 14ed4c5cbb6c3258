// GHG archives written here byte by byte: a zip without compression, and the .data that LI-COR's loggers write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recorder/tools/import/record_times.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/recorder/import/imported.h"

namespace roseau::recorder {
namespace {

using roseau::testing::TemporaryFolder;
using ::testing::HasSubstr;

std::string number(std::uint64_t value, int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xFFU);
  return bytes;
}

std::uint32_t crc_of(const std::string& bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char c : bytes) {
    crc ^= static_cast<std::uint8_t>(c);
    for (int i = 0; i < 8; ++i) crc = crc >> 1U ^ (0xEDB88320U & (0U - (crc & 1U)));
  }
  return ~crc;
}

struct Member {
  std::string name;
  std::string bytes;
  std::uint32_t wrong_crc_bits = 0;
  std::uint32_t extra_size = 0;  // declared beyond what there is
};

std::string zip_of(const std::vector<Member>& members) {
  std::string file;
  std::string directory;
  for (const auto& member : members) {
    const auto size = member.bytes.size() + member.extra_size;
    const auto common = number(20, 2) + number(0, 2) + number(0, 2) + number(0, 4) +
                        number(crc_of(member.bytes) ^ member.wrong_crc_bits, 4) + number(member.bytes.size(), 4) +
                        number(size, 4) + number(member.name.size(), 2) + number(0, 2);
    directory += "PK\x01\x02" + number(20, 2) + common + number(0, 2) + number(0, 2) + number(0, 2) + number(0, 4) +
                 number(file.size(), 4) + member.name;
    file += "PK\x03\x04" + common + member.name + member.bytes;
  }
  const auto begin = file.size();
  return file + directory + "PK\x05\x06" + number(0, 4) + number(members.size(), 2) + number(members.size(), 2) +
         number(directory.size(), 4) + number(begin, 4) + number(0, 2);
}

const std::string kHead =
    "Model:\tLI-7200 Enclosed CO2/H2O Analyzer\nSN:\t72H-0192\nInstrument:\tAIU-1111\nFile Type:\t2\nSoftware Version:\t8.0.0\n"
    "Timestamp:\t23:59:59:000\nTimezone:\tEtc/GMT-1\n"
    "DATAH\tSeconds\tNanoseconds\tSequence Number\tDiagnostic Value\tDate\tTime\tCO2 (mmol/m^3)\tAux 1 - U (m/s)\t"
    "Aux 2 - V (m/s)\tAux 3 - W (m/s)\tAux 4 - Ts (K)\tCHK\n";

// 2023-12-31 23:59:59 UTC and on.
std::string row(int i) {
  return "DATA\t" + std::to_string(1'704'067'199 + i / 10) + "\t" + std::to_string(i % 10 * 100'000'000) + "\t" +
         std::to_string(i) + "\t8191\t2024-01-01\t00:59:59:" + std::to_string(i % 10 * 100) + "\t16.2\t" + std::to_string(i) +
         ".5\t-2.25\t0.125\t300.15\t91\n";
}

std::string data(int rows) {
  std::string text = kHead;
  for (int i = 0; i < rows; ++i) text += row(i);
  return text;
}

void expect_imported(const std::string& path) {
  Imported imported;
  ASSERT_EQ(imported.run(sonic_plan(path)), "");
  ASSERT_EQ(imported.samples.at("/sonic/wind").size(), 25U);
  const auto& wind = imported.payload<WindSample>("/sonic/wind", 3);
  EXPECT_EQ(wind.u_mps, 3.5);
  EXPECT_EQ(wind.v_mps, -2.25);
  EXPECT_EQ(wind.w_mps, 0.125);
  EXPECT_NEAR(wind.sonic_temperature_celsius, 27, 1e-9);
  EXPECT_EQ(format_time_stamp(imported.civil("/sonic/wind", 0)), "2023-12-31T23:59:59.000");
  EXPECT_EQ(format_time_stamp(imported.civil("/sonic/wind", 10)), "2024-01-01T00:00:00.000");
  EXPECT_EQ(imported.report.streams.at(0).rate_hz, 10);
  EXPECT_THAT(imported.remarks(), HasSubstr("Timezone: Etc/GMT-1"));
}

TEST(Ghg, ReadsTheData) {
  const TemporaryFolder folder;
  expect_imported(folder.write("a.data", data(25)));
}

TEST(Ghg, ReadsTheArchive) {
  const TemporaryFolder folder;
  expect_imported(folder.write("a.ghg", zip_of({{"a.metadata", "[Site]\n"},
                                                {"a-biomet.data", "TIMESTAMP\n"},
                                                {"a.data", data(25)},
                                                {"system_config.xml", "<a/>"}})));
}

TEST(Ghg, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  const auto error_of = [&](const std::string& bytes) {
    Imported imported;
    return imported.run(sonic_plan(folder.write("a.ghg", bytes)));
  };
  EXPECT_THAT(error_of(zip_of({{"a.metadata", "[Site]\n"}})), HasSubstr("a.ghg: holds no .data file"));
  EXPECT_THAT(error_of(zip_of({{"a.data", data(1)}, {"b.data", data(1)}})), HasSubstr("holds several .data files"));
  auto cut = zip_of({{"a.data", data(25)}});
  cut.resize(cut.size() / 2);
  EXPECT_THAT(error_of(cut), HasSubstr("is no zip archive that can be read"));
  EXPECT_THAT(error_of(zip_of({{"a.data", data(25), 1}})), HasSubstr("cannot be unpacked"));
  EXPECT_NE(error_of(zip_of({{"a.data", data(25), 0, 1000}})), "") << "a size that is not the real one";
  EXPECT_THAT(error_of(data(0)), HasSubstr("no rows"));
  EXPECT_THAT(error_of(data(2) + "DATA\t1\t2\n"), HasSubstr("3 fields where there are 13 columns"));
}

}  // namespace
}  // namespace roseau::recorder
