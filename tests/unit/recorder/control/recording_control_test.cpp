#include "recorder/control/recording_control.h"

#include "tests/unit/recorder/control/rig.h"

namespace roseau::recorder {
namespace {

using namespace std::chrono_literals;
using testing::at_ms;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class RecordingControlTest : public testing::ControlTest {
 protected:
  static ControlOptions with(Duration pre_trigger, Duration post_trigger, std::uint64_t bytes = 16U << 20U) {
    ControlOptions options;
    options.policy = {.pre_trigger = pre_trigger, .post_trigger = post_trigger, .settling = 100ms};
    options.past = {.bytes = bytes, .has_pictures = true};
    return options;
  }
};

TEST_F(RecordingControlTest, RecordsFromStartToStopBothIncluded) {
  make(with(0s, 1s));
  play(0, 990);
  ASSERT_TRUE(control->start(at_ms(1000), "operator"));
  play(1000, 2000);
  control->stop(at_ms(2000));
  play(2010, 3000);
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(1000, 2000));
  EXPECT_THAT(causes, ElementsAre("operator"));
}

TEST_F(RecordingControlTest, TriggerGetsThePastAndTheTimeAfterToTheSample) {
  make(with(500ms, 300ms));
  play(0, 2000, true);
  ASSERT_TRUE(control->trigger(at_ms(2000), "gust"));
  play(2010, 5000, true);
  ASSERT_TRUE(control->finish());
  const auto times = read(1);
  EXPECT_EQ(times.at("/sonic/wind"), steps(1500, 2300));
  // The pictures' log times lie 1 us behind those of the wind: 2300 is outside.
  EXPECT_EQ(times.at("/camera0/image"), steps(1500, 2280, 20));
  EXPECT_THAT(causes, ElementsAre("trigger gust"));
  EXPECT_EQ(control->status().lost, 0U);
}

TEST_F(RecordingControlTest, ThePastHoldsNoCamerasBuffers) {
  make(with(1h, 1s));
  play(0, 2000, true);  // 101 pictures through a pool of 8
  EXPECT_EQ(pool.free_count(), 8U);
  ASSERT_TRUE(control->trigger(at_ms(2000), "gust"));
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/camera0/image"), steps(0, 2000, 20));
}

TEST_F(RecordingControlTest, OfACodedFrameThePastKeepsTheStoredForm) {
  Past past({.length = 1s, .bytes = 16'000, .has_pictures = true});
  FramePool coded_pool(1, 100);
  Sample sample = picture(at_ms(0));
  auto& frame = std::get<Frame>(sample.payload);
  frame.coded = {.lease = coded_pool.acquire(), .size = 60, .format = ImageStorage::jpeg};
  std::memset(frame.coded.lease.writable_bytes().data(), 42, 100);
  past.keep(sample, at_ms(0));
  sample = {};
  EXPECT_EQ(coded_pool.free_count(), 1U);
  EXPECT_EQ(pool.free_count(), 8U);
  const auto kept = past.take_oldest();
  ASSERT_TRUE(kept);
  const auto& kept_frame = std::get<Frame>(kept->sample.payload);
  EXPECT_FALSE(kept_frame.pixels);
  EXPECT_EQ(kept_frame.coded.format, ImageStorage::jpeg);
  EXPECT_THAT(kept_frame.coded.bytes(), ::testing::SizeIs(60));
  EXPECT_THAT(kept_frame.coded.bytes(), ::testing::Each(std::byte{42}));
  EXPECT_EQ(past.bytes(), 0U);
}

TEST_F(RecordingControlTest, BytesBoundThePastAndWhatTheyCutOffIsCounted) {
  make(with(1h, 1s,
            12'000));  // 11,250 bytes of pixels: ten pictures; 750 bytes for the rest: no sample of another kind fits twice
  for (std::int64_t time_ms = 0; time_ms < 2000; time_ms += 20) control->take(picture(at_ms(time_ms)), at_ms(time_ms));
  const auto status = control->status();
  EXPECT_LE(status.past_bytes, 12'000U);
  EXPECT_GT(status.past_cut_off, 0U);
  ASSERT_TRUE(control->trigger(at_ms(1980), "gust"));
  ASSERT_TRUE(control->finish());
  const auto kept = read(1).at("/camera0/image");
  EXPECT_EQ(kept.back(), 1980);
  EXPECT_EQ(kept, steps(kept.front(), 1980, 20)) << "the newest, without a hole";
  EXPECT_EQ(kept.size() + status.past_cut_off, 100U) << "what is not there was counted";
}

TEST_F(RecordingControlTest, AnotherTriggerProlongs) {
  make(with(100ms, 500ms));
  play(0, 1000);
  ASSERT_TRUE(control->trigger(at_ms(1000), "a"));
  play(1010, 1400);
  EXPECT_EQ(control->status().phase, RecordingPhase::post_trigger);
  EXPECT_EQ(control->status().ends_in, 100ms);
  ASSERT_TRUE(control->trigger(at_ms(1400), "b"));
  EXPECT_EQ(control->status().ends_in, 500ms);
  play(1410, 4000);
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(900, 1900));
  EXPECT_EQ(causes.size(), 1U);
}

TEST_F(RecordingControlTest, TriggersThatLastHoldTheRecordingUntilTheLastOneHasEnded) {
  make(with(0s, 200ms));
  ASSERT_TRUE(control->begin_trigger(at_ms(0), "wind"));
  play(0, 1000);
  ASSERT_TRUE(control->begin_trigger(at_ms(1000), "sway"));
  play(1010, 2000);
  control->end_trigger(at_ms(2000), "wind");
  EXPECT_EQ(control->status().phase, RecordingPhase::recording);
  play(2010, 3000);
  control->end_trigger(at_ms(3000), "sway");
  EXPECT_EQ(control->status().phase, RecordingPhase::post_trigger);
  play(3010, 5000);
  EXPECT_EQ(control->status().phase, RecordingPhase::idle);
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(0, 3200));
}

TEST_F(RecordingControlTest, AnOperatorsStartOutlivesTriggersAndHisStopEndsThem) {
  make(with(0s, 100ms));
  ASSERT_TRUE(control->trigger(at_ms(0), "gust"));
  ASSERT_TRUE(control->start(at_ms(50), "operator"));
  play(0, 1000);
  ASSERT_TRUE(control->trigger(at_ms(1000), "gust"));
  play(1010, 2000);
  EXPECT_EQ(control->status().phase, RecordingPhase::recording);
  control->stop(at_ms(2000));
  play(2010, 3000);
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(0, 2000));
}

TEST_F(RecordingControlTest, TwoRecordingsShareNoSampleAndLoseNone) {
  make(with(1s, 200ms));
  play(0, 1000);
  ASSERT_TRUE(control->trigger(at_ms(1000), "a"));
  play(1010, 1500);  // over at 1200, closed at 1300
  ASSERT_TRUE(control->trigger(at_ms(1500), "b"));
  play(1510, 3000);
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(0, 1200));
  EXPECT_EQ(read(2).at("/sonic/wind"), steps(1210, 1700));
}

TEST_F(RecordingControlTest, TriggeredWhileItSettlesTheSameRecordingGoesOnWithoutAHole) {
  make(with(1s, 200ms));
  play(0, 1000);
  ASSERT_TRUE(control->trigger(at_ms(1000), "a"));
  play(1010, 1250);  // over at 1200, would be closed after 1300
  ASSERT_TRUE(control->trigger(at_ms(1250), "b"));
  play(1260, 3000);
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(0, 1450));
  EXPECT_EQ(causes.size(), 1U);
}

TEST_F(RecordingControlTest, AStartRightAfterAStopIsAnotherRecording) {
  make(with(1s, 200ms));
  ASSERT_TRUE(control->start(at_ms(0), "operator"));
  play(0, 1000);
  control->stop(at_ms(1000));
  play(1010, 1050);
  ASSERT_TRUE(control->trigger(at_ms(1050), "gust"));
  play(1060, 3000);
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(0, 1000));
  EXPECT_EQ(read(2).at("/sonic/wind"), steps(1010, 1250));
  EXPECT_THAT(causes, ElementsAre("operator", "trigger gust"));
}

