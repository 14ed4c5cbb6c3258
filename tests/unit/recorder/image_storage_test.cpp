// Pictures as PNG and JPEG: what a recording of them holds.
#include "recorder/image_storage.h"

#include <gtest/gtest.h>

#include <thread>

#include "core/image_coding/jpeg.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/recorder.h"
#include "schema/conversion.h"
#include "tests/support/samples.h"
#include "tests/support/temporary_folder.h"

namespace roseau::recorder {
namespace {

constexpr std::uint32_t kWidth = 80;
constexpr std::uint32_t kHeight = 60;

class ImageStorageTest : public ::testing::Test {
 protected:
  Sample frame_sample(std::uint32_t number) {
    while (pool_.free_count() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the recorder has them
    const HostTime time = host_time_from_ns(1'000'000'000 + std::int64_t{number} * 5'000'000);
    Sample sample{{.stream = camera_, .sequence = number, .arrival_time = time, .sample_time = time},
                  testing::filled_frame(pool_, kWidth, kHeight, kWidth + 8)};
    auto& frame = std::get<Frame>(sample.payload);
    const auto pixels = frame.pixels.writable_bytes();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      pixels[i] = static_cast<std::byte>((i % (kWidth + 8)) + number + (i * i) % 7);
    }
    return sample;
  }
  Sample wind_sample(std::uint32_t number) {
    const HostTime time = host_time_from_ns(1'000'000'000 + std::int64_t{number} * 5'000'000 + 1);
    return {{.stream = wind_, .sequence = number, .arrival_time = time, .sample_time = time},
            WindSample{.u_mps = 1.0 * number}};
  }
  void add_jpeg(Sample& sample, FramePool& pool) {
    auto& frame = std::get<Frame>(sample.payload);
    frame.coded = {.lease = pool.acquire(), .format = ImageStorage::jpeg};
    frame.coded.size = *image::JpegEncoder(80).encode(image::view_of(frame), frame.coded.lease.writable_bytes());
  }
  /// Frames and wind in turn.
  std::filesystem::path record(const std::string& name, std::uint32_t count, RecorderOptions options) {
    const auto path = folder_.path() / name;
    options.wait_when_full = true;
    options.chunk_bytes = 40'000;
    Recorder recorder(streams_, options);
    EXPECT_TRUE(recorder.open(path, {.program_version = "0.1.0"}));
    for (std::uint32_t i = 0; i < count; ++i) {
      const Sample frame = frame_sample(i);
      EXPECT_TRUE(recorder.record(frame, frame.header.arrival_time));
      const Sample wind = wind_sample(i);
      EXPECT_TRUE(recorder.record(wind, wind.header.arrival_time));
    }
    const auto closed = recorder.close();
    EXPECT_TRUE(closed) << closed.error().message;
    EXPECT_EQ(recorder.state().streams.at("/camera0/image").recorded, count);
    return path;
  }
  static std::unique_ptr<mcap::IndexedReader> read(const std::filesystem::path& path) {
    auto reader = mcap::IndexedReader::open(path);
    EXPECT_TRUE(reader) << reader.error().message;
    EXPECT_TRUE((*reader)->index().damage.empty());
    return std::move(*reader);
  }
  void expect_frames(const std::filesystem::path& path, std::uint32_t count) {
    const auto reader = read(path);
    FramePool frames(2, (kWidth + 8) * kHeight);
    std::uint64_t last_log_time_ns = 0;
    std::uint32_t seen = 0;
    auto cursor = reader->messages();
    while (const auto message = *cursor.next()) {
      EXPECT_GT(message->message.log_time_ns, last_log_time_ns);
      last_log_time_ns = message->message.log_time_ns;
      if (message->channel->topic != "/camera0/image") continue;
      const auto sample = schema::parse(SampleKind::frame, message->message.data, {.stream = camera_}, streams_, &frames);
      ASSERT_TRUE(sample) << sample.error().message;
      const Sample original = frame_sample(seen);
      EXPECT_EQ(sample->header.sequence, seen++);
      const auto& before = std::get<Frame>(original.payload);
      const auto& after = std::get<Frame>(sample->payload);
      EXPECT_EQ(after.exposure_duration, before.exposure_duration);
      for (std::uint32_t y = 0; y < kHeight; ++y) {
        EXPECT_TRUE(std::ranges::equal(after.bytes().subspan(std::size_t{y} * after.stride, kWidth),
                                       before.bytes().subspan(std::size_t{y} * before.stride, kWidth)));
      }
    }
    EXPECT_EQ(seen, count);
  }

  testing::TemporaryFolder folder_;
  StreamTable streams_;
  StreamId camera_ = streams_.add({.topic = "/camera0/image", .kind = "frame", .device = "camera0"});
  StreamId wind_ = streams_.add({.topic = "/sonic/wind", .kind = "wind", .device = "sonic"});
  FramePool pool_{60, (kWidth + 8) * kHeight};
};

TEST_F(ImageStorageTest, PngHoldsTheSamePicturesInTheSameOrder) {
  const auto path = record("png.mcap", 200, {.image_storage = {{"camera0", ImageStorage::png}}});
  expect_frames(path, 200);
  const auto reader = read(path);
  const auto* channel = reader->channel_of_topic("/camera0/image");
  EXPECT_EQ(reader->catalog().schema_of(*channel)->name, "foxglove.CompressedImage");
  EXPECT_EQ(channel->metadata.at("storage"), "png");
  // Pictures are never compressed twice: each PNG stands in the file as it is.
  const std::string bytes = testing::read_text_file(path);
  std::size_t files = 0;
  for (std::size_t at = 0; (at = bytes.find("\x89PNG\r\n", at)) != std::string::npos; ++at) ++files;
  EXPECT_EQ(files, 200U);
  const auto raw = record("raw.mcap", 200, {});
  expect_frames(raw, 200);
  EXPECT_LT(std::filesystem::file_size(path), std::filesystem::file_size(raw) * 2 / 3);
}

TEST_F(ImageStorageTest, TheSameSamplesGiveTheSameFile) {
  const RecorderOptions options{.reproducible = true, .image_storage = {{"camera0", ImageStorage::png}}};
  const auto first = testing::read_text_file(record("a.mcap", 150, options));
  const auto second = testing::read_text_file(record("b.mcap", 150, options));
  EXPECT_TRUE(first == second);
}

TEST_F(ImageStorageTest, WhatTheStreamSaysHoldsWhereTheConfigurationSaysNothing) {
  const StreamInfo replayed{.topic = "/left", .kind = "frame", .device = "left", .metadata = {{"storage", "png"}}};
  Sample sample = frame_sample(0);
  EXPECT_EQ(storage_of(sample, replayed, {}), ImageStorage::png);
  EXPECT_EQ(storage_of(sample, replayed, {.image_storage = {{"left", ImageStorage::raw}}}), ImageStorage::raw);
  EXPECT_FALSE(stored_stream(sample, replayed, {.image_storage = {{"left", ImageStorage::raw}}}).metadata.contains("storage"));
  const StreamInfo other{.topic = "/left", .kind = "frame", .metadata = {{"storage", "as_received"}}};
  EXPECT_EQ(stored_stream(sample, other, {}).metadata.at("storage"), "as_received");
  EXPECT_EQ(storage_of(wind_sample(0), {.kind = "wind"}, {}), ImageStorage::raw);
}

TEST_F(ImageStorageTest, FramesThatComeCodedAreStoredAsTheyAre) {
  FramePool coded(4, 20'000);
  const auto path = folder_.path() / "jpeg.mcap";
  Recorder recorder(streams_, {.image_storage = {{"camera0", ImageStorage::jpeg}}});
  ASSERT_TRUE(recorder.open(path, {}));
  Sample first = frame_sample(0);
  add_jpeg(first, coded);
  const auto stored = std::get<Frame>(first.payload).coded.bytes();
  const std::vector<std::byte> file(stored.begin(), stored.end());
  ASSERT_TRUE(recorder.record(first, first.header.arrival_time));
  // One that has only its stored form left, and one that has none: that becomes a PNG.
  Sample second = frame_sample(1);
  add_jpeg(second, coded);
  std::get<Frame>(second.payload).pixels = {};
  ASSERT_TRUE(recorder.record(second, second.header.arrival_time));
  const Sample third = frame_sample(2);
  ASSERT_TRUE(recorder.record(third, third.header.arrival_time));
  ASSERT_TRUE(recorder.close());
  EXPECT_EQ(recorder.state().streams.at("/camera0/image").recorded, 3U);

  const auto reader = read(path);
  EXPECT_EQ(reader->channel_of_topic("/camera0/image")->metadata.at("storage"), "jpeg");
  auto cursor = reader->messages();
  for (int i = 0; i < 3; ++i) {
    const auto message = *cursor.next();
    const auto view = schema::parse_frame(message->message.data, {});
    ASSERT_TRUE(view) << view.error().message;
    EXPECT_EQ(view->storage, i < 2 ? ImageStorage::jpeg : ImageStorage::png);
    EXPECT_TRUE(i > 0 || std::ranges::equal(view->coded, file));
  }
}

TEST_F(ImageStorageTest, AFrameThatCannotBeCodedIsLostAndCountedAndTheRestIsNot) {
  const auto path = folder_.path() / "broken.mcap";
  Recorder recorder(streams_, {.image_storage = {{"camera0", ImageStorage::png}}});
  ASSERT_TRUE(recorder.open(path, {}));
  for (std::uint32_t i = 0; i < 5; ++i) {
    Sample sample = frame_sample(i);
    if (i == 2) std::get<Frame>(sample.payload).width = 0;
    recorder.record(sample, sample.header.arrival_time);
  }
  const auto closed = recorder.close();
  EXPECT_FALSE(closed);  // something was lost
  const auto counters = recorder.state().streams.at("/camera0/image");
  EXPECT_EQ(counters.received, 5U);
  EXPECT_EQ(counters.recorded, 4U);
  EXPECT_EQ(counters.dropped_encoder, 1U);
  EXPECT_EQ(counters.dropped, 1U);
  EXPECT_EQ(recorder.state().state, DeviceState::degraded);
  const auto reader = read(path);
  EXPECT_EQ(reader->index().statistics.channel_message_counts.at(reader->channel_of_topic("/camera0/image")->id), 4U);
}

TEST_F(ImageStorageTest, SplittingLosesNothingAndKeepsTheSize) {
  RecorderOptions options{.image_storage = {{"camera0", ImageStorage::png}}, .split = {.bytes = 100'000}};
  std::vector<FinishedPart> parts;
  options.part_finished = [&](const FinishedPart& part) { parts.push_back(part); };
  record("split.mcap", 120, options);
  ASSERT_GT(parts.size(), 2U);
  std::uint32_t frames = 0;
  for (const auto& part : parts) {
    EXPECT_LE(part.bytes, 100'000U);
    const auto reader = read(part.path);
    EXPECT_EQ(reader->channel_of_topic("/camera0/image")->metadata.at("storage"), "png");
    auto cursor = reader->messages();
    while (const auto message = *cursor.next()) {
      if (message->channel->topic != "/camera0/image") continue;
      EXPECT_EQ(message->message.sequence, frames++);
    }
  }
  EXPECT_EQ(frames, 120U);
}

}  // namespace
}  // namespace roseau::recorder
