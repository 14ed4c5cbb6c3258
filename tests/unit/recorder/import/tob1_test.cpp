// TOB1 files written here byte by byte, after the layout in LoggerNet's manual, appendix B.
#include "recorder/tools/import/tob1.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "recorder/tools/import/record_times.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/recorder/import/imported.h"

namespace roseau::recorder {
namespace {

using roseau::testing::TemporaryFolder;
using ::testing::HasSubstr;

std::string bytes_of(std::uint64_t value, int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xFFU);
  return bytes;
}
std::string ulong(std::uint32_t value) { return bytes_of(value, 4); }
std::string ieee4(float value) { return bytes_of(std::bit_cast<std::uint32_t>(value), 4); }
std::string ieee8(double value) { return bytes_of(std::bit_cast<std::uint64_t>(value), 8); }
// Sign, decimals, digits: as the manual of the CR10X describes it; the high byte first.
std::string fp2(bool is_negative, unsigned decimals, unsigned digits) {
  const auto bits = (is_negative ? 0x8000U : 0U) | decimals << 13U | digits;
  return {static_cast<char>(bits >> 8U), static_cast<char>(bits & 0xFFU)};
}

const std::string kStation =
    "\"TOB1\",\"mast\",\"CR3000\",\"2113\",\"CR3000.Std.11\",\"CPU:eddy.CR3\",\"32171\",\"ts_data\"\r\n";
const std::string kHead = kStation +
                          "\"SECONDS\",\"NANOSECONDS\",\"RECORD\",\"Ux\",\"Uy\",\"Uz\",\"Ts\",\"note\"\r\n"
                          "\"SECONDS\",\"NANOSECONDS\",\"RN\",\"m/s\",\"m/s\",\"m/s\",\"C\",\"\"\r\n"
                          "\"\",\"\",\"\",\"Smp\",\"Smp\",\"Smp\",\"Smp\",\"Smp\"\r\n"
                          "\"ULONG\",\"ULONG\",\"ULONG\",\"IEEE4\",\"FP2\",\"FP2\",\"IEEE4\",\"ASCII(4)\"\r\n";

// 2004-12-31 23:59:59 in seconds since 1990.
constexpr std::uint32_t kNewYearsEve = 473'385'599;

std::string record(std::uint32_t number, std::uint32_t seconds, std::uint32_t nanoseconds) {
  return ulong(seconds) + ulong(nanoseconds) + ulong(number) + ieee4(1.5F + static_cast<float>(number)) + fp2(true, 2, 225) +
         fp2(false, 3, 125) + ieee4(21.5F) + "abc" + std::string(1, '\0');
}

std::string import(Imported& imported, const std::string& bytes, SonicFormat format = SonicFormat::automatic) {
  const TemporaryFolder folder;
  return imported.run(sonic_plan(folder.write("fast.dat", bytes), format));
}

TEST(Tob1, ReadsRecordsWithTheLoggersClockOverTheNewYear) {
  std::string file = kHead;
  for (std::uint32_t i = 0; i < 30; ++i) file += record(i, kNewYearsEve + i / 20, i % 20 * 50'000'000);
  Imported imported;
  ASSERT_EQ(import(imported, file), "");
  ASSERT_EQ(imported.samples.at("/sonic/wind").size(), 30U);
  const auto& wind = imported.payload<WindSample>("/sonic/wind", 2);
  EXPECT_EQ(wind.u_mps, 3.5);
  EXPECT_EQ(wind.v_mps, -2.25);
  EXPECT_EQ(wind.w_mps, 0.125);
  EXPECT_EQ(wind.sonic_temperature_celsius, 21.5);
  EXPECT_EQ(format_time_stamp(imported.civil("/sonic/wind", 0)), "2004-12-31T23:59:59.000");
  EXPECT_EQ(format_time_stamp(imported.civil("/sonic/wind", 20)), "2005-01-01T00:00:00.000");
  EXPECT_EQ(imported.report.streams.at(0).rate_hz, 20);
  EXPECT_THAT(imported.remarks(), HasSubstr("logger CR3000 'mast', table ts_data"));
}

TEST(Tob1, KnowsEveryType) {
  const std::string head = kStation +
                           "TIMESTAMP,u,v,w,t_sonic,sos,a,b,c,d\r\nTS,m/s,m/s\r\n,Smp\r\n"
                           "SecNano,IEEE8,LONG,UINT2,INT2,UINT4,BOOL,BOOL2,BOOL8,STRING(3)\r\n";
  const std::string row = ulong(kNewYearsEve) + ulong(250'000'000) + ieee8(-1.25) + bytes_of(0xFFFFFFFDU, 4) + bytes_of(7, 2) +
                          bytes_of(0xFFF6U, 2) + ulong(343) + "\xFF" + bytes_of(1, 2) + bytes_of(1, 8) + "xyz";
  Imported imported;
  ASSERT_EQ(import(imported, head + row), "");
  const auto& wind = imported.payload<WindSample>("/sonic/wind", 0);
  EXPECT_EQ(wind.u_mps, -1.25);
  EXPECT_EQ(wind.v_mps, -3);
  EXPECT_EQ(wind.w_mps, 7);
  EXPECT_EQ(wind.sonic_temperature_celsius, -10);
  EXPECT_EQ(wind.speed_of_sound_mps, 343);
  EXPECT_EQ(format_time_stamp(imported.civil("/sonic/wind", 0)), "2004-12-31T23:59:59.250");
}

TEST(Tob1, Fp2) {
  EXPECT_EQ(decode_fp2(0x0000), 0);
  EXPECT_EQ(decode_fp2(0x0001), 1);
  EXPECT_EQ(decode_fp2(0x2001), 0.1);
  EXPECT_EQ(decode_fp2(0x64D2), 1.234);
  EXPECT_EQ(decode_fp2(0xC4D2), -12.34);
  for (const unsigned special : {0x1FFFU, 0x9FFFU, 0x9FFEU, 7999U}) {
    EXPECT_TRUE(std::isnan(decode_fp2(static_cast<std::uint16_t>(special)))) << special;
  }
}

TEST(Tob1, ARecordCutShortIsLeftOut) {
  for (std::size_t missing = 1; missing < 28; ++missing) {
    auto file = kHead + record(0, kNewYearsEve, 0) + record(1, kNewYearsEve + 1, 0) + record(2, kNewYearsEve + 2, 0);
    file.resize(file.size() - missing);
    Imported imported;
    ASSERT_EQ(import(imported, file), "") << missing;
    EXPECT_EQ(imported.samples.at("/sonic/wind").size(), 2U) << missing;
    EXPECT_THAT(imported.remarks(), HasSubstr("the last row is cut short and was left out"));
  }
}

TEST(Tob1, MissingRecordsAreAHole) {
  std::string file = kHead;
  for (const std::uint32_t i : {0U, 1U, 2U, 3U, 6U, 7U}) file += record(i, kNewYearsEve + i, 0);
  Imported imported;
  ASSERT_EQ(import(imported, file), "");
  EXPECT_DOUBLE_EQ(imported.seconds_after_first("/sonic/wind", 4), 6);
  EXPECT_THAT(imported.remarks(), HasSubstr("by its times 2 rows are missing"));
}

TEST(Tob1, SaysWhatIsWrong) {
  const auto error_of = [](const std::string& file) {
    Imported imported;
    return import(imported, file, SonicFormat::tob1);
  };
  EXPECT_THAT(error_of(kStation), HasSubstr("the five header lines of a TOB1 file are not complete"));
  EXPECT_THAT(error_of(kHead), HasSubstr("no rows"));
  auto other = kHead;
  other.replace(3, 2, "B3");
  EXPECT_THAT(error_of(other), HasSubstr("begins with TOB3, not TOB1: convert it"));
  auto unknown = kHead;
  unknown.replace(unknown.find("IEEE4"), 5, "FP4");
  EXPECT_THAT(error_of(unknown), HasSubstr("fast.dat:5: type 'FP4' is not known; known are FP2"));
  auto fewer = kHead;
  fewer.replace(fewer.find(",\"ASCII(4)\""), 11, "");
  EXPECT_THAT(error_of(fewer), HasSubstr("7 types for 8 columns"));
  for (const char* size : {"ASCII(0)", "ASCII(99999)", "ASCII(4", "ASCII(-4)", "ASCII"}) {
    auto odd = kHead;
    odd.replace(odd.find("ASCII(4)"), 8, size);
    EXPECT_THAT(error_of(odd), HasSubstr("is not known")) << size;
  }
}

}  // namespace
}  // namespace roseau::recorder
