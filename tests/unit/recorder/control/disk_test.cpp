// The guard of the disk, the files of a recording directory, and the battery.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recorder/control/battery.h"
#include "recorder/control/disk_guard.h"
#include "recorder/control/session_files.h"
#include "recorder/recorder.h"
#include "tests/support/temporary_folder.h"

namespace roseau::recorder {
namespace {

using namespace std::chrono_literals;
using roseau::testing::read_text_file;
using roseau::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Kind = DiskVerdict::Kind;

constexpr std::uint64_t kMib = 1U << 20U;
HostTime at_s(double time_s) { return HostTime{} + from_seconds(time_s); }

TEST(WriteRate, IsTheMeanAtFirstAndFollowsWithTenSeconds) {
  WriteRate rate;
  rate.add(at_s(0), 500);
  EXPECT_EQ(rate.bytes_per_s(), 0);
  rate.add(at_s(1), 1500);
  EXPECT_DOUBLE_EQ(rate.bytes_per_s(), 1000);
  rate.add(at_s(2), 4500);
  EXPECT_DOUBLE_EQ(rate.bytes_per_s(), 2000);
  for (int i = 3; i <= 100; ++i) rate.add(at_s(i), 4500 + 100 * static_cast<std::uint64_t>(i - 2));
  EXPECT_NEAR(rate.bytes_per_s(), 100, 1);
}

TEST(WriteRate, ANewSessionStartsAnew) {
  WriteRate rate;
  rate.add(at_s(0), 0);
  rate.add(at_s(1), 1'000'000);
  rate.add(at_s(2), 10);
  EXPECT_EQ(rate.bytes_per_s(), 0);
  rate.add(at_s(3), 110);
  EXPECT_DOUBLE_EQ(rate.bytes_per_s(), 100);
  rate.pause();
  rate.add(at_s(100), 110);
  EXPECT_EQ(rate.bytes_per_s(), 0);
}

TEST(DiskGuard, WarnsInTimeThenStops) {
  DiskGuard guard({.least_free_bytes = 1000 * kMib});
  const double rate = 10.0 * kMib;
  EXPECT_EQ(guard.judge("/data", 8000 * kMib, 0, rate).kind, Kind::well);
  EXPECT_DOUBLE_EQ(guard.judge("/data", 8000 * kMib, 0, rate).left_s, 700);
  const auto warned = guard.judge("/data", 6000 * kMib, 0, rate);
  EXPECT_EQ(warned.kind, Kind::warn);
  EXPECT_THAT(warned.message, HasSubstr("/data will be full in 8 min at the present 10 MiB/s"));
  const auto full = guard.judge("/data", 999 * kMib, 0, rate);
  EXPECT_EQ(full.kind, Kind::full);
  EXPECT_THAT(full.message, HasSubstr("999 MiB left"));
  EXPECT_THAT(full.message, HasSubstr("Free some space"));
}

TEST(DiskGuard, DoesNotFlutter) {
  DiskGuard guard({.least_free_bytes = 1000 * kMib});
  EXPECT_EQ(guard.judge("/data", 999 * kMib, 0, 0).kind, Kind::full);
  EXPECT_EQ(guard.judge("/data", 1100 * kMib, 0, 0).kind, Kind::full) << "what the writer had reserved came back";
  EXPECT_EQ(guard.judge("/data", 1200 * kMib, 0, 0).kind, Kind::well);
  EXPECT_EQ(guard.judge("/data", 1100 * kMib, 0, 0).kind, Kind::well);
}

TEST(DiskGuard, ARingMakesRoomAndLastsForEver) {
  DiskGuard guard({.least_free_bytes = 1000 * kMib, .when_full = WhenFull::oldest, .keep_at_most_bytes = 5000 * kMib});
  EXPECT_EQ(guard.judge("/data", 1500 * kMib, 4000 * kMib, 1e9).kind, Kind::well);
  EXPECT_EQ(guard.judge("/data", 1500 * kMib, 4000 * kMib, 1e9).left_s, 0);
  const auto low = guard.judge("/data", 900 * kMib, 4000 * kMib, 0);
  EXPECT_EQ(low.kind, Kind::make_room);
  EXPECT_EQ(low.missing_bytes, 100 * kMib);
  const auto many = guard.judge("/data", 9000 * kMib, 5300 * kMib, 0);
  EXPECT_EQ(many.kind, Kind::make_room);
  EXPECT_EQ(many.missing_bytes, 300 * kMib);
}

TEST(PartName, OnlyWhatARecordingIsCalled) {
  const auto first = part_name_from("/data/storm-20261122T140501Z.mcap");
  ASSERT_TRUE(first);
  EXPECT_EQ(first->session, "storm-20261122T140501Z");
  EXPECT_EQ(first->part, 1U);
  const auto second = part_name_from(default_part_path("/data/storm-20261122T140501Z.mcap", 12));
  ASSERT_TRUE(second);
  EXPECT_EQ(second->session, "storm-20261122T140501Z");
  EXPECT_EQ(second->part, 12U);
  EXPECT_EQ(path_of_part("/data/storm-20261122T140501Z.mcap", 3), "/data/storm-20261122T140501Z.part003.mcap");
  EXPECT_EQ(path_of_part("/data/storm-20261122T140501Z.part003.mcap", 4), "/data/storm-20261122T140501Z.part004.mcap");
  EXPECT_EQ(path_of_part("/data/storm-20261122T140501Z.part003.mcap", 1), "/data/storm-20261122T140501Z.mcap");
  for (const char* other : {"storm.mcap", "20261122T140501Z.mcap", "-20261122T140501Z.mcap", "a-20261122T140501Z.mcap.copying",
                            "a-20261122T14O501Z.mcap", "a-20261122T140501Z.part2.mcap", "a-20261122T140501Z.part001.mcap",
                            "a-20261122T140501Z.partxyz.mcap", "a-20261122T140501Z.bag"}) {
    EXPECT_FALSE(part_name_from(other)) << other;
  }
}

class DirectoryTest : public ::testing::Test {
 protected:
  /// A recording of `samples`, closed.
  std::filesystem::path record(const std::string& name, int samples = 1) {
    Recorder recorder(streams);
    const auto path = folder.path() / name;
    EXPECT_TRUE(recorder.open(path, {}));
    for (int i = 0; i < samples; ++i) recorder.record({{.stream = wind}, WindSample{}}, at_s(i));
    EXPECT_TRUE(recorder.close());
    return path;
  }
  std::filesystem::path record_cut(const std::string& name) {
    const auto path = record(name);
    std::filesystem::resize_file(path, std::filesystem::file_size(path) - 20);
    return path;
  }
  std::vector<std::string> names(const std::vector<SessionFile>& files) const {
    std::vector<std::string> found;
    for (const auto& file : files) found.push_back(file.path.filename().string());
    return found;
  }
  std::filesystem::file_time_type long_after() const { return std::filesystem::file_time_type::clock::now() + 1h; }

