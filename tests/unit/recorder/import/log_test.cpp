// Logs of what instruments sent, written here line by line and byte by byte.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "recorder/tools/import/log_clock.h"
#include "recorder/tools/import/log_reader.h"
#include "recorder/tools/import/record_times.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/recorder/import/imported.h"

namespace roseau::recorder {
namespace {

using roseau::testing::TemporaryFolder;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;

// With its checksum, worked out here.
std::string sentence(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  return "$" + body + "*" + kDigits[sum / 16] + kDigits[sum % 16];
}
std::string mwv(int angle_deg) { return sentence("WIMWV," + std::to_string(angle_deg) + ",R,2.5,M,A"); }

std::string tags(const std::string& u) {
  return "S2  02.222 D  255 U  " + u + " V  00.592 W  00.040 T  23.80 H  29.14 MD  349";
}

class LogTest : public ::testing::Test {
 protected:
  std::string import(const std::string& text, std::optional<double> rate_hz = std::nullopt) {
    auto plan = sonic_plan(folder_.write("log.txt", text));
    plan.sonics[0].file.rate_hz = rate_hz;
    return imported_.run(plan);
  }
  std::string when(std::size_t index) const { return format_time_stamp(imported_.civil("/sonic/wind", index)); }
  std::size_t winds() const {
    const auto found = imported_.samples.find("/sonic/wind");
    return found == imported_.samples.end() ? 0 : found->second.size();
  }

  const TemporaryFolder folder_;
  Imported imported_;
};

TEST_F(LogTest, NmeaWithTheLoggersStampsOverTheNewYear) {
  for (const char* form :
       {"2024-12-31 23:59:{} ", "2024-12-31T23:59:{}Z,", "[2024-12-31 23:59:{}] ", "2024/12/31 23:59:{}\t"}) {
    std::string text;
    for (const char* second : {"59.0", "59.5"}) {
      auto stamp = std::string(form);
      text += stamp.replace(stamp.find("{}"), 2, second) + mwv(90) + "\r\n";
    }
    text += "2025-01-01 00:00:00.0 " + mwv(180) + "\r\n";
    Imported imported;
    ASSERT_EQ(imported.run(sonic_plan(folder_.write("log.txt", text))), "") << form;
    ASSERT_EQ(imported.samples.at("/sonic/wind").size(), 3U) << form;
    EXPECT_EQ(format_time_stamp(imported.civil("/sonic/wind", 0)), "2024-12-31T23:59:59.000") << form;
    EXPECT_EQ(format_time_stamp(imported.civil("/sonic/wind", 2)), "2025-01-01T00:00:00.000") << form;
    EXPECT_NEAR(imported.payload<WindSample>("/sonic/wind", 2).u_mps, 2.5, 1e-9) << "from the south";
  }
}

TEST_F(LogTest, WhatTheInstrumentSentIsKeptAsItIs) {
  ASSERT_EQ(import("1735689599.5 " + mwv(90) + "\n1735689600 " + mwv(91) + "\n"), "");
  const auto& raw = imported_.payload<RawBytes>("/sonic/raw", 1);
  const auto bytes = raw.bytes();
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()), mwv(91) + "\r\n");
  EXPECT_EQ(when(0), "2024-12-31T23:59:59.500");
  const auto& info = imported_.streams.info(*imported_.streams.find("/sonic/raw"));
  EXPECT_EQ(info.metadata.at("model"), "nmea0183");
  EXPECT_EQ(info.metadata.at("sentence"), "mwv_r");
  EXPECT_EQ(imported_.streams.info(*imported_.streams.find("/sonic/wind")).role, StreamRole::derived);
}

TEST_F(LogTest, TimesOfDayPassMidnight) {
  ASSERT_EQ(
      import("23:59:58.0," + mwv(1) + "\n23:59:59.0," + mwv(2) + "\n00:00:00.0," + mwv(3) + "\n00:00:01.0," + mwv(4) + "\n"),
      "");
  ASSERT_EQ(winds(), 4U);
  EXPECT_DOUBLE_EQ(imported_.seconds_after_first("/sonic/wind", 3), 3);
  EXPECT_FALSE(imported_.utc_minus_host_time) << "no date anywhere";
  EXPECT_THAT(imported_.remarks(), HasSubstr("times of day without a date"));
}

