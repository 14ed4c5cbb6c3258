#include "synthesis/instruments/console.h"

#include <gtest/gtest.h>

#include "synthesis/instruments/speaking_instrument.h"
#include "tests/unit/synthesis/instruments/simulated_field.h"

namespace roseau::synthesis {
namespace {

std::shared_ptr<const MagneticTracker> tracker(std::int64_t stations = 2) {
  auto field = std::make_shared<TestField>();
  field->place = [](std::size_t station, double) {
    return StationPlace{{0.1 * static_cast<double>(station), 0.2, 0.3}, {1, 0, 0, 0}};
  };
  MagneticTrackerOptions options;
  options.station_count = stations;
  options.source_position_in_world_m = {0, 0, 0};
  options.noise_m = options.noise_deg = options.noise_floor_m = options.noise_floor_deg = 0;
  options.timing = {};
  return *MagneticTracker::make("tracker", options, 1, field);
}

TEST(FastrakConsole, IsAsItIsDelivered) {
  FastrakConsole console(tracker());
  const auto status = wire::parse_fastrak_status(console.take("S", 0));
  ASSERT_TRUE(status);
  EXPECT_FALSE(status->is_binary);
  EXPECT_FALSE(status->is_continuous);
  EXPECT_EQ(status->unit, wire::FastrakUnit::inch);
  EXPECT_EQ(status->receivers, 3U);
  EXPECT_EQ(console.record(0, 0), "") << "silent until told to send";
  EXPECT_EQ(console.take("C", 0), "");
  EXPECT_EQ(console.record(0, 0), "01    3.94   7.87  11.81   0.00   0.00   0.00\r\n");
  console.take("c", 1);
  EXPECT_EQ(console.record(1, 1), "");
}

TEST(FastrakConsole, FormUnitAndItemsAreWhatTheHostSaid) {
  FastrakConsole console(tracker());
  EXPECT_EQ(console.take("fuO1,2,11,0\rO2,2,4,1\rC", 0), "");
  const std::string first = console.record(0, 0);
  ASSERT_EQ(first.size(), 32U);
  const auto pose = wire::parse_fastrak_binary(first, wire::quaternion_fastrak_layout(), wire::FastrakUnit::centimetre);
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->position_in_source_m.x, 0.1, 1e-7);
  EXPECT_EQ(console.record(1, 0).size(), 3U + 6 * 4 + 2) << "each station has its own list";
  const auto status = wire::parse_fastrak_status(console.take("S", 0));
  ASSERT_TRUE(status);
  EXPECT_TRUE(status->is_binary && status->is_continuous);
  EXPECT_EQ(status->unit, wire::FastrakUnit::centimetre);
  console.take("FU", 0);
  EXPECT_EQ(console.record(1, 0), "02    7.87   7.87  11.81   0.00   0.00   0.00\r\n");
  console.take("W", 0);
  EXPECT_EQ(console.record(1, 0), "") << "as delivered: silent";
}

TEST(FastrakConsole, CommandsMayComeByteByByte) {
  FastrakConsole console(tracker());
  std::string answer;
  for (const char c : std::string("uO1,2,1\rfS")) answer += console.take(std::string(1, c), 0);
  EXPECT_TRUE(wire::parse_fastrak_status(answer));
  console.take("C", 0);
  EXPECT_EQ(console.record(0, 0).size(), 3U + 12 + 2);
}

TEST(FastrakConsole, OneRecordOfEachStationOnRequest) {
  FastrakConsole console(tracker(3));
  EXPECT_EQ(console.take("P", 1.0),
            "01    3.94   7.87  11.81   0.00   0.00   0.00\r\n"
            "02    7.87   7.87  11.81   0.00   0.00   0.00\r\n"
            "03   11.81   7.87  11.81   0.00   0.00   0.00\r\n");
  EXPECT_EQ(console.take("l2,0\r", 1.0), "");
  EXPECT_EQ(console.take("l1\r", 1.0), "21l1010\r\n");
  EXPECT_EQ(console.take("P", 1.0).size(), 2U * 47);
}

TEST(FastrakConsole, WhatMakesNoSenseIsAnError) {
  FastrakConsole console(tracker());
  EXPECT_EQ(console.take("Z", 0), "2 E*ERROR*Z*ERROR* EC-99\r\n");
  EXPECT_EQ(console.take("O1,99\r", 0), "2 E*ERROR*O*ERROR* EC-3\r\n");
  EXPECT_EQ(console.take("O4,2\r", 0), "2 E*ERROR*O*ERROR* EC-3\r\n") << "there is no station 4";
  EXPECT_EQ(console.take("l9,1\r", 0), "2 E*ERROR*l*ERROR* EC-3\r\n");
  EXPECT_EQ(console.take("\r\n\r\n", 0), "");
  EXPECT_NE(console.take("O" + std::string(500, '1'), 0), "") << "a command that never ends is cut off";
  EXPECT_TRUE(wire::parse_fastrak_status(console.take("\rS", 0).substr(0, 55)) ||
              wire::parse_fastrak_status(console.take("\rS", 0)));
}

TEST(FastrakConsole, AResetTakesTenSecondsOfSilence) {
  FastrakConsole console(tracker());
  console.take("fuC", 5);
  EXPECT_EQ(console.take("\x19S", 6), "");
  EXPECT_EQ(console.take("SC", 10), "");
  EXPECT_EQ(console.record(500, 10), "");
  const auto status = wire::parse_fastrak_status(console.take("S", 16.1));
  ASSERT_TRUE(status);
  EXPECT_FALSE(status->is_binary);
}

TEST(LedBoardConsole, QuestionsAreAnsweredWithItsTime) {
  LedBoardOptions options;
  options.timing = {.counter_offset_s = 60};
  const auto board = std::make_shared<LedBoard>("led_board", options, 1);
  LedBoardConsole console(board);
  const std::string line = console.take("Q17\n", 2.5);
  const auto answer = wire::parse_led_board(std::string_view(line).substr(0, line.size() - 2));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->kind, wire::LedBoardMessage::Kind::answer);
  EXPECT_EQ(answer->sequence, 17U);
  EXPECT_NEAR(static_cast<double>(answer->received_us), 62'500'000, 1);
  EXPECT_GT(answer->sent_us, answer->received_us);
  EXPECT_EQ(console.take("Q1", 3), "");
  EXPECT_NE(console.take("8\r\n", 3), "") << "the rest of a question";
  EXPECT_EQ(console.take("nonsense\n\n", 3), "");
}

