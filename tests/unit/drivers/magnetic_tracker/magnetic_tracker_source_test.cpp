#include "drivers/magnetic_tracker/magnetic_tracker_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/wire/make_decoder.h"
#include "tests/unit/drivers/scripted_device.h"

namespace roseau::magnetic_tracker {
namespace {

using std::chrono::milliseconds;
using testing::ScriptedDevice;
using testing::ScriptedStream;
using namespace std::string_literals;

struct Collector : SampleSink {
  bool receive(Sample sample) override {
    for (const std::byte byte : std::get<RawBytes>(sample.payload).bytes()) text += static_cast<char>(byte);
    samples.push_back(std::move(sample));
    return true;
  }
  std::string text;
  std::vector<Sample> samples;
};

class MagneticTrackerSourceTest : public ::testing::Test {
 protected:
  std::shared_ptr<ScriptedDevice> device = std::make_shared<ScriptedDevice>();
  StreamTable streams;
  Collector sink;

  std::unique_ptr<MagneticTrackerSource> make(MagneticTrackerOptions options = {}) {
    return std::make_unique<MagneticTrackerSource>(std::move(options), std::make_unique<ScriptedStream>(device),
                                                   [this] { return device->now; });
  }
  Result<ReadStatus> read_for(SampleSource& source, Duration duration) {
    const HostTime end = device->now + duration;
    while (device->now < end) {
      auto status = source.read(sink, milliseconds(100));
      if (!status) return status;
    }
    return ReadStatus::idle;
  }
};

const std::string kSetUp = "cfuO1,2,11,0\rO2,2,11,0\rO3,2,11,0\rO4,2,11,0\rSC";

TEST_F(MagneticTrackerSourceTest, DeclaresTheStreamsOfItsStations) {
  MagneticTrackerOptions options;
  options.name = "polhemus";
  options.tracker.stations = {1, 3};
  auto source = make(options);
  ASSERT_TRUE(source->open(streams));
  EXPECT_TRUE(streams.find("/polhemus/raw"));
  EXPECT_TRUE(streams.find("/polhemus/station1/pose"));
  EXPECT_TRUE(streams.find("/polhemus/station3/pose"));
  EXPECT_FALSE(streams.find("/polhemus/station2/pose"));
  EXPECT_EQ(streams.info(*streams.find("/polhemus/raw")).metadata.at("link"), "scripted port");
}

TEST_F(MagneticTrackerSourceTest, SetsTheTrackerUpWhenItAnswers) {
  auto source = make();
  ASSERT_TRUE(source->open(streams));
  EXPECT_EQ(device->take_commands(), "S");
  device->to_host = wire::encode_fastrak_status({});
  ASSERT_TRUE(source->read(sink, milliseconds(100)));
  EXPECT_EQ(device->take_commands(), kSetUp);
  EXPECT_EQ(sink.text, wire::encode_fastrak_status({})) << "answers are bytes like any other";
}

TEST_F(MagneticTrackerSourceTest, TextAndInchesAreAskedForWithTheirLetters) {
  MagneticTrackerOptions options;
  options.tracker.is_binary = false;
  options.tracker.unit = wire::FastrakUnit::inch;
  options.tracker.layout = wire::default_fastrak_layout();
  options.tracker.stations = {2};
  auto source = make(options);
  ASSERT_TRUE(source->open(streams));
  device->to_host = wire::encode_fastrak_status({});
  ASSERT_TRUE(source->read(sink, milliseconds(100)));
  EXPECT_EQ(device->take_commands(), "SScFUO2,2,4,1\rSC"s.substr(1));
}

TEST_F(MagneticTrackerSourceTest, SilenceAfterPowerUpIsWaitedOut) {
  auto source = make();
  ASSERT_TRUE(source->open(streams));
  ASSERT_TRUE(read_for(*source, std::chrono::seconds(19)));
  const std::string asked = device->take_commands();
  EXPECT_GE(asked.size(), 8U);
  EXPECT_LE(asked.size(), 11U);
  EXPECT_EQ(asked.find_first_not_of('S'), std::string::npos);
  device->to_host = wire::encode_fastrak_status({});
  ASSERT_TRUE(source->read(sink, milliseconds(100)));
  EXPECT_EQ(device->take_commands(), kSetUp);
}

TEST_F(MagneticTrackerSourceTest, NoiseOfPowerUpIsNoAnswer) {
  auto source = make();
  ASSERT_TRUE(source->open(streams));
  device->take_commands();
  device->to_host = "\xff\x00\xf8\x80"s;
  ASSERT_TRUE(source->read(sink, milliseconds(100)));
  EXPECT_EQ(device->take_commands(), "");
}

TEST_F(MagneticTrackerSourceTest, ATrackerThatNeverAnswersIsAnErrorInWords) {
  auto source = make();
  ASSERT_TRUE(source->open(streams));
  const auto status = read_for(*source, std::chrono::seconds(60));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::timeout);
  EXPECT_THAT(status.error().message, ::testing::HasSubstr("scripted port does not answer"));
  // Opened again, it is given the same patience again.
  ASSERT_TRUE(source->open(streams));
  EXPECT_TRUE(read_for(*source, std::chrono::seconds(39)));
}

TEST_F(MagneticTrackerSourceTest, ATrackerSwitchedOffAndOnIsSetUpAgain) {
  auto source = make();
  ASSERT_TRUE(source->open(streams));
  device->to_host = wire::encode_fastrak_status({});
  ASSERT_TRUE(source->read(sink, milliseconds(100)));
  for (int i = 0; i < 100; ++i) {
    device->to_host = "01 ";
    device->now += milliseconds(100);
    ASSERT_TRUE(source->read(sink, milliseconds(100)));
  }
  EXPECT_EQ(device->take_commands(), "S" + kSetUp) << "while it sends, it is left alone";
  ASSERT_TRUE(read_for(*source, std::chrono::seconds(4)));
  EXPECT_EQ(device->take_commands(), "S");
  device->to_host = wire::encode_fastrak_status({});
  ASSERT_TRUE(source->read(sink, milliseconds(100)));
  EXPECT_EQ(device->take_commands(), kSetUp);
}

TEST_F(MagneticTrackerSourceTest, WhereNobodyIsConnectedYetWeWait) {
  device->is_connected = false;
  auto source = make();
  ASSERT_TRUE(source->open(streams));
  ASSERT_TRUE(read_for(*source, std::chrono::seconds(10)));
  device->is_connected = true;
  ASSERT_TRUE(read_for(*source, std::chrono::seconds(3)));
  EXPECT_THAT(device->take_commands(), ::testing::StartsWith("S"));
}

TEST_F(MagneticTrackerSourceTest, AnObserverAndARecordingSayNothing) {
  MagneticTrackerOptions options;
  options.sets_up = false;
  auto observer = make(options);
  ASSERT_TRUE(observer->open(streams));
  ASSERT_TRUE(read_for(*observer, std::chrono::seconds(100)));
  device->is_live = false;
  auto recording = make();
  ASSERT_TRUE(recording->open(streams));
  ASSERT_TRUE(read_for(*recording, std::chrono::seconds(100)));
  EXPECT_EQ(device->take_commands(), "");
}

}  // namespace
}  // namespace roseau::magnetic_tracker
