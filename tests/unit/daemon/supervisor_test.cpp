#include "daemon/supervisor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace roseau::daemon {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

/// Plays a script: how often opening fails, how many samples come, then whether the device is lost or has finished.
class ScriptedSource : public SampleSource {
 public:
  struct Script {
    bool live = true;
    int failing_opens = 0;
    ErrorCode open_error = ErrorCode::not_found;
    int samples_per_life = 3;
    int lives = 1;  // after each but the last the device is lost
  };
  explicit ScriptedSource(Script script) : script_(script) {}
  const std::string& name() const override { return name_; }
  bool is_live() const override { return script_.live; }
  Result<void> open(StreamTable& streams) override {
    if (script_.failing_opens-- > 0) return Error{script_.open_error, "port /dev/nothing is absent"};
    stream_ = streams.add({.topic = "/fake/wind", .kind = "wind"});
    left_ = script_.samples_per_life;
    return {};
  }
  Result<ReadStatus> read(SampleSink& sink, milliseconds) override {
    if (left_-- > 0) {
      Sample sample;
      sample.header.stream = stream_;
      sample.payload = WindSample{};
      sink.receive(std::move(sample));
      return ReadStatus::more;
    }
    if (--script_.lives > 0) return Error{ErrorCode::disconnected, "unplugged"};
    return ReadStatus::finished;
  }
  void close() override {}

 private:
  Script script_;
  std::string name_ = "fake";
  StreamId stream_ = 0;
  int left_ = 0;
};

struct Outcome {
  int samples = 0;
  Health::Device device;
};

Outcome supervise(ScriptedSource::Script script) {
  StreamTable streams;
  sync::CounterTable counters;
  sync::Intake intake(counters);
  Supervisor supervisor({.first_backoff = milliseconds(1), .longest_backoff = milliseconds(2)}, streams, intake);
  supervisor.add(std::make_unique<ScriptedSource>(script), 64);
  supervisor.start();
  Outcome outcome;
  intake.run({}, {.take = [&outcome](const Sample&) { ++outcome.samples; }, .idle = [] {}});
  supervisor.stop();
  outcome.device = supervisor.devices().front();
  return outcome;
}

TEST(Supervisor, OpensAgainAfterTheDeviceIsLostAndLosesNoSample) {
  const auto outcome = supervise({.failing_opens = 2, .samples_per_life = 4, .lives = 3});
  EXPECT_EQ(outcome.samples, 12);
  EXPECT_EQ(outcome.device.state, DeviceState::finished);
}

TEST(Supervisor, WrongConfigurationFailsForGoodWithItsMessage) {
  const auto outcome = supervise({.failing_opens = 1, .open_error = ErrorCode::invalid_argument});
  EXPECT_EQ(outcome.samples, 0);
  EXPECT_EQ(outcome.device.state, DeviceState::failed);
  EXPECT_THAT(outcome.device.message, HasSubstr("/dev/nothing"));
}

TEST(Supervisor, ARecordingThatCannotBeOpenedIsNotTriedAgain) {
  EXPECT_EQ(supervise({.live = false, .failing_opens = 1}).device.state, DeviceState::failed);
}

TEST(Supervisor, SilentDeviceIsDegradedAndStopsWhenAsked) {
  class Silent : public SampleSource {
   public:
    const std::string& name() const override { return name_; }
    bool is_live() const override { return true; }
    Result<void> open(StreamTable&) override { return {}; }
    Result<ReadStatus> read(SampleSink&, milliseconds) override {
      std::this_thread::sleep_for(milliseconds(1));
      return ReadStatus::idle;
    }
    void close() override {}

   private:
    std::string name_ = "silent";
  };
  StreamTable streams;
  sync::CounterTable counters;
  sync::Intake intake(counters);
  Supervisor supervisor({.silence = milliseconds(5)}, streams, intake);
  supervisor.add(std::make_unique<Silent>(), 8);
  supervisor.start();
  while (supervisor.devices().front().state != DeviceState::degraded) std::this_thread::yield();
  EXPECT_THAT(supervisor.devices().front().message, HasSubstr("check its cable"));
  supervisor.stop();
}

}  // namespace
}  // namespace roseau::daemon
