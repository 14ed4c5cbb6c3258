#include "daemon/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "recorder/format/indexed_reader.h"
#include "schema/conversion.h"
#include "tests/support/temporary_folder.h"

namespace roseau::daemon {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::SizeIs;

constexpr std::uint64_t kMib = 1U << 20U;
HostTime at_ms(std::int64_t time_ms) { return host_time_from_ns(time_ms * 1'000'000); }

class RecordingTest : public ::testing::Test {
 protected:
  RecordingTest() {
    plan.config.directory = folder.path() / "recordings";
    plan.name = "storm";
    plan.config.post_trigger_s = 1;
  }
  std::unique_ptr<Recording> make() {
    RecordingCallbacks callbacks;
    callbacks.mark = [this](const OperatorAction& mark) { marks.push_back(mark.text); };
    callbacks.free_bytes = [this](const std::filesystem::path&) { return std::optional(free_bytes); };
    callbacks.power = [this] { return power; };
    callbacks.civil_now = [this] { return civil; };
    return std::make_unique<Recording>(streams, plan, callbacks);
  }
  void act(Recording& recording, std::int64_t time_ms, OperatorAction::Kind kind) {
    const HostTime time = at_ms(time_ms);
    recording.input({{.stream = operator_, .arrival_time = time, .sample_time = time}, OperatorAction{.kind = kind}}, time);
  }
  /// 100 Hz wind, both ends included.
  void play(Recording& recording, std::int64_t from_ms, std::int64_t to_ms, double u_mps = 1) {
    for (std::int64_t time_ms = from_ms; time_ms <= to_ms; time_ms += 10) {
      const HostTime time = at_ms(time_ms);
      recording.analysed({{.stream = wind, .arrival_time = time, .sample_time = time}, WindSample{.u_mps = u_mps, .v_mps = 0}},
                         time);
    }
  }
  std::set<std::string> files() const {
    std::set<std::string> names;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(plan.config.directory, none)) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
  /// First and last log time of a topic in milliseconds, and how many; checks that the file is whole.
  std::vector<std::int64_t> extent(const std::string& file, const std::string& topic = "/sonic/wind") {
    auto reader = mcap::IndexedReader::open(plan.config.directory / file);
    EXPECT_TRUE(reader) << (reader ? "" : reader.error().message);
    if (!reader) return {};
    EXPECT_TRUE((*reader)->index().complete) << file;
    std::vector<std::int64_t> times;
    auto cursor = (*reader)->messages();
    for (auto message = cursor.next(); message && *message; message = cursor.next()) {
      if ((*message)->channel->topic == topic)
        times.push_back(static_cast<std::int64_t>((*message)->message.log_time_ns / 1'000'000));
    }
    if (times.empty()) return {};
    return {times.front(), times.back(), static_cast<std::int64_t>(times.size())};
  }
  Health health_of(const Recording& recording) const {
    Health health;
    health.recorder = DeviceState::running;
    recording.report(health);
    return health;
  }
  /// What a power cut leaves of a recording: no end, a torn last chunk, the marker.
  void leave_interrupted(const std::string& session, const std::string& cause) {
    std::filesystem::create_directories(plan.config.directory);
    const auto file = plan.config.directory / (session + ".mcap");
    {
      recorder::Recorder recorder(streams);
      ASSERT_TRUE(recorder.open(file, {.session_id = "the-session"}));
      for (int i = 0; i < 500; ++i) recorder.record({{.stream = wind}, WindSample{.u_mps = 1.0 * i}}, at_ms(10 * i));
      ASSERT_TRUE(recorder.close());
    }
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 100);
    folder.write("recordings/" + session + ".recording", "part = 1\nsession_id = the-session\ncause = " + cause + "\n");
  }

