#include "synthesis/instruments/led_board.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sync/clock_model.h"
#include "tests/unit/synthesis/instruments/simulated_field.h"

namespace roseau::synthesis {
namespace {

TEST(LedBoard, MessagesTellTheBoardsTimeAtTheirLatch) {
  LedBoardOptions options;
  options.timing = {.frequency_offset_ppm = 80, .start_offset_s = 0.1, .counter_offset_s = 60.05, .wander_ppm = 1};
  const auto board = std::make_shared<LedBoard>("led_board", options, 1);
  auto device = make_led_board_device(board, 1);
  const auto decoded = play_and_decode(*device, 60);
  EXPECT_EQ(decoded->counters.bad_records, 0U);
  EXPECT_EQ(decoded->counters.skipped_bytes, 0U);
  ASSERT_NEAR(static_cast<double>(decoded->samples.size()), 60 / 0.128, 2);
  for (std::size_t i = 0; i < decoded->samples.size(); ++i) {
    const Sample& sample = decoded->samples[i];
    EXPECT_EQ(decoded->topic(sample), "/led_board/time");
    const auto& time = std::get<LedBoardTime>(sample.payload);
    EXPECT_EQ(time.tick % 256, 0U);
    EXPECT_EQ(time.sequence, 470 + i) << "60.05 s are 469.1 intervals";
    // No latency in this scene: the first byte comes at the latch.
    const double t = to_seconds(sample.header.arrival_time - kSceneStart);
    EXPECT_NEAR(to_seconds(sample.header.device_time->time_since_epoch()), board->clock().device_time_s(t), 2e-9);
    EXPECT_NEAR(board->ticks_at(t), static_cast<double>(time.tick), 1e-5);
  }
}

TEST(LedBoard, ItsClockRunsEvenlyAndWrapsOnlyOnTheWire) {
  LedBoardOptions options;
  options.split_probability = 0;
  // A minute before its 32 bits are full.
  options.timing = {.counter_offset_s = 4294967296.0 * 0.0005 - 60};
  const auto board = std::make_shared<LedBoard>("led_board", options, 1);
  EXPECT_NEAR(board->ticks_at(60), 4294967296.0, 1e-3);
  EXPECT_GT(board->ticks_at(100), 4294967296.0);
  auto device = make_led_board_device(board, 1);
  const auto decoded = play_and_decode(*device, 120);
  bool has_wrapped = false;
  for (std::size_t i = 1; i < decoded->samples.size(); ++i) {
    EXPECT_EQ(*decoded->samples[i].header.device_time - *decoded->samples[i - 1].header.device_time,
              std::chrono::milliseconds(128));
    has_wrapped = has_wrapped || std::get<LedBoardTime>(decoded->samples[i].payload).tick == 0;
  }
  EXPECT_TRUE(has_wrapped);
}

TEST(LedBoard, AnotherTickLengthIsSaid) {
  LedBoardOptions options;
  options.tick_s = 0.00025;
  options.timing = {};
  auto device = make_led_board_device(std::make_shared<LedBoard>("led_board", options, 1), 1);
  const auto decoded = play_and_decode(*device, 1);
  ASSERT_GE(decoded->samples.size(), 15U);
  EXPECT_EQ(to_ns(*decoded->samples[10].header.device_time), 640'000'000);
}

TEST(LedBoard, TheHostsClockModelFindsItsOffset) {
  LedBoardOptions options;
  options.timing = {.frequency_offset_ppm = 35, .latency_s = 0.001, .jitter_s = 0.0005, .counter_offset_s = 500};
  options.timing.spike_probability = 0.02;
  const auto board = std::make_shared<LedBoard>("led_board", options, 1);
  auto device = make_led_board_device(board, 1);
  const auto decoded = play_and_decode(*device, 60);
  sync::LowerHullClock model;
  for (const Sample& sample : decoded->samples) model.observe(sample.header.device_time, sample.header.arrival_time);
  const ClockState truth = board->clock().state("led_board", kSceneStart, 60);
  EXPECT_NEAR(model.state().offset_s, truth.offset_s + 0.001, 0.0002) << "the constant latency cannot be seen";
  EXPECT_NEAR(model.state().frequency_offset_ppm, 35, 5);
}

}  // namespace
}  // namespace roseau::synthesis
