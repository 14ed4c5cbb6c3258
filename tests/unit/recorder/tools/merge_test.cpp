#include "recorder/tools/merge/merge_sessions.h"

#include <gmock/gmock.h>

#include "recorder/tools/cut/cut_session.h"
#include "recorder/tools/inspect/verification.h"
#include "schema/conversion.h"
#include "tests/support/session_file.h"
#include "tests/support/temporary_folder.h"

namespace roseau::recorder {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::messages_of;

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(ClockShift, ConstantOffsetsOnlyDiffer) {
  const CivilOffset a(Duration{100 * kSecond});
  const CivilOffset b(Duration{130 * kSecond});
  EXPECT_EQ(to_ns(moved(host_time_from_ns(5 * kSecond), b, a)), 35 * kSecond);
  EXPECT_EQ(to_ns(moved(host_time_from_ns(35 * kSecond), a, b)), 5 * kSecond);
}

TEST(ClockShift, BetweenRecordedOffsetsStraightLines) {
  const CivilOffset a(Duration{0});
  const CivilOffset b({{host_time_from_ns(0), Duration{1000}}, {host_time_from_ns(10 * kSecond), Duration{2000}}});
  EXPECT_EQ(to_ns(moved(host_time_from_ns(5 * kSecond), b, a)), 5 * kSecond + 1500);
  EXPECT_EQ(to_ns(moved(host_time_from_ns(-kSecond), b, a)), -kSecond + 1000);
  EXPECT_EQ(to_ns(moved(host_time_from_ns(60 * kSecond), b, a)), 60 * kSecond + 2000);
  // And back again, where what is sought stands on both sides.
  const HostTime there = moved(host_time_from_ns(7 * kSecond), b, a);
  EXPECT_LE(std::abs(to_ns(moved(there, a, b)) - 7 * kSecond), 1);
}

class MergeTest : public ::testing::Test {
 protected:
  std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }
  MergeReport merge(const std::vector<std::string>& names, const std::string& out, const MergeOptions& options = {}) const {
    std::vector<std::filesystem::path> files;
    for (const auto& name : names) files.push_back(path(name));
    const auto report = merge_sessions(files, path(out), options);
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    const auto verification = verify_session(path(out));
    EXPECT_TRUE(verification) << out;
    if (verification) {
      EXPECT_THAT(verification->problems, IsEmpty());
    }
    return report ? *report : MergeReport{};
  }
  /// Another host, whose clock began `earlier_s` before the first one's, recording the same ten seconds.
  void write_other_host(const std::string& name, double earlier_s, const std::string& host = "mast") const {
    testing::SessionFile file(host_time_from_ns(1'000 * kSecond) + from_seconds(earlier_s));
    file.description.utc_minus_host_time = Duration{1'700'000'000 * kSecond} - from_seconds(earlier_s);
    file.description.other = {{"name", "storm on the mast"}, {"host", host}};
    file.write(path(name), 10);
  }
  const testing::TemporaryFolder folder_;
};

TEST_F(MergeTest, CutsThatOverlapGiveTheWholeAgain) {
  testing::SessionFile().write(path("s.mcap"), 10);
  ASSERT_TRUE(cut_session(path("s.mcap"), path("a.mcap"), {.to = "6"}));
  ASSERT_TRUE(cut_session(path("s.mcap"), path("b.mcap"), {.from = "4"}));
  const auto report = merge({"b.mcap", "a.mcap"}, "m.mcap");
  EXPECT_EQ(messages_of(path("m.mcap")), messages_of(path("s.mcap")));
  EXPECT_EQ(report.duplicates, 2U * 30U + 2U) << "two seconds of both streams, calibration and target";
  EXPECT_EQ(report.inputs[0].group, report.inputs[1].group);
  EXPECT_THAT(report.renamed, IsEmpty());
  const auto reader = testing::open_session(path("m.mcap"));
  EXPECT_EQ(reader->index().attachments.size(), 2U) << "the parts have the same";
}

TEST_F(MergeTest, AnotherHostComesOntoTheFirstAxis) {
  testing::SessionFile().write(path("s.mcap"), 10);
  write_other_host("t.mcap", 500.0000001);
  const auto report = merge({"s.mcap", "t.mcap"}, "m.mcap");
  EXPECT_THAT(report.inputs[1].moved_by, HasSubstr("-500.0000001"));
  EXPECT_EQ(report.duplicates, 0U);

  const auto all = messages_of(path("m.mcap"));
  for (std::size_t i = 1; i < all.size(); ++i) ASSERT_GT(all[i].log_time_ns, all[i - 1].log_time_ns);
  EXPECT_EQ(messages_of(path("m.mcap"), "/sonic/wind").size(), 200U) << "the first host's names stay";
  const auto moved = messages_of(path("m.mcap"), "/mast/sonic/wind");
  const auto own = messages_of(path("t.mcap"), "/sonic/wind");
  ASSERT_EQ(moved.size(), own.size());
  StreamTable streams;
  for (std::size_t i = 0; i < own.size(); ++i) {
    const auto before = schema::parse(SampleKind::wind, own[i].data, {}, streams).value();
    const auto after = schema::parse(SampleKind::wind, moved[i].data, {}, streams).value();
    const Duration shift = from_seconds(500.0000001);
    ASSERT_EQ(after.header.sample_time, before.header.sample_time - shift);
    ASSERT_EQ(after.header.arrival_time, before.header.arrival_time - shift);
    ASSERT_EQ(after.header.sequence, before.header.sequence);
    ASSERT_EQ(std::get<WindSample>(after.payload).u_mps, std::get<WindSample>(before.payload).u_mps);
    ASSERT_EQ(moved[i].publish_time_ns, own[i].publish_time_ns - static_cast<std::uint64_t>(shift.count()));
  }
}

TEST_F(MergeTest, APartFromAfterAReboot) {
  testing::SessionFile before;
  before.description.session_id = "one";
  before.write(path("s.mcap"), 2);
  // The clock begins again: it shows 10 s when the old one would have shown 1010 s.
  testing::SessionFile after(host_time_from_ns(10 * kSecond));
  after.description.session_id = "one";
  after.description.first_part = 2;
  *after.description.utc_minus_host_time += Duration{1'000 * kSecond};
  after.write(path("t.mcap"), 2);
  const auto report = merge({"s.mcap", "t.mcap"}, "m.mcap");
  EXPECT_THAT(report.renamed, IsEmpty()) << "the same streams";
  const auto wind = messages_of(path("m.mcap"), "/sonic/wind");
  ASSERT_EQ(wind.size(), 80U);
  EXPECT_EQ(wind[40].log_time_ns - wind[0].log_time_ns, 10U * kSecond);
}

TEST_F(MergeTest, NamesAreKeptApart) {
  testing::SessionFile().write(path("s.mcap"), 1);
  write_other_host("t.mcap", 3);
  const auto report = merge({"s.mcap", "t.mcap"}, "m.mcap");
  EXPECT_EQ(report.renamed.at("t.mcap /camera0/image"), "/mast/camera0/image");
  const auto reader = testing::open_session(path("m.mcap"));
  const auto* channel = reader->channel_of_topic("/mast/camera0/image");
  ASSERT_NE(channel, nullptr);
  EXPECT_EQ(channel->metadata.at("roseau.device"), "mast.camera0");
  std::vector<std::string> names;
  for (const auto& attachment : reader->index().attachments) names.push_back(attachment.name);
  EXPECT_THAT(names, ::testing::ElementsAre("config.toml", "site.toml", "mast/config.toml", "mast/site.toml"));
  EXPECT_EQ(reader->find_metadata("roseau").value()->metadata.at("name"), "storm");
  EXPECT_EQ(reader->find_metadata("mast/roseau").value()->metadata.at("name"), "storm on the mast");
  EXPECT_TRUE(reader->find_metadata("roseau.merge").value());
  const auto counters = mcap::counters_from(reader->find_metadata(mcap::kCountersMetadata).value().value());
  EXPECT_EQ(counters.value().at("/mast/sonic/wind").recorded, 200U);
}

TEST_F(MergeTest, APrefixGoesBeforeTheHostsName) {
  testing::SessionFile().write(path("s.mcap"), 1);
  write_other_host("t.mcap", 3);
  merge({"s.mcap", "t.mcap"}, "m.mcap", {.prefixes = {"ground", "top"}});
  const auto reader = testing::open_session(path("m.mcap"));
  EXPECT_NE(reader->channel_of_topic("/ground/sonic/wind"), nullptr);
  EXPECT_NE(reader->channel_of_topic("/top/sonic/wind"), nullptr);
  EXPECT_EQ(reader->channel_of_topic("/sonic/wind"), nullptr);
  EXPECT_FALSE(merge_sessions({path("s.mcap")}, path("n.mcap"), {.prefixes = {"a", "b"}}));
}

TEST_F(MergeTest, AHostsOwnClockRecordGoesBeforeItsConstant) {
  testing::SessionFile().write(path("s.mcap"), 1);
  testing::SessionFile file(host_time_from_ns(2'000 * kSecond));
  file.description.utc_minus_host_time = Duration{0};
  file.description.other = {{"name", "other"}, {"host", "mast"}};
  file.streams.add({.topic = "/host/clock", .kind = "clock_state", .role = StreamRole::raw, .device = "utc"});
  file.open(path("t.mcap"));
  // Civil time is 1.7e9 s ahead of this host at first, and 1 ms more ten seconds later.
  file.add("/host/clock", 0, 0, ClockState{.device = "utc", .offset_s = -1'699'999'000.0});
  file.add("/other/wind", 5, 0, testing::SessionFile::wind(1));
  file.add("/host/clock", 10, 1, ClockState{.device = "utc", .offset_s = -1'699'999'000.001});
  file.close();
  merge({"s.mcap", "t.mcap"}, "m.mcap");
  const auto wind = messages_of(path("m.mcap"), "/other/wind");
  ASSERT_EQ(wind.size(), 1U);
  // 2005 s there is 1005 s here, and 0.5 ms for half of the way; the clock stands in the file to a quarter of a microsecond.
  EXPECT_NEAR(static_cast<double>(wind[0].log_time_ns) - 1'005e9, 0.5e6, 1e3);
}

TEST_F(MergeTest, HostsThatDoNotKnowCivilTimeCannotBeCompared) {
  testing::SessionFile().write(path("s.mcap"), 1);
  testing::SessionFile file;
  file.description.utc_minus_host_time.reset();
  file.description.other = {{"name", "other"}};
  file.write(path("t.mcap"), 1);
  const auto report = merge_sessions({path("s.mcap"), path("t.mcap")}, path("m.mcap"));
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr("t.mcap"));
  EXPECT_FALSE(std::filesystem::exists(path("m.mcap")));
}

TEST_F(MergeTest, NothingIsOverwritten) {
  testing::SessionFile().write(path("s.mcap"), 1);
  folder_.write("m.mcap", "precious");
  EXPECT_FALSE(merge_sessions({path("s.mcap")}, path("m.mcap")));
  EXPECT_EQ(testing::read_text_file(path("m.mcap")), "precious");
}

}  // namespace
}  // namespace roseau::recorder