  const roseau::testing::TemporaryFolder folder;
  StreamTable streams;
  StreamId wind = streams.add({.topic = "/sonic/wind", .kind = "wind", .role = StreamRole::derived, .device = "sonic"});
  StreamId operator_ = streams.add({.topic = "/roseau/operator", .kind = "operator_action"});
  RecordingPlan plan;
  std::uint64_t free_bytes = 100'000 * kMib;
  recorder::Power power;
  std::chrono::system_clock::time_point civil = std::chrono::sys_days(std::chrono::year(2026) / 11 / 22) + 14h;
  std::vector<std::string> marks;
};

TEST_F(RecordingTest, OperatorsOrdersAreTheFirstAndTheLastInTheFile) {
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  play(*recording, 0, 990);
  act(*recording, 1000, OperatorAction::Kind::start_recording);
  play(*recording, 1010, 1990);
  EXPECT_TRUE(recording->is_recording());
  EXPECT_FALSE(recording->allows({.kind = OperatorAction::Kind::start_recording}));
  act(*recording, 2000, OperatorAction::Kind::stop_recording);
  play(*recording, 2010, 4000);
  EXPECT_FALSE(recording->is_recording());
  EXPECT_FALSE(recording->allows({.kind = OperatorAction::Kind::stop_recording}));
  EXPECT_TRUE(recording->allows({.kind = OperatorAction::Kind::start_recording}));
  ASSERT_TRUE(recording->finish());
  EXPECT_THAT(files(), ElementsAre("storm-20261122T140000Z.mcap"));
  EXPECT_THAT(extent("storm-20261122T140000Z.mcap"), ElementsAre(1010, 1990, 99));
  EXPECT_THAT(extent("storm-20261122T140000Z.mcap", "/roseau/operator"), ElementsAre(1000, 2000, 2));
}