TEST_F(LogTest, TimesOfDayTakeTheDateFromASentence) {
  ASSERT_EQ(import("23:59:58.0," + mwv(1) + "\n23:59:59.0," + mwv(2) + "\n00:00:00.0," + mwv(3) + "\n00:00:00.5," +
                   sentence("GPZDA,000000.40,01,01,2025,00,00") + "\n"),
            "");
  EXPECT_EQ(when(0), "2024-12-31T23:59:58.000");
  EXPECT_EQ(when(2), "2025-01-01T00:00:00.000");
}

TEST_F(LogTest, SentencesTellTheTimeWhereTheLoggerDoesNot) {
  std::string text = mwv(5) + "\r\n";
  for (int s = 58; s < 60; ++s) {
    text += sentence("GPZDA,2359" + std::to_string(s) + ",31,12,2024,00,00") + "\r\n" + mwv(10) + "\r\n" + mwv(20) + "\r\n" +
            mwv(30) + "\r\n";
  }
  text += sentence("GPRMC,000000,A,4807.038,N,01131.000,E,022.4,084.4,010125,003.1,W") + "\r\n" + mwv(40) + "\r\n";
  ASSERT_EQ(import(text), "");
  ASSERT_EQ(winds(), 8U);
  EXPECT_EQ(when(4), "2024-12-31T23:59:59.250") << "evenly between the sentences with times";
  EXPECT_EQ(when(6), "2024-12-31T23:59:59.750");
  EXPECT_EQ(when(7), "2025-01-01T00:00:00.500");
  EXPECT_THAT(imported_.remarks(), HasSubstr("ZDA and RMC"));
}

TEST_F(LogTest, StampsOfWholeSecondsAreSpread) {
  std::string text;
  for (int i = 0; i < 12; ++i) text += "2024-05-01 10:00:0" + std::to_string(i / 4) + " " + mwv(i) + "\n";
  ASSERT_EQ(import(text), "");
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_DOUBLE_EQ(imported_.seconds_after_first("/sonic/wind", i), 0.25 * static_cast<double>(i));
  }
  EXPECT_THAT(imported_.remarks(), HasSubstr("in steps of 1 s"));
}

TEST_F(LogTest, AClockThatStepsBackALittleIsHeldALotIsRefused) {
  ASSERT_EQ(import("2024-05-01 10:00:00 " + mwv(1) + "\n2024-05-01 10:00:05 " + mwv(2) + "\n2024-05-01 10:00:04 " + mwv(3) +
                   "\n2024-05-01 10:00:06 " + mwv(4) + "\n"),
            "");
  EXPECT_GE(imported_.seconds_after_first("/sonic/wind", 2), 5);
  EXPECT_THAT(imported_.remarks(), HasSubstr("stepped back 1 times, by 1.000 s at most"));
  EXPECT_THAT(import("2024-05-01 10:00:00 " + mwv(1) + "\n2024-05-01 09:00:00 " + mwv(2) + "\n"),
              HasSubstr("its time goes back by 3600.0 s"));
}

TEST_F(LogTest, WithoutTimesTheRateMustBeGiven) {
  const auto text = mwv(1) + "\n" + mwv(2) + "\n" + mwv(3) + "\n";
  EXPECT_THAT(import(text), HasSubstr("the rate of its lines must be given in Hz"));
  ASSERT_EQ(import(text, 4.0), "");
  EXPECT_DOUBLE_EQ(imported_.seconds_after_first("/sonic/wind", 2), 0.5);
}

TEST_F(LogTest, DamagedSentencesAreCounted) {
  auto wrong = mwv(2);
  wrong[9] = '9';
  ASSERT_EQ(import("10:00:00 " + mwv(1) + "\n10:00:01 " + wrong + "\n10:00:02 " + mwv(3).substr(0, 12) + "\n10:00:03 " +
                   sentence("WIMWV,10,R,2.5,M") + "\n10:00:04 " + mwv(5) + "\n10:00:05 " + mwv(6).substr(0, 9)),
            "");
  EXPECT_EQ(winds(), 2U);
  EXPECT_EQ(imported_.samples.at("/sonic/raw").size(), 6U) << "raw is raw";
  EXPECT_THAT(imported_.remarks(), HasSubstr("decoded: 2 records, 3 damaged"));
  EXPECT_THAT(imported_.remarks(), HasSubstr("the last line is cut short"));
}

TEST_F(LogTest, ALogWithoutAnyChecksumIsTaken) {
  ASSERT_EQ(import("10:00:00 $WIMWV,10,R,2.5,M,A\n10:00:01 $WIMWV,20,R,2.5,M,A\n"), "");
  EXPECT_EQ(winds(), 2U);
  EXPECT_THAT(imported_.remarks(), HasSubstr("no sentence has a checksum"));
}

