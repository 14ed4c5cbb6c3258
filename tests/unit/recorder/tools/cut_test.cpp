#include "recorder/tools/cut/cut_session.h"

#include <gmock/gmock.h>

#include <fstream>

#include "recorder/tools/inspect/verification.h"
#include "schema/recorded_header.h"
#include "tests/support/session_file.h"
#include "tests/support/temporary_folder.h"

namespace roseau::recorder {
namespace {

using ::testing::HasSubstr;
using testing::HeldMessage;
using ::testing::IsEmpty;
using testing::messages_of;

class CutTest : public ::testing::Test {
 protected:
  std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }
  void SetUp() override { testing::SessionFile().write(path("s.mcap"), 10); }
  CutReport cut(const SelectionOptions& options, const std::string& out) const {
    const auto report = cut_session(path("s.mcap"), path(out), options);
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    return report ? *report : CutReport{};
  }
  void expect_whole(const std::string& name) const {
    const auto verification = verify_session(path(name));
    ASSERT_TRUE(verification);
    EXPECT_THAT(verification->problems, IsEmpty());
    EXPECT_TRUE(verification->is_complete);
  }
  /// The source's messages that a cut should hold.
  std::vector<HeldMessage> expected(double from_s, double to_s, const std::string& topic) const {
    auto messages = messages_of(path("s.mcap"), topic);
    const auto ns = [](double seconds) { return static_cast<std::uint64_t>(1e12 + seconds * 1e9); };
    std::erase_if(messages, [&](const HeldMessage& m) { return m.log_time_ns < ns(from_s) || m.log_time_ns >= ns(to_s); });
    return messages;
  }
  const testing::TemporaryFolder folder_;
};

TEST_F(CutTest, HoldsExactlyWhatLiesInside) {
  const auto report = cut({.from = "2.02", .to = "7.3"}, "c.mcap");
  expect_whole("c.mcap");
  for (const std::string topic : {"/sonic/wind", "/camera0/image"}) {
    EXPECT_EQ(messages_of(path("c.mcap"), topic), expected(2.02, 7.3, topic)) << topic;
  }
  EXPECT_GT(report.chunks_copied, 0U);
  EXPECT_GT(report.chunks_rebuilt, 0U);
  EXPECT_LE(report.chunks_rebuilt, 4U) << "only at the edges";
  EXPECT_TRUE(report.begins_in_mid_run);
}

TEST_F(CutTest, ChunksInsideAreTheSameBytes) {
  cut({.from = "3", .to = "6"}, "c.mcap");
  const std::string source = testing::read_text_file(path("s.mcap"));
  const std::string result = testing::read_text_file(path("c.mcap"));
  const auto reader = testing::open_session(path("c.mcap"));
  std::size_t copied = 0;
  for (const auto& block : reader->index().blocks) {
    if (source.find(result.substr(block.offset, block.length)) != std::string::npos) ++copied;
  }
  EXPECT_GE(copied + 4, reader->index().blocks.size());
  EXPECT_GT(copied, 10U);
}

TEST_F(CutTest, WithoutTopicsTheirChunksAreMadeAnew) {
  cut({.topics = {"/sonic/*"}}, "c.mcap");
  expect_whole("c.mcap");
  EXPECT_EQ(messages_of(path("c.mcap")), messages_of(path("s.mcap"), "/sonic/wind"));
  const auto reader = testing::open_session(path("c.mcap"));
  EXPECT_EQ(reader->catalog().channels().size(), 1U) << "nor are their channels there";
  EXPECT_EQ(reader->catalog().schemas().size(), 1U);
}

TEST_F(CutTest, WhatHeldAtTheStartGoesAlong) {
  const auto report = cut({.from = "5"}, "c.mcap");
  EXPECT_EQ(report.carried, 2U);
  const auto calibration = messages_of(path("c.mcap"), "/camera0/calibration");
  const auto source = messages_of(path("s.mcap"), "/camera0/calibration");
  ASSERT_EQ(calibration.size(), 1U);
  EXPECT_EQ(calibration[0].data, source[0].data) << "with its own times";
  EXPECT_EQ(calibration[0].publish_time_ns, source[0].publish_time_ns);
  EXPECT_LT(calibration[0].log_time_ns, 1'005'000'000'000U);
  EXPECT_GE(calibration[0].log_time_ns, 1'005'000'000'000U - 2);
  EXPECT_EQ(messages_of(path("c.mcap"), "/roseau/operator").size(), 1U);
  const auto info = read_session_info(*testing::open_session(path("c.mcap")));
  EXPECT_EQ(info.value().repeated_messages, 2U);
  expect_whole("c.mcap");
}

TEST_F(CutTest, ATargetThatWasTakenAwayDoesNotGoAlong) {
  testing::SessionFile file;
  file.open(path("t.mcap"));
  using Kind = OperatorAction::Kind;
  file.add("/roseau/operator", 0, 0, OperatorAction{.kind = Kind::add_target, .text = "branch", .camera = "camera0"});
  file.add("/roseau/operator", 1, 1, OperatorAction{.kind = Kind::add_target, .text = "leaf", .camera = "camera0"});
  file.add("/roseau/operator", 2, 2, OperatorAction{.kind = Kind::remove_target, .text = "branch", .camera = "camera0"});
  file.add("/roseau/operator", 3, 3, OperatorAction{.kind = Kind::mark, .text = "gust"});
  file.add("/roseau/operator", 6, 4, OperatorAction{.kind = Kind::mark, .text = "later"});
  file.close();
  ASSERT_TRUE(cut_session(path("t.mcap"), path("u.mcap"), {.from = "5"}));
  const auto actions = messages_of(path("u.mcap"), "/roseau/operator");
  ASSERT_EQ(actions.size(), 2U);
  EXPECT_EQ(actions[0].sequence, 1U) << "leaf";
  EXPECT_EQ(actions[1].sequence, 4U);
}

TEST_F(CutTest, MetadataAttachmentsAndCountersComeAlong) {
  cut({.from = "5"}, "c.mcap");
  const auto reader = testing::open_session(path("c.mcap"));
  std::vector<std::byte> buffer;
  ASSERT_EQ(reader->index().attachments.size(), 2U);
  EXPECT_EQ(reader->read(reader->index().attachments[0], buffer).value().name, "config.toml");
  const auto info = read_session_info(*reader);
  EXPECT_EQ(info.value().utc_minus_host_time, Duration{1'700'000'000'000'000'000});
  const auto note = reader->find_metadata("roseau.cut").value();
  ASSERT_TRUE(note);
  EXPECT_EQ(note->metadata.at("source"), "s.mcap");
  EXPECT_EQ(note->metadata.at("first_log_time_ns"), "1005000000000");
  EXPECT_THAT(note->metadata.at("source counters /sonic/wind"), HasSubstr("recorded=200"));
  const auto counters = mcap::counters_from(reader->find_metadata(mcap::kCountersMetadata).value().value());
  EXPECT_EQ(counters.value().at("/sonic/wind").recorded, 100U);
  EXPECT_EQ(counters.value().at("/camera0/calibration").repeated, 1U);
}

TEST_F(CutTest, DropsGapsAndBadSamplesInsideAreCounted) {
  testing::SessionFile file;
  file.open(path("d.mcap"));
  for (std::uint32_t i = 0; i < 100; ++i) {
    file.add("/sonic/wind", i * 0.1, i, testing::SessionFile::wind(1), i % 10 == 0 ? kStatusBadChecksum : kStatusOk);
    if (i == 30) file.add("/recorder/drops", 3, 0, Drop{.topic = "/sonic/wind", .stage = "recorder", .count = 7});
    if (i == 80) file.add("/recorder/drops", 8, 1, Drop{.topic = "/sonic/wind", .stage = "recorder", .count = 5});
    if (i == 85) file.add("/roseau/gaps", 8.5, 0, Gap{.topic = "/sonic/wind", .missing = 4});
  }
  file.close();
  ASSERT_TRUE(cut_session(path("d.mcap"), path("e.mcap"), {.from = "5"}));
  const auto reader = testing::open_session(path("e.mcap"));
  const auto counters = mcap::counters_from(reader->find_metadata(mcap::kCountersMetadata).value().value());
  const auto& wind = counters.value().at("/sonic/wind");
  EXPECT_EQ(wind.recorded, 50U);
  EXPECT_EQ(wind.dropped, 5U);
  EXPECT_EQ(wind.received, 55U);
  EXPECT_EQ(wind.gaps, 4U);
  EXPECT_EQ(wind.bad, 5U);
}

TEST_F(CutTest, ABrokenChunkIsLeftOutAndSaid) {
  {
    const auto blocks = testing::open_session(path("s.mcap"))->index().blocks;
    std::fstream file(path("s.mcap"), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(blocks[20].offset + blocks[20].length - 5));
    file.put('\x5a');
  }
  const auto report = cut({.from = "0"}, "c.mcap");
  ASSERT_EQ(report.damage.size(), 1U);
  EXPECT_THAT(report.damage[0], HasSubstr("left out"));
  expect_whole("c.mcap");
}

TEST_F(CutTest, NothingIsOverwrittenAndNothingIsLeftBehind) {
  folder_.write("c.mcap", "precious");
  EXPECT_FALSE(cut_session(path("s.mcap"), path("c.mcap"), {}));
  EXPECT_EQ(testing::read_text_file(path("c.mcap")), "precious");
  EXPECT_FALSE(cut_session(path("s.mcap"), path("s.mcap"), {})) << "onto itself";
  expect_whole("s.mcap");
  EXPECT_FALSE(cut_session(path("s.mcap"), path("d.mcap"), {.from = "50"}));
  EXPECT_FALSE(std::filesystem::exists(path("d.mcap")));
}

TEST_F(CutTest, StoppingLeavesAWholeFile) {
  int calls = 0;
  const auto report = cut_session(path("s.mcap"), path("c.mcap"), {}, [&calls](double) { return ++calls < 30; });
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->stopped);
  EXPECT_GT(report->messages, 10U);
  expect_whole("c.mcap");
}

}  // namespace
}  // namespace roseau::recorder