TEST_F(RecordingTest, RecordingsOfOneSecondGetNamesOfTheirOwn) {
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  for (int i = 0; i < 2; ++i) {
    act(*recording, 10'000 * i, OperatorAction::Kind::start_recording);
    act(*recording, 10'000 * i + 100, OperatorAction::Kind::stop_recording);
  }
  ASSERT_TRUE(recording->finish());
  EXPECT_THAT(files(), ElementsAre("storm-20261122T140000Z.mcap", "storm-20261122T140001Z.mcap"));
}

TEST_F(RecordingTest, WindTriggersWithItsPastAndLeavesAMark) {
  plan.config.pre_trigger_s = 0.5;
  plan.config.pre_trigger_mib = 8;
  plan.config.triggers = {{.name = "storm", .topic = "/sonic/wind", .above = 10, .hysteresis = 1}};
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  play(*recording, 0, 2990, 5);
  play(*recording, 3000, 4000, 12);
  EXPECT_EQ(health_of(*recording).recording_phase, RecordingPhase::recording);
  EXPECT_EQ(health_of(*recording).recording_cause, "trigger storm");
  play(*recording, 4010, 4500, 5);
  EXPECT_EQ(health_of(*recording).recording_phase, RecordingPhase::post_trigger);
  EXPECT_NEAR(health_of(*recording).recording_ends_s, 0.51, 1e-9);
  play(*recording, 4510, 9000, 5);
  ASSERT_TRUE(recording->finish());
  EXPECT_THAT(marks, ElementsAre("trigger storm: wind_speed_mps 12 on /sonic/wind, above 10"));
  EXPECT_THAT(extent("storm-20261122T140000Z.mcap"), ElementsAre(2500, 5010, 252));
}

TEST_F(RecordingTest, ADiskThatFillsStopsTheRecordingAndItGoesOnWhenThereIsRoom) {
  plan.config.least_free_mib = 1000;
  plan.at_start = true;
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  recording->look_after(at_ms(0));
  play(*recording, 0, 990);
  free_bytes = 999 * kMib;
  recording->look_after(at_ms(1000));
  EXPECT_FALSE(recording->is_recording());
  const auto health = health_of(*recording);
  EXPECT_EQ(health.recorder, DeviceState::degraded);
  EXPECT_THAT(health.recorder_message, HasSubstr("Free some space"));
  EXPECT_THAT(recording->allows({.kind = OperatorAction::Kind::trigger}).error().message, HasSubstr("999 MiB left"));
  play(*recording, 1010, 4990);
  recording->look_after(at_ms(5000));
  EXPECT_FALSE(recording->is_recording());
  free_bytes = 2000 * kMib;
  recording->look_after(at_ms(6000));
  play(*recording, 6010, 7000);
  EXPECT_TRUE(recording->is_recording());
  EXPECT_EQ(health_of(*recording).recorder, DeviceState::running);
  ASSERT_TRUE(recording->finish());
  EXPECT_THAT(extent("storm-20261122T140000Z.mcap"), ElementsAre(0, 990, 100));
  EXPECT_THAT(extent("storm-20261122T140001Z.mcap"), ElementsAre(6010, 7000, 100));
}

TEST_F(RecordingTest, ARingDeletesItsOldestAndNothingElse) {
  plan.config.least_free_mib = 1000;
  plan.config.when_full = recorder::WhenFull::oldest;
  plan.at_start = true;
  std::vector<std::string> old;
  std::filesystem::create_directories(plan.config.directory);
  for (const char* name : {"storm-20261120T000000Z.mcap", "storm-20261121T000000Z.mcap"}) {
    recorder::Recorder recorder(streams);
    ASSERT_TRUE(recorder.open(plan.config.directory / name, {}));
    ASSERT_TRUE(recorder.close());
  }
  folder.write("recordings/notes.txt", "mine");
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  play(*recording, 0, 990);
  free_bytes = 1000 * kMib - 1;
  recording->look_after(at_ms(1000));
  EXPECT_THAT(files(), Not(IsSupersetOf({"storm-20261120T000000Z.mcap"})));
  EXPECT_THAT(files(), IsSupersetOf({"storm-20261121T000000Z.mcap", "storm-20261122T140000Z.mcap", "notes.txt"}));
  // Nothing that may go is left, and still no room: it stops.
  recording->look_after(at_ms(2000));
  recording->look_after(at_ms(3000));
  EXPECT_THAT(files(), IsSupersetOf({"storm-20261122T140000Z.mcap", "notes.txt"}));
  EXPECT_FALSE(recording->is_recording());
  EXPECT_THAT(health_of(*recording).recorder_message, HasSubstr("no old recording that may be deleted"));
  ASSERT_TRUE(recording->finish());
  EXPECT_THAT(extent("storm-20261122T140000Z.mcap"), ElementsAre(0, 990, 100));
}

TEST_F(RecordingTest, ALowBatteryIsSaidAndStopsInTime) {
  plan.config.battery_stop_percent = 10;
  plan.at_start = true;
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  power = {.battery_percent = 18, .on_battery = true};
  recording->look_after(at_ms(0));
  EXPECT_TRUE(recording->is_recording());
  EXPECT_EQ(health_of(*recording).battery_percent, 18);
  ASSERT_THAT(health_of(*recording).devices, SizeIs(1));
  EXPECT_EQ(health_of(*recording).devices[0].name, "battery");
  power.battery_percent = 10;
  recording->look_after(at_ms(1000));
  EXPECT_FALSE(recording->is_recording());
  EXPECT_THAT(health_of(*recording).recorder_message, HasSubstr("battery is at 10 %"));
  ASSERT_TRUE(recording->finish());
}

TEST_F(RecordingTest, WhatACrashCutOffIsWholeAgainAndGoesOnInTheNextPart) {
  leave_interrupted("storm-20261122T130000Z", "at start");
  plan.config.resume_after_crash = true;
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  recording->settle();
  play(*recording, 0, 990);
  EXPECT_EQ(health_of(*recording).recording_cause, "after a crash");
  EXPECT_EQ(health_of(*recording).recording_part, 2U);
  EXPECT_THAT(files(), IsSupersetOf({"storm-20261122T130000Z.recording"})) << "it is being recorded again";
  ASSERT_TRUE(recording->finish());
  EXPECT_THAT(files(), IsSupersetOf({"storm-20261122T130000Z.mcap", "storm-20261122T130000Z.part002.mcap"}));
  EXPECT_THAT(files(), Not(IsSupersetOf({"storm-20261122T130000Z.recording"})));
  EXPECT_THAT(extent("storm-20261122T130000Z.mcap"), ElementsAre(0, 4990, 500));
  EXPECT_THAT(extent("storm-20261122T130000Z.part002.mcap"), ElementsAre(0, 990, 100));
  auto reader = mcap::IndexedReader::open(plan.config.directory / "storm-20261122T130000Z.part002.mcap");
  ASSERT_TRUE(reader);
  const auto info = mcap::session_info_from((*reader)->find_metadata(mcap::kSessionMetadata)->value());
  ASSERT_TRUE(info);
  EXPECT_EQ(info->session_id, "the-session");
  EXPECT_EQ(info->part, 2U);
}

TEST_F(RecordingTest, WhatATriggerBeganIsRecoveredButDoesNotGoOn) {
  leave_interrupted("storm-20261122T130000Z", "trigger gust");
  plan.config.resume_after_crash = true;
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  recording->settle();
  EXPECT_FALSE(recording->is_recording());
  ASSERT_TRUE(recording->finish());
  EXPECT_THAT(extent("storm-20261122T130000Z.mcap"), ElementsAre(0, 4990, 500));
  EXPECT_THAT(files(), Not(IsSupersetOf({"storm-20261122T130000Z.recording"})));
}

TEST_F(RecordingTest, EveryPartIsCopiedToTheSecondDisk) {
  plan.config.split_s = 1;
  plan.config.copy_directory = folder.path() / "second";
  plan.at_start = true;
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  play(*recording, 0, 2990);
  EXPECT_EQ(health_of(*recording).copy.directory, plan.config.copy_directory.string());
  ASSERT_TRUE(recording->finish());
  ASSERT_THAT(files(), SizeIs(3));
  for (const auto& file : files()) {
    EXPECT_EQ(roseau::testing::read_text_file(plan.config.directory / file),
              roseau::testing::read_text_file(plan.config.copy_directory / file));
  }
  EXPECT_THAT(extent("storm-20261122T140000Z.mcap"), ElementsAre(0, 990, 100));
  EXPECT_THAT(extent("storm-20261122T140000Z.part003.mcap"), ElementsAre(2000, 2990, 100));
}

TEST_F(RecordingTest, AReplayRecordsEverythingAndObeysNobody) {
  plan.is_replay = true;
  plan.at_start = true;
  plan.config.triggers = {{.name = "storm", .topic = "/sonic/wind", .above = 0}};
  const auto recording = make();
  ASSERT_TRUE(recording->begin());
  play(*recording, 0, 500);
  act(*recording, 505, OperatorAction::Kind::stop_recording);
  play(*recording, 510, 5000);
  EXPECT_FALSE(recording->allows({.kind = OperatorAction::Kind::mark}));
  ASSERT_TRUE(recording->finish());
  EXPECT_THAT(marks, IsEmpty());
  EXPECT_THAT(extent("storm-20261122T140000Z.mcap"), ElementsAre(0, 5000, 501));
}

TEST_F(RecordingTest, AFileThatCannotBeMadeEndsTheStart) {
  folder.write("recordings", "a file where the directory should be");
  plan.at_start = true;
  const auto recording = make();
  const auto begun = recording->begin();
  ASSERT_FALSE(begun);
  EXPECT_THAT(begun.error().message, HasSubstr("recordings"));
}

}  // namespace
}  // namespace roseau::daemon
