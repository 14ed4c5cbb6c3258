#include "drivers/camera/jpeg/jpeg_camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <mutex>
#include <thread>

#include "core/image_coding/image_decoder.h"

namespace roseau::camera {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kWidth = 96;
constexpr std::uint32_t kHeight = 64;

/// Gives `count` frames (a calibration before every tenth), as fast as it is asked, then finishes or fails.
class ScriptedCamera final : public SampleSource {
 public:
  ScriptedCamera(int count, bool live, PixelFormat format = PixelFormat::mono8) : count_(count), live_(live), format_(format) {}
  const std::string& name() const override { return name_; }
  bool is_live() const override { return live_; }
  Result<void> open(StreamTable& streams) override {
    images_ = streams.add({.topic = "/camera0/image", .kind = "frame", .device = "camera0"});
    calibration_ = streams.add({.topic = "/camera0/calibration", .kind = "camera_calibration", .device = "camera0"});
    ++opened;
    return {};
  }
  Result<ReadStatus> read(SampleSink& sink, std::chrono::milliseconds) override {
    if (next_ == count_) {
      if (fails) return Error{ErrorCode::disconnected, "pulled"};
      return ReadStatus::finished;
    }
    if (next_ % 10 == 0) sink.receive({header(calibration_), CameraCalibration{.width = kWidth}});
    Frame frame{.pixels = pool_.acquire(), .width = kWidth, .height = kHeight, .stride = kWidth * 2, .format = format_};
    if (!frame.pixels) {
      std::this_thread::sleep_for(1ms);
      return ReadStatus::idle;
    }
    const auto pixels = frame.pixels.writable_bytes();
    for (std::size_t i = 0; i < pixels.size(); ++i)
      pixels[i] = static_cast<std::byte>((i * i / 61 + static_cast<std::size_t>(next_)) % 120);
    if (incompressible) {
      for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::byte>((i * 2654435761U) >> 16U);
    }
    if (next_ == broken_frame) frame.width = 0;
    sink.receive({header(images_), std::move(frame)});
    ++next_;
    return ReadStatus::more;
  }
  void close() override { ++closed; }

  bool fails = false;
  bool incompressible = false;
  int broken_frame = -1;
  std::atomic<int> opened{0};
  std::atomic<int> closed{0};

