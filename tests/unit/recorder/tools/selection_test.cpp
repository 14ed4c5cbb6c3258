#include "recorder/tools/selection/selection.h"

#include <gmock/gmock.h>

#include "recorder/tools/selection/civil_time.h"

namespace roseau::recorder {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(CivilTime, IsCutOffNotRounded) {
  EXPECT_EQ(utc_text(1'999'999'999, 3), "1970-01-01T00:00:01.999Z");
  EXPECT_EQ(utc_text(-1, 0), "1969-12-31T23:59:59Z");
  EXPECT_EQ(utc_text(1'582'934'400 * kSecond, 9, ' ', ""), "2020-02-29 00:00:00.000000000");
}

TEST(CivilTime, IsReadInEverySpelling) {
  const std::int64_t expected = 1'582'934'400 * kSecond;
  for (const char* text : {"2020-02-29T00:00:00Z", "2020-02-29 00:00:00", "2020-02-29", "2020-02-29T00:00Z",
                           "2020-02-29T02:00:00+02:00", "2020-02-28T23:30:00-0030", "2020-02-29t00:00:00.000z"}) {
    EXPECT_EQ(parse_utc(text), expected) << text;
  }
  EXPECT_EQ(parse_utc("2020-02-29T00:00:00.123456789Z"), expected + 123'456'789);
  EXPECT_EQ(parse_utc(utc_text(expected + 987'654'321, 9)), expected + 987'654'321);
  for (const char* text : {"", "2020", "2020-02-30", "2020-02-29T25:00", "2020-02-29T00:00:00Q", "2020-02-29T00:00:00.",
                           "20-02-29", "2020-02-29T00:00:00Z ", "-020-02-29", "2300-01-01"}) {
    EXPECT_FALSE(parse_utc(text)) << text;
  }
}

TEST(TimePoint, TellsItsAxis) {
  const auto axis = [](const char* text) { return parse_time_point(text).value().axis; };
  EXPECT_EQ(axis("12.5"), TimePoint::Axis::session);
  EXPECT_EQ(axis("999999999"), TimePoint::Axis::session);
  EXPECT_EQ(axis("12s"), TimePoint::Axis::session);
  EXPECT_EQ(axis("1000000000"), TimePoint::Axis::host);
  EXPECT_EQ(axis("5ns"), TimePoint::Axis::host);
  EXPECT_EQ(axis("2020-02-29T00:00:00Z"), TimePoint::Axis::utc);
  EXPECT_EQ(parse_time_point("1.5").value().since, Duration{1'500'000'000});
  for (const char* text : {"", "soon", "1.5ns", "nan", "1e300", "12 s"}) {
    const auto point = parse_time_point(text);
    ASSERT_FALSE(point) << text;
    EXPECT_THAT(point.error().message, HasSubstr("is no time"));
  }
}

class SelectionTest : public ::testing::Test {
 protected:
  SelectionTest() {
    const std::vector<std::string> topics = {"/camera0/image", "/camera1/image", "/sonic/wind", "/truth/sonic/wind"};
    for (const auto& topic : topics) {
      const auto id = static_cast<std::uint16_t>(index.catalog.channels().size() + 1);
      EXPECT_TRUE(index.catalog.add(mcap::Channel{.id = id, .topic = topic}));
    }
    index.statistics.message_start_time_ns = 100 * kSecond;
    index.statistics.message_end_time_ns = 110 * kSecond;
  }
  Selection selected(const SelectionOptions& options) const {
    const auto selection = select(options, index, Duration{1'000 * kSecond});
    EXPECT_TRUE(selection) << (selection ? "" : selection.error().message);
    return selection ? *selection : Selection{};
  }
  std::string refusal(const SelectionOptions& options, std::optional<Duration> utc = Duration{0}) const {
    const auto selection = select(options, index, utc);
    EXPECT_FALSE(selection);
    return selection ? "" : selection.error().message;
  }
  mcap::FileIndex index;
};

TEST_F(SelectionTest, EverythingByItself) {
  const auto selection = selected({});
  EXPECT_EQ(selection.first_time_ns, 0U);
  EXPECT_THAT(selection.channels, ElementsAre(1, 2, 3, 4));
}

TEST_F(SelectionTest, FromIsInsideAndToIsOutside) {
  const auto selection = selected({.from = "2", .to = "3.5"});
  EXPECT_FALSE(selection.holds_time(102 * kSecond - 1));
  EXPECT_TRUE(selection.holds_time(102 * kSecond));
  EXPECT_TRUE(selection.holds_time(103 * kSecond + kSecond / 2 - 1));
  EXPECT_FALSE(selection.holds_time(103 * kSecond + kSecond / 2));
}

TEST_F(SelectionTest, ThreeAxesNameTheSameTime) {
  const auto expected = selected({.from = "2"}).first_time_ns;
  EXPECT_EQ(selected({.from = "102000000000"}).first_time_ns, expected);
  EXPECT_EQ(selected({.from = "1970-01-01T00:18:22Z"}).first_time_ns, expected);
}

TEST_F(SelectionTest, ALengthGoesFromEitherEnd) {
  EXPECT_EQ(selected({.seconds = 3}).last_time_ns, 103ULL * kSecond - 1);
  EXPECT_EQ(selected({.from = "2", .seconds = 3}).last_time_ns, 105ULL * kSecond - 1);
  EXPECT_EQ(selected({.to = "9", .seconds = 3}).first_time_ns, 106ULL * kSecond);
  EXPECT_THAT(refusal({.from = "1", .to = "2", .seconds = 1}), HasSubstr("--for"));
  EXPECT_THAT(refusal({.seconds = -1}), HasSubstr("--for"));
}

TEST_F(SelectionTest, GlobsChooseTopics) {
  EXPECT_THAT(selected({.topics = {"/camera?/image"}}).channels, ElementsAre(1, 2));
  EXPECT_THAT(selected({.topics = {"*wind"}}).channels, ElementsAre(3, 4)) << "* goes over slashes";
  EXPECT_THAT(selected({.without = {"/truth/*"}}).channels, ElementsAre(1, 2, 3));
  EXPECT_THAT(selected({.topics = {"/camera*", "/sonic/wind"}, .without = {"/camera1/*"}}).channels, ElementsAre(1, 3));
}

TEST_F(SelectionTest, WhatCannotBeIsRefusedInWords) {
  EXPECT_THAT(refusal({.from = "20"}), HasSubstr("10.000 s long"));
  EXPECT_THAT(refusal({.to = "0"}), HasSubstr("lies outside"));
  EXPECT_THAT(refusal({.from = "5", .to = "5"}), HasSubstr("nothing lies between"));
  EXPECT_THAT(refusal({.from = "1970-01-01"}, std::nullopt), HasSubstr("does not know civil time"));
  EXPECT_THAT(refusal({.topics = {"/sonic"}}), HasSubstr("/truth/sonic/wind"));
  EXPECT_THAT(refusal({.without = {"/nope"}}), HasSubstr("--without '/nope'"));
  EXPECT_THAT(refusal({.without = {"*"}}), HasSubstr("leave nothing"));
}

}  // namespace
}  // namespace roseau::recorder