  const TemporaryFolder folder;
  StreamTable streams;
  StreamId wind = streams.add({.topic = "/sonic/wind", .kind = "wind"});
};

TEST_F(DirectoryTest, ListsWhatRoseauMadeOldestFirst) {
  record("storm-20261122T140501Z.mcap");
  record("storm-20261122T140501Z.part002.mcap");
  record("storm-20261122T140501Z.part010.mcap");
  record("alpha-20261123T000000Z.mcap");
  record("zulu-20261121T235959Z.mcap");
  record("kept by hand.mcap");
  folder.write("fake-20261101T000000Z.mcap", "not a recording");
  folder.write("x-20261101T000000Z.txt", "");
  std::filesystem::create_directory(folder.path() / "d-20261101T000000Z.mcap");
  std::filesystem::create_symlink("kept by hand.mcap", folder.path() / "link-20261101T000000Z.mcap");
  EXPECT_THAT(names(list_session_files(folder.path())),
              ElementsAre("zulu-20261121T235959Z.mcap", "storm-20261122T140501Z.mcap", "storm-20261122T140501Z.part002.mcap",
                          "storm-20261122T140501Z.part010.mcap", "alpha-20261123T000000Z.mcap"));
  EXPECT_THAT(list_session_files(folder.path() / "nowhere"), IsEmpty());
}

TEST_F(DirectoryTest, DeletesItsOwnOldestFinishedPartsAndNothingElse) {
  const auto oldest = record("storm-20261122T140501Z.mcap", 100);
  record_cut("storm-20261122T150000Z.mcap");
  const auto spared = record("storm-20261122T160000Z.mcap");
  const auto next = record("storm-20261122T160000Z.part002.mcap");
  record("storm-20261122T160000Z.part003.mcap");
  record("kept by hand.mcap");
  const auto files = list_session_files(folder.path());
  ASSERT_EQ(files.size(), 5U);
  EXPECT_THAT(names(oldest_to_delete(files, 1, {spared})), ElementsAre("storm-20261122T140501Z.mcap"));
  EXPECT_THAT(names(oldest_to_delete(files, std::filesystem::file_size(oldest) + 1, {spared})),
              ElementsAre("storm-20261122T140501Z.mcap", "storm-20261122T160000Z.part002.mcap"));
  EXPECT_THAT(oldest_to_delete(files, 0, {}), IsEmpty());
  EXPECT_THAT(names(oldest_to_delete(files, 1U << 30U, {spared, next})),
              ElementsAre("storm-20261122T140501Z.mcap", "storm-20261122T160000Z.part003.mcap"));
}

TEST_F(DirectoryTest, ACrashIsSeenByWhatItLeft) {
  record("storm-20261122T140501Z.mcap");
  const auto cut = record_cut("storm-20261122T140501Z.part002.mcap");
  // What a process that was killed leaves: a marker without its lock.
  folder.write("storm-20261122T140501Z.recording", "part = 1\nsession_id = abc\nboot_id = other\nprocess = 4711\n");
  folder.write("storm-20261120T000000Z.recording", "part = 7\n");
  const auto found = find_interrupted(folder.path(), std::filesystem::file_time_type::clock::now());
  EXPECT_THAT(found.files, ElementsAre(cut));
  EXPECT_THAT(found.finished, ElementsAre(folder.path() / "storm-20261122T140501Z.mcap"));
  ASSERT_TRUE(found.session);
  EXPECT_EQ(found.session->session, "storm-20261122T140501Z");
  EXPECT_EQ(found.session->session_id, "abc");
  EXPECT_EQ(found.session->part, 2U) << "the files know better than a marker that was not updated in time";
  EXPECT_EQ(found.session->process, 4711);
  EXPECT_EQ(found.markers.size(), 2U);
}

TEST_F(DirectoryTest, KilledBetweenTwoPartsTheNumberOfTheEmptyOneIsTaken) {
  record("storm-20261122T140501Z.mcap");
  const auto empty = folder.write("storm-20261122T140501Z.part002.mcap", "");
  folder.write("other-20261122T140501Z.mcap", "");  // nobody said that it was being recorded
  folder.write("storm-20261122T140501Z.recording", "part = 1\n");
  const auto found = find_interrupted(folder.path(), long_after());
  EXPECT_THAT(found.empty, ElementsAre(std::filesystem::path(empty)));
  EXPECT_THAT(found.files, IsEmpty());
  ASSERT_TRUE(found.session);
  EXPECT_EQ(found.session->part, 2U);
}

TEST_F(DirectoryTest, WhatIsBeingRecordedIsLeftAlone) {
  record_cut("storm-20261122T140501Z.mcap");
  {
    const auto marker = RecordingMarker::place(folder.path(), {.session = "storm-20261122T140501Z"});
    ASSERT_TRUE(marker) << marker.error().message;
    const auto second = RecordingMarker::place(folder.path(), {.session = "storm-20261122T140501Z"});
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::busy);
    const auto found = find_interrupted(folder.path(), long_after());
    EXPECT_THAT(found.files, IsEmpty());
    EXPECT_FALSE(found.session);
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "storm-20261122T140501Z.recording")) << "the session ended";
  EXPECT_THAT(find_interrupted(folder.path(), std::filesystem::file_time_type::clock::now()).files, IsEmpty())
      << "somebody may still be writing it";
  EXPECT_EQ(find_interrupted(folder.path(), long_after()).files.size(), 1U);
}