TEST_F(RecordingControlTest, CalibrationsAndTargetsFromLongBeforeStandAtTheFrontOnce) {
  make(with(500ms, 100ms));
  const StreamId calibration = streams.add({.topic = "/camera0/calibration", .kind = "camera_calibration"});
  const StreamId actions = streams.add({.topic = "/roseau/operator", .kind = "operator_action"});
  const auto act = [&](std::int64_t time_ms, OperatorAction::Kind kind, const std::string& target) {
    control->take({{.stream = actions, .arrival_time = at_ms(time_ms), .sample_time = at_ms(time_ms)},
                   OperatorAction{.kind = kind, .text = target, .camera = "camera0", .region = {1, 2, 30, 40}}},
                  at_ms(time_ms));
  };
  using Kind = OperatorAction::Kind;
  control->take({{.stream = calibration}, CameraCalibration{}}, at_ms(1));
  act(2, Kind::add_target, "crown");
  act(3, Kind::add_target, "stem");
  act(4, Kind::remove_target, "stem");
  act(5, Kind::mark, "a mark is no target");
  play(10, 5700);
  act(5705, Kind::add_target, "recent");  // part of the past itself
  play(5710, 6000);
  ASSERT_TRUE(control->trigger(at_ms(6000), "gust"));
  play(6010, 9000);
  ASSERT_TRUE(control->trigger(at_ms(9000), "gust"));
  play(9010, 12'000);
  ASSERT_TRUE(control->finish());
  // A nanosecond or two before the first sample.
  EXPECT_THAT(read(1).at("/camera0/calibration"), ElementsAre(5499));
  EXPECT_THAT(read(1).at("/roseau/operator"), ElementsAre(5499, 5705));
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(5500, 6100));
  EXPECT_THAT(read(2).at("/roseau/operator"), ElementsAre(8499, 8499)) << "both targets";
}