 private:
  SampleHeader header(StreamId stream) const {
    return {.stream = stream, .sequence = static_cast<std::uint32_t>(next_), .arrival_time = host_time_from_ns(next_)};
  }
  const std::string name_ = "camera0";
  const int count_;
  const bool live_;
  const PixelFormat format_;
  FramePool pool_{16, std::size_t{kWidth} * 2 * kHeight};
  StreamId images_ = 0;
  StreamId calibration_ = 0;
  int next_ = 0;
};

class Collector final : public SampleSink {
 public:
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  void drop(StreamId, std::uint64_t count) override { dropped += count; }
  std::vector<const Frame*> frames() const {
    std::vector<const Frame*> all;
    for (const auto& sample : samples) {
      if (const auto* frame = std::get_if<Frame>(&sample.payload)) all.push_back(frame);
    }
    return all;
  }
  std::deque<Sample> samples;
  std::uint64_t dropped = 0;
};

Result<ReadStatus> read_to_the_end(JpegCamera& camera, SampleSink& sink) {
  while (true) {
    auto status = camera.read(sink, 100ms);
    if (!status || *status == ReadStatus::finished) return status;
  }
}

/// The pixels are what a recording's reader will see.
void expect_pixels_of_stored_form(const Frame& frame) {
  ASSERT_TRUE(frame.coded);
  image::ImageDecoder decoder;
  std::vector<std::byte> pixels(frame.bytes().size());
  ASSERT_TRUE(decoder.decode(frame.coded.bytes(), pixels, frame.format));
  EXPECT_TRUE(std::ranges::equal(pixels, frame.bytes()));
}

void expect_in_order(const Collector& collected) {
  for (std::size_t i = 1; i < collected.samples.size(); ++i) {
    EXPECT_GE(collected.samples[i].header.sequence, collected.samples[i - 1].header.sequence);
  }
}

TEST(JpegCamera, ASourceThatIsNotLiveIsCodedInItsOrderAndLosesNothing) {
  StreamTable streams;
  Collector collected;
  JpegCamera camera(std::make_unique<ScriptedCamera>(25, false), {.quality = 80});
  ASSERT_TRUE(camera.open(streams));
  ASSERT_TRUE(read_to_the_end(camera, collected));
  camera.close();
  EXPECT_EQ(collected.samples.size(), 28U);
  ASSERT_EQ(collected.frames().size(), 25U);
  for (const Frame* frame : collected.frames()) {
    EXPECT_EQ(frame->coded.format, ImageStorage::jpeg);
    EXPECT_EQ(frame->stride, kWidth);
    expect_pixels_of_stored_form(*frame);
  }
  expect_in_order(collected);
}

TEST(JpegCamera, ALiveCameraGivesTheSamePicturesOrCountsThem) {
  StreamTable streams;
  Collector reference;
  JpegCamera waiting(std::make_unique<ScriptedCamera>(30, false), {.quality = 80});
  ASSERT_TRUE(waiting.open(streams));
  ASSERT_TRUE(read_to_the_end(waiting, reference));

  Collector collected;
  JpegCamera camera(std::make_unique<ScriptedCamera>(30, true), {.quality = 80, .threads = 3, .most_waiting = 4});
  EXPECT_TRUE(camera.is_live());
  ASSERT_TRUE(camera.open(streams));
  ASSERT_TRUE(read_to_the_end(camera, collected));
  camera.close();
  EXPECT_EQ(collected.frames().size() + collected.dropped, 30U);
  EXPECT_GT(collected.frames().size(), 0U);
  expect_in_order(collected);
  for (const Sample& sample : collected.samples) {
    if (sample.kind() != SampleKind::frame) continue;
    const auto same = std::ranges::find_if(reference.samples, [&](const Sample& other) {
      return other.kind() == SampleKind::frame && other.header.sequence == sample.header.sequence;
    });
    EXPECT_TRUE(
        std::ranges::equal(std::get<Frame>(sample.payload).coded.bytes(), std::get<Frame>(same->payload).coded.bytes()));
  }
}

TEST(JpegCamera, WhenConsumersHoldEverythingFramesAreDroppedAndCounted) {
  StreamTable streams;
  Collector collected;  // lets nothing go
  JpegCamera camera(std::make_unique<ScriptedCamera>(200, true), {});
  ASSERT_TRUE(camera.open(streams));
  ASSERT_TRUE(read_to_the_end(camera, collected));
  camera.close();
  EXPECT_GT(collected.dropped, 100U);
  EXPECT_EQ(collected.frames().size() + collected.dropped, 200U);
}

TEST(JpegCamera, AFailureComesAfterWhatWasReadBeforeIt) {
  StreamTable streams;
  Collector collected;
  auto scripted = std::make_unique<ScriptedCamera>(3, true);
  scripted->fails = true;
  ScriptedCamera& inside = *scripted;
  JpegCamera camera(std::move(scripted), {});
  for (int round = 1; round <= 2; ++round) {  // as the supervisor does: again and again
    ASSERT_TRUE(camera.open(streams));
    const auto status = read_to_the_end(camera, collected);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().message, "pulled");
    EXPECT_EQ(collected.frames().size() + collected.dropped, 3U);
    camera.close();
    EXPECT_EQ(inside.opened, round);
    EXPECT_EQ(inside.closed, round);
  }
}

TEST(JpegCamera, WhatJpegCannotHoldIsStoredAsPng) {
  for (const bool sixteen_bits : {true, false}) {
    StreamTable streams;
    Collector collected;
    auto scripted = std::make_unique<ScriptedCamera>(2, false, sixteen_bits ? PixelFormat::mono16 : PixelFormat::mono8);
    scripted->incompressible = !sixteen_bits;
    JpegCamera camera(std::move(scripted), {.quality = 100});
    ASSERT_TRUE(camera.open(streams));
    ASSERT_TRUE(read_to_the_end(camera, collected));
    ASSERT_EQ(collected.frames().size(), 2U);
    EXPECT_EQ(collected.frames().front()->coded.format, ImageStorage::png);
  }
}

TEST(JpegCamera, AFrameThatIsNoPictureIsDroppedAndCounted) {
  for (const bool live : {true, false}) {
    StreamTable streams;
    Collector collected;
    auto scripted = std::make_unique<ScriptedCamera>(4, live);
    scripted->broken_frame = 1;
    JpegCamera camera(std::move(scripted), {});
    ASSERT_TRUE(camera.open(streams));
    ASSERT_TRUE(read_to_the_end(camera, collected));
    camera.close();
    EXPECT_EQ(collected.frames().size(), 3U);
    EXPECT_EQ(collected.dropped, 1U);
  }
}

}  // namespace
}  // namespace roseau::camera