TEST_F(DirectoryTest, AMarkerSaysWhoAndWhichPart) {
  auto marker = RecordingMarker::place(folder.path(), {.session = "storm-20261122T140501Z", .cause = "at start"});
  ASSERT_TRUE(marker);
  ASSERT_TRUE(marker->update(12, "f00"));
  const auto text = read_text_file(folder.path() / "storm-20261122T140501Z.recording");
  EXPECT_THAT(text, HasSubstr("part = 12\nsession_id = f00\ncause = at start\n"));
  EXPECT_THAT(text, HasSubstr("boot_id = " + current_boot_id()));
}

class PowerTest : public ::testing::Test {
 protected:
  void supply(const std::string& name, const std::vector<std::pair<std::string, std::string>>& files) {
    std::filesystem::create_directories(folder.path() / name);
    for (const auto& [file, content] : files) folder.write(name + "/" + file, content + "\n");
  }
  void battery(int percent, const std::string& status = "Discharging") {
    supply("BAT0", {{"type", "Battery"}, {"status", status}, {"capacity", std::to_string(percent)}});
  }
  const TemporaryFolder folder;
};

TEST_F(PowerTest, ReadsWhatLinuxSays) {
  EXPECT_FALSE(read_power(folder.path() / "nowhere").battery_percent);
  supply("AC", {{"type", "Mains"}, {"online", "1"}});
  EXPECT_FALSE(read_power(folder.path()).battery_percent);
  EXPECT_FALSE(read_power(folder.path()).on_battery);
  battery(80, "Charging");
  supply("BAT1", {{"type", "Battery"}, {"status", "Full"}, {"capacity", "100"}});
  supply("hidpp_battery_0", {{"type", "Battery"}, {"scope", "Device"}, {"status", "Discharging"}, {"capacity", "3"}});
  EXPECT_EQ(read_power(folder.path()).battery_percent, 90);
  EXPECT_FALSE(read_power(folder.path()).on_battery);
  battery(70);
  EXPECT_FALSE(read_power(folder.path()).on_battery) << "on mains a battery may be discharging for a moment";
  supply("AC", {{"type", "Mains"}, {"online", "0"}});
  EXPECT_TRUE(read_power(folder.path()).on_battery);
  EXPECT_EQ(read_power(folder.path()).battery_percent, 85);
}