TEST_F(RecordingControlTest, ResultsThatComeALittleLateStillBelong) {
  make(with(0s, 0s));
  ASSERT_TRUE(control->start(at_ms(0), "operator"));
  play(0, 1000);
  control->stop(at_ms(1000));
  const StreamId late = streams.add({.topic = "/sonic/late", .kind = "wind", .role = StreamRole::derived});
  control->take(wind_sample(wind, at_ms(1050)), at_ms(1050));
  control->take(wind_sample(late, at_ms(990)), at_ms(990));
  control->take(wind_sample(wind, at_ms(1101)), at_ms(1101));  // settled: closed
  control->take(wind_sample(late, at_ms(1000)), at_ms(1000));
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(0, 1000));
  EXPECT_THAT(read(1).at("/sonic/late"), ElementsAre(990));
}

TEST_F(RecordingControlTest, EndsWithoutAnySampleWhenTimePasses) {
  make(with(0s, 100ms));
  ASSERT_TRUE(control->trigger(at_ms(0), "gust"));
  control->take(wind_sample(wind, at_ms(10)), at_ms(10));
  control->tick(at_ms(201));
  ASSERT_TRUE(control->settle());
  EXPECT_FALSE(recorder.state().recording);
  EXPECT_THAT(read(1).at("/sonic/wind"), ElementsAre(10));
}

TEST_F(RecordingControlTest, AFileThatCannotBeMadeIsSaidAndThePastGoesOn) {
  make(with(1s, 1s));
  folder.write("1.mcap", "somebody's");
  play(0, 100);
  ASSERT_TRUE(control->start(at_ms(100), "operator"));
  const auto settled = control->settle();
  ASSERT_FALSE(settled);
  EXPECT_THAT(settled.error().message, HasSubstr("1.mcap"));
  EXPECT_THAT(control->status().failure, HasSubstr("1.mcap"));
  EXPECT_EQ(control->status().phase, RecordingPhase::idle);
  play(110, 200);
  ASSERT_TRUE(control->start(at_ms(200), "operator"));
  play(210, 300);
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(2).at("/sonic/wind"), steps(110, 300));
  EXPECT_EQ(roseau::testing::read_text_file(file(1)), "somebody's");
}