TEST_F(LogTest, TriSonicaLinesWithStamps) {
  ASSERT_EQ(import("2024-05-01 10:00:00.0," + tags("02.142") + "\n2024-05-01 10:00:00.1," + tags("02.143") +
                   "\n2024-05-01 10:00:00.2,S2  02.2\n2024-05-01 10:00:00.3," + tags("02.145") + "\n"),
            "");
  ASSERT_EQ(winds(), 3U);
  EXPECT_EQ(imported_.payload<WindSample>("/sonic/wind", 1).u_mps, 2.143);
  EXPECT_DOUBLE_EQ(imported_.seconds_after_first("/sonic/wind", 2), 0.3);
  EXPECT_THAT(imported_.remarks(), HasSubstr("points to 349.0 degrees magnetic"));
}

// A logger's milliseconds that run 50 ppm fast, with GPS seconds that appear a little late.
std::string gps_line(double true_s, std::uint32_t millis, bool has_fix) {
  const auto second = static_cast<int>(true_s);
  const int time = 235950 + second < 236000 ? 235950 + second : second - 10;
  const bool is_next_day = 235950 + second >= 236000;
  const std::string place = has_fix ? "39.252422,-119.878113," : "1000.000000,1000.000000,";
  return std::to_string(millis) + "," + place + std::to_string(time) + "00," + (is_next_day ? "10125" : "311224") + "," +
         tags("02.142") + "\n";
}

TEST_F(LogTest, MillisecondsAreLaidOnGpsTimeOverTheNewYear) {
  std::string text = "# a remark\n650,1000.000000,1000.000000,4294967295,0,S2  02.008 D  255 U  01.9S2  02.338\n";
  constexpr std::uint32_t kStart = 4'294'965'000U;  // wraps soon
  for (int i = 0; i < 400; ++i) {
    const double true_s = i * 0.1 + 0.03;
    text += gps_line(true_s, kStart + static_cast<std::uint32_t>(std::lround(true_s * 1000 * 1.00005)), i > 30);
  }
  // Starts with other milliseconds: another start of the logger.
  ASSERT_EQ(import(text.substr(text.find("\n", 20) + 1)), "");
  ASSERT_EQ(winds(), 400U);
  const auto first = imported_.civil("/sonic/wind", 0);
  const auto truth = *parse_time_stamp("2024-12-31 23:59:50") + milliseconds{30};
  EXPECT_LT(std::abs((first - truth).count()), 40'000'000) << format_time_stamp(first);
  EXPECT_EQ(format_time_stamp(imported_.civil("/sonic/wind", 110)).substr(0, 19), "2025-01-01T00:00:01");
  EXPECT_NEAR(imported_.seconds_after_first("/sonic/wind", 399), 39.9, 0.01) << "over the wrap of 32 bits";
}

TEST_F(LogTest, WithoutAFixMillisecondsAreAllThereIs) {
  std::string text;
  for (int i = 0; i < 30; ++i) text += gps_line(i * 0.1, static_cast<std::uint32_t>(500 + i * 100), false);
  ASSERT_EQ(import(text), "");
  EXPECT_FALSE(imported_.utc_minus_host_time);
  EXPECT_DOUBLE_EQ(imported_.seconds_after_first("/sonic/wind", 29), 2.9);
  EXPECT_THAT(imported_.remarks(), HasSubstr("no GPS fix"));
}