TEST_F(PowerTest, WarnsThenStopsAndDoesNotFlutter) {
  BatteryGuard guard(10);
  const auto judge = [&](int percent) {
    battery(percent);
    return guard.judge(read_power(folder.path()));
  };
  EXPECT_EQ(judge(21).kind, BatteryVerdict::Kind::well);
  EXPECT_EQ(judge(20).kind, BatteryVerdict::Kind::warn);
  EXPECT_THAT(judge(11).message, HasSubstr("at 11 %: recording stops at 10 %"));
  EXPECT_EQ(judge(10).kind, BatteryVerdict::Kind::stop);
  EXPECT_EQ(judge(14).kind, BatteryVerdict::Kind::stop);
  EXPECT_EQ(judge(15).kind, BatteryVerdict::Kind::warn);
  EXPECT_EQ(judge(9).kind, BatteryVerdict::Kind::stop);
  supply("AC", {{"type", "Mains"}, {"online", "1"}});
  EXPECT_EQ(judge(9).kind, BatteryVerdict::Kind::well);
}

TEST_F(PowerTest, ZeroNeverStops) {
  battery(1);
  EXPECT_EQ(BatteryGuard(0).judge(read_power(folder.path())).kind, BatteryVerdict::Kind::well);
}

}  // namespace
}  // namespace roseau::recorder
