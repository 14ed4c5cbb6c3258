#include "drivers/led_sync/led_board_source.h"

#include <gtest/gtest.h>

#include "tests/unit/drivers/scripted_device.h"

namespace roseau::led_sync {
namespace {

using std::chrono::milliseconds;
using testing::ScriptedDevice;
using testing::ScriptedStream;

struct Collector : SampleSink {
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  std::vector<Sample> samples;
};

class LedBoardSourceTest : public ::testing::Test {
 protected:
  std::shared_ptr<ScriptedDevice> device = std::make_shared<ScriptedDevice>();
  StreamTable streams;
  Collector sink;

  LedBoardSource make(LedBoardOptions options = {}) {
    return {std::move(options), std::make_unique<ScriptedStream>(device), [this] { return device->now; }};
  }
};

TEST_F(LedBoardSourceTest, DeclaresItsStreamsAndTellsTheTick) {
  auto source = make({.name = "board", .board = {.tick_us = 250}});
  ASSERT_TRUE(source.open(streams));
  for (const char* topic : {"/board/raw", "/board/time", "/board/edge", "/board/probe"})
    EXPECT_TRUE(streams.find(topic)) << topic;
  EXPECT_EQ(streams.info(*streams.find("/board/raw")).metadata.at("tick_us"), "250");
  EXPECT_EQ(device->take_commands(), "V\nB250\n");
}

TEST_F(LedBoardSourceTest, BytesAreHandedOnAsTheyCome) {
  auto source = make();
  ASSERT_TRUE(source.open(streams));
  device->to_host = "T,256,0,1*48\r\n";
  const auto status = source.read(sink, milliseconds(100));
  ASSERT_TRUE(status);
  EXPECT_EQ(*status, ReadStatus::more);
  ASSERT_EQ(sink.samples.size(), 1U);
  EXPECT_EQ(std::get<RawBytes>(sink.samples[0].payload).size, 14);
  EXPECT_EQ(sink.samples[0].header.arrival_time, device->now);
}

TEST_F(LedBoardSourceTest, ABoardThatWasSilentIsToldAgain) {
  auto source = make();
  ASSERT_TRUE(source.open(streams));
  device->take_commands();
  for (int i = 0; i < 50; ++i) {
    device->to_host = "T";
    device->now += milliseconds(128);
    ASSERT_TRUE(source.read(sink, milliseconds(100)));
  }
  EXPECT_EQ(device->take_commands(), "") << "while it sends, it is left alone";
  for (int i = 0; i < 21; ++i) ASSERT_TRUE(source.read(sink, milliseconds(100)));
  EXPECT_EQ(device->take_commands(), "V\nB500\n");
}

TEST_F(LedBoardSourceTest, AnObserverAndARecordingSayNothing) {
  auto observer = make({.sets_up = false});
  ASSERT_TRUE(observer.open(streams));
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(observer.read(sink, milliseconds(100)));
  device->is_live = false;
  auto recording = make();
  ASSERT_TRUE(recording.open(streams));
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(recording.read(sink, milliseconds(100)));
  EXPECT_EQ(device->take_commands(), "");
}

}  // namespace
}  // namespace roseau::led_sync