TEST_F(RecordingControlTest, EndsHereBeforeTimeGoesBack) {
  make(with(0s, 1s));
  ASSERT_TRUE(control->start(HostTime::min(), "at start"));
  play(5000, 6000);
  control->end_here();
  play(0, 100);
  ASSERT_TRUE(control->start(at_ms(100), "operator"));
  play(110, 200);
  ASSERT_TRUE(control->finish());
  EXPECT_EQ(read(1).at("/sonic/wind"), steps(5000, 6000));
  EXPECT_EQ(read(2).at("/sonic/wind"), steps(110, 200));
}

TEST_F(RecordingControlTest, RefusesInWords) {
  make(with(0s, 1s));
  control->refuse("the disk is full");
  const auto started = control->start(at_ms(0), "operator");
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().message, "the disk is full");
  EXPECT_FALSE(control->trigger(at_ms(0), "gust"));
  EXPECT_FALSE(control->begin_trigger(at_ms(0), "gust"));
  control->refuse("");
  EXPECT_TRUE(control->trigger(at_ms(0), "gust"));
  ASSERT_TRUE(control->finish());
}

/// The line behind a past that takes its time: nothing is lost, nothing comes twice, whatever the threads do.
TEST_F(RecordingControlTest, SamplesOfTwoThreadsWhileThePastIsWritten) {
  make(with(10s, 10s));
  const StreamId second = streams.add({.topic = "/second", .kind = "wind", .role = StreamRole::derived});
  play(0, 9000, true);
  const auto derive = [&] {
    for (std::int64_t time_ms = 9010; time_ms <= 12'000; time_ms += 10) {
      control->take(wind_sample(second, at_ms(time_ms)), at_ms(time_ms));
    }
  };
  std::thread other;
  ASSERT_TRUE(control->trigger(at_ms(9000), "gust"));
  other = std::thread(derive);
  for (std::int64_t time_ms = 9010; time_ms <= 12'000; time_ms += 10) {
    control->take(wind_sample(wind, at_ms(time_ms)), at_ms(time_ms));
  }
  other.join();
  ASSERT_TRUE(control->finish());
  const auto times = read(1);
  EXPECT_EQ(times.at("/sonic/wind"), steps(0, 12'000));
  EXPECT_EQ(times.at("/second"), steps(9010, 12'000));
  EXPECT_EQ(times.at("/camera0/image"), steps(0, 9000, 20));
  EXPECT_EQ(control->status().lost, 0U);
}

TEST_F(RecordingControlTest, WhatHasNoRoomInTheLineIsDroppedAndCounted) {
  ControlOptions options = with(0s, 10s);
  options.waiting_bytes = 1'000;
  make(options);
  std::mutex held;
  std::unique_lock hold(held);
  ControlCallbacks callbacks;
  callbacks.open = [&](const std::string&) {
    const std::scoped_lock wait(held);
    return recorder.open(file(1), {});
  };
  control = std::make_unique<RecordingControl>(recorder, options, callbacks);
  ASSERT_TRUE(control->start(at_ms(0), "operator"));
  std::size_t taken = 0;
  for (int i = 0; i < 100; ++i) taken += control->take(wind_sample(wind, at_ms(i)), at_ms(i)) ? 1 : 0;
  hold.unlock();
  ASSERT_TRUE(control->finish());
  EXPECT_LT(taken, 100U);
  EXPECT_EQ(read(1).at("/sonic/wind").size(), taken);
  EXPECT_EQ(control->status().lost, 100 - taken);
}

}  // namespace
}  // namespace roseau::recorder
