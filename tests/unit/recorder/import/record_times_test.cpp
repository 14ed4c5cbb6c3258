#include "recorder/tools/import/record_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/recorder/import/read_record.h"

namespace roseau::recorder {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<Duration> stamps_ms(std::initializer_list<int> times_ms) {
  std::vector<Duration> stamps;
  for (const int time_ms : times_ms) stamps.push_back(milliseconds{time_ms});
  return stamps;
}

TEST(TimeStamp, ReadsWhatLoggersWrite) {
  const Duration noon = std::chrono::hours{24 * 18107 + 12};  // 2019-07-30 12:00
  EXPECT_EQ(parse_time_stamp("2019-07-30 12:00:00"), noon);
  EXPECT_EQ(parse_time_stamp("2019-07-30T12:00:00Z"), noon);
  EXPECT_EQ(parse_time_stamp("2019-07-30 12:00"), noon);
  EXPECT_EQ(parse_time_stamp("2019-07-30 12:00:00.05"), noon + milliseconds{50});
  EXPECT_EQ(parse_time_stamp("2019-07-29 24:00:00"), noon - std::chrono::hours{12});
  EXPECT_EQ(parse_time_stamp("12.5"), milliseconds{12'500});
  EXPECT_EQ(parse_time_stamp("-0.25"), milliseconds{-250});
  for (const char* wrong : {"", "noon", "2019-13-30 12:00:00", "2019-02-29 12:00:00", "2019-07-30 12:61:00",
                            "2019-07-30 12:00:00x", "2019-07-30", "30.07.2019 12:00:00", "1e300"}) {
    EXPECT_FALSE(parse_time_stamp(wrong)) << wrong;
  }
}

TEST(TimeStamp, IsWrittenAsItIsRead) {
  for (const char* text : {"2019-07-30T12:00:00.050", "1970-01-01T00:00:00.000", "1969-12-31T23:59:59.999"}) {
    EXPECT_EQ(format_time_stamp(*parse_time_stamp(text)), text);
  }
}

TEST(RecordTimes, WithoutStampsTheRateCounts) {
  const auto times = place_records(4, {}, 4.0, "file");
  ASSERT_TRUE(times);
  EXPECT_THAT(times->since_first, ElementsAre(Duration{0}, milliseconds{250}, milliseconds{500}, milliseconds{750}));
  EXPECT_EQ(times->rate_hz, 4.0);
}

TEST(RecordTimes, ThirdsOfASecondDoNotDrift) {
  const auto times = place_records(3'000'001, {}, 30.0, "file");
  ASSERT_TRUE(times);
  EXPECT_EQ(times->since_first.back(), seconds{100'000});
}

TEST(RecordTimes, RoundedStampsGiveARegularGrid) {
  const auto times = place_records(5, stamps_ms({10'000, 10'033, 10'067, 10'100, 10'133}), std::nullopt, "file");
  ASSERT_TRUE(times);
  EXPECT_DOUBLE_EQ(times->rate_hz, 30.0);
  EXPECT_EQ(times->since_first[1], from_seconds(1 / 30.0));
  EXPECT_EQ(times->since_first[4], from_seconds(4 / 30.0));
  EXPECT_EQ(times->missing_rows, 0U);
}

TEST(RecordTimes, HolesStayHoles) {
  const auto times = place_records(5, stamps_ms({0, 50, 100, 350, 400}), std::nullopt, "file");
  ASSERT_TRUE(times);
  EXPECT_DOUBLE_EQ(times->rate_hz, 20.0);
  EXPECT_EQ(times->missing_rows, 4U);
  EXPECT_EQ(times->since_first[3], milliseconds{350});
}

TEST(RecordTimes, WholeSecondsOfAFastRecordNeedTheRate) {
  const auto stamps = stamps_ms({0, 0, 1000, 1000, 2000, 2000});
  const auto unknown = place_records(6, stamps, std::nullopt, "file");
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("file: its times are too coarse to tell the rate: give it in Hz"));
  const auto known = place_records(6, stamps, 2.0, "file");
  ASSERT_TRUE(known);
  EXPECT_EQ(known->since_first[5], milliseconds{2500});
}

TEST(RecordTimes, IrregularStampsAreTheTimes) {
  const auto times = place_records(5, stamps_ms({0, 100, 101, 200, 300}), std::nullopt, "file");
  ASSERT_TRUE(times);
  EXPECT_THAT(times->since_first,
              ElementsAre(Duration{0}, milliseconds{100}, milliseconds{101}, milliseconds{200}, milliseconds{300}));
}

TEST(RecordTimes, SaysWhatIsWrong) {
  EXPECT_THAT(place_records(2, {}, std::nullopt, "file").error().message, HasSubstr("the rate must be given in Hz"));
  EXPECT_THAT(place_records(2, {}, -1.0, "file").error().message, HasSubstr("a rate of -1 Hz makes no sense"));
  EXPECT_THAT(place_records(3, stamps_ms({0, 100, 50}), std::nullopt, "file").error().message,
              HasSubstr("the time goes back at row 3"));
  EXPECT_THAT(place_records(3, stamps_ms({0, 100, 200}), 4.0, "file").error().message, HasSubstr("closer together than 4 Hz"));
}

}  // namespace
}  // namespace roseau::recorder