TEST_F(LogTest, ALoggerThatStartedAgainGoesOn) {
  std::string text;
  for (int i = 0; i < 30; ++i) text += gps_line(i * 0.1, static_cast<std::uint32_t>(50'000 + i * 100), false);
  for (int i = 30; i < 60; ++i) text += gps_line(i * 0.1, static_cast<std::uint32_t>(500 + i * 100), false);
  ASSERT_EQ(import(text), "");
  EXPECT_EQ(winds(), 60U);
  EXPECT_THAT(imported_.remarks(), HasSubstr("the logger started 2 times"));
  EXPECT_DOUBLE_EQ(imported_.seconds_after_first("/sonic/wind", 59), 5.8);
}

// Blocks as the Teensy wrote them.
std::string block_number(std::uint64_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xFFU);
  return bytes;
}
std::string block_record(std::uint32_t millis, std::uint32_t time, std::uint32_t date, std::string text) {
  text.resize(128);
  return block_number(millis) + block_number(std::bit_cast<std::uint32_t>(39.25F)) +
         block_number(std::bit_cast<std::uint32_t>(-119.9F)) + block_number(time) + block_number(date) + text;
}
std::string block(const std::vector<std::string>& records) {
  auto bytes = block_number(records.size());
  for (const auto& record : records) bytes += record;
  bytes.resize(16384);
  return bytes;
}

TEST_F(LogTest, BlocksOfATeensy) {
  const auto second = [](int i) { return static_cast<std::uint32_t>(1'000'000 + 100 * (i / 10)); };
  const auto millis = [](int i) { return static_cast<std::uint32_t>(1000 + 100 * i); };
  std::vector<std::string> first;
  first.push_back(block_record(millis(0), second(0), 10524, tags("00.001") + " "));
  // A line in two records, whose rest begins without a line feed.
  first.push_back(block_record(millis(1), second(1), 10524, "\n" + tags("00.002").substr(0, 40)));
  first.push_back(block_record(millis(1), second(1), 10524, tags("00.002").substr(40) + " "));
  for (int i = 2; i < 40; ++i) first.push_back(block_record(millis(i), second(i), 10524, "\n" + tags("00.003") + " "));
  folder_.write("0000001.bin", block(first));
  const auto second_file = block({block_record(millis(40), second(40), 10524, "\n" + tags("00.004") + " "),
                                  block_record(millis(41), second(41), 10524, "\n" + tags("00.005") + " "),
                                  block_record(millis(42), second(42), 10524, "\n" + tags("00.006") + " ")});
  folder_.write("0000002.bin", second_file.substr(0, 4 + 148 * 2 + 50));
  ASSERT_EQ(imported_.run(sonic_plan(folder_.path().string())), "");
  ASSERT_EQ(winds(), 42U);
  EXPECT_EQ(imported_.payload<WindSample>("/sonic/wind", 1).u_mps, 0.002);
  EXPECT_EQ(imported_.payload<WindSample>("/sonic/wind", 41).u_mps, 0.005);
  EXPECT_NEAR(imported_.seconds_after_first("/sonic/wind", 41), 4.1, 1e-6);
  EXPECT_THAT(imported_.remarks(), HasSubstr("the last line is cut short"));
  folder_.write("0000003.bin", block_number(111) + std::string(16380, '\0'));
  EXPECT_THAT(imported_.run(sonic_plan((folder_.path() / "0000003.bin").string(), SonicFormat::trisonica)),
              ::testing::AnyOf(HasSubstr("a block of 111 records"), HasSubstr("no line of a TriSonica")));
}

TEST_F(LogTest, SaysWhatIsWrong) {
  const auto error_of = [&](const std::string& text, SonicFormat format) {
    Imported imported;
    return imported.run(sonic_plan(folder_.write("x.txt", text), format));
  };
  EXPECT_THAT(error_of("", SonicFormat::nmea), HasSubstr("no lines"));
  EXPECT_THAT(error_of("hello\n", SonicFormat::nmea), HasSubstr("no sentence with wind"));
  EXPECT_THAT(error_of("hello\n", SonicFormat::trisonica), HasSubstr("no line of a TriSonica"));
  EXPECT_THAT(error_of(std::string(70'000, 'x'), SonicFormat::nmea), HasSubstr("a line of more than 65536 bytes"));
  EXPECT_THAT(error_of("10:00:00 " + mwv(1) + "\n10:00:01 " + tags("02.142") + "\n", SonicFormat::automatic),
              HasSubstr("its format is not clear"));
  EXPECT_THAT(error_of(std::string("\x01\x02\x03\x04\x05\x06\x07\x08", 8), SonicFormat::automatic),
              HasSubstr("its format is not clear"));
  EXPECT_THAT(error_of("", SonicFormat::automatic), HasSubstr("the file is empty"));
}

TEST(GpsTime, IsReadFromItsNumbers) {
  EXPECT_EQ(parse_gps_time(17503950, 70721), *parse_time_stamp("2021-07-07 17:50:39.5"));
  EXPECT_EQ(parse_gps_time(0, 10125), *parse_time_stamp("2025-01-01 00:00:00"));
  EXPECT_FALSE(parse_gps_time(0, 0)) << "no date yet";
  EXPECT_FALSE(parse_gps_time(4294967295U, 70721));
  EXPECT_FALSE(parse_gps_time(24000000, 70721));
  EXPECT_FALSE(parse_gps_time(0, 310225));
}

}  // namespace
}  // namespace roseau::recorder