TEST(LedBoardConsole, ItsTickIsTheScenes) {
  LedBoardOptions options;
  options.tick_s = 0.00025;
  LedBoardConsole console(std::make_shared<LedBoard>("led_board", options, 1));
  EXPECT_EQ(console.take("B500\n", 0), "B,250*59\r\n");
  EXPECT_EQ(console.take("V\n", 0).substr(0, 2), "V,");
}

TEST(SpeakingInstrument, SendsEveryRecordWhenItsLastByteIsThrough) {
  SonicOptions options;
  options.noise_mps = 0;
  options.timing = {.latency_s = 0.05};
  const auto sonic = std::make_shared<Sonic>("sonic", options, 1, std::make_shared<TestField>());
  const auto speaking = make_speaking(sonic, 1);
  EXPECT_EQ(speaking->name(), "sonic");
  for (std::uint64_t i = 0; i < 20; ++i) {
    const Duration due = speaking->next();
    if (i > 0) {
      EXPECT_NEAR(to_seconds(due), 0.05 + 0.05 * static_cast<double>(i) + 53 * 10 / 38400.0, 1e-6);
    }
    EXPECT_EQ(speaking->send(due), sonic->record(i));
  }
}

TEST(SpeakingInstrument, WhatIsLongOverdueIsLeftOut) {
  SonicOptions options;
  options.timing = {};
  const auto sonic = std::make_shared<Sonic>("sonic", options, 1, std::make_shared<TestField>());
  const auto speaking = make_speaking(sonic, 1);
  EXPECT_EQ(speaking->send(std::chrono::seconds(100)), "");
  EXPECT_GE(speaking->next(), std::chrono::seconds(100));
  EXPECT_LT(speaking->next(), std::chrono::milliseconds(100'100));
  EXPECT_EQ(speaking->send(speaking->next()), sonic->record(2000));
}

TEST(SpeakingInstrument, FollowsItsCable) {
  SonicOptions options;
  options.timing.cable_pulls_s = {1, 2};
  const auto speaking = make_speaking(std::make_shared<Sonic>("sonic", options, 1, std::make_shared<TestField>()), 1);
  EXPECT_TRUE(speaking->is_connected(std::chrono::milliseconds(999)));
  EXPECT_FALSE(speaking->is_connected(std::chrono::milliseconds(1000)));
  EXPECT_TRUE(speaking->is_connected(std::chrono::milliseconds(2000)));
}

}  // namespace
}  // namespace roseau::synthesis
