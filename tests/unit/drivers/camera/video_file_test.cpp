#include "drivers/camera/file/video_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/data.h"
#include "tests/support/raw_avi.h"
#include "tests/support/temporary_folder.h"

namespace roseau::camera {
namespace {

using roseau::testing::RawAvi;
using roseau::testing::TemporaryFolder;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

struct Collector : SampleSink {
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  const Frame& frame(std::size_t index) const { return std::get<Frame>(samples.at(index).payload); }
  std::vector<Sample> samples;
};

struct TimesOnly : SampleSink {
  bool receive(Sample sample) override {
    times_s.push_back(to_seconds(sample.header.sample_time.time_since_epoch()));
    return true;
  }
  std::vector<double> times_s;
};

constexpr HostTime kStart{std::chrono::seconds{100}};

std::unique_ptr<VideoFile> opened(const VideoFileOptions& options, StreamTable& streams) {
  auto video = make_video_file(options);
  EXPECT_TRUE(video) << video.error().message;
  const auto result = (*video)->open(streams);
  EXPECT_TRUE(result) << result.error().message;
  return std::move(*video);
}

Error opening_error(const VideoFileOptions& options) {
  StreamTable streams;
  auto video = make_video_file(options);
  EXPECT_TRUE(video) << video.error().message;
  const auto result = (*video)->open(streams);
  return result ? Error{ErrorCode::io, "no error"} : result.error();
}

void read_all(VideoFile& video, SampleSink& sink) {
  for (int i = 0; i < 10'000; ++i) {
    const auto status = video.read(sink, milliseconds{1});
    ASSERT_TRUE(status) << status.error().message;
    if (*status == ReadStatus::finished) return;
  }
  FAIL() << "the video does not end";
}

// Three frames whose every pixel tells its place.
RawAvi patterned() {
  RawAvi avi{.announced_frames = 3};
  for (int frame = 0; frame < 3; ++frame) {
    std::string picture;
    for (std::uint32_t y = 0; y < avi.height; ++y) {
      for (std::uint32_t x = 0; x < avi.width; ++x) {
        picture += {static_cast<char>(10 * frame), static_cast<char>(y), static_cast<char>(x)};
      }
    }
    avi.chunks.push_back(picture);
  }
  return avi;
}

TEST(VideoFile, HandsOnEveryPixelAndItsTime) {
  const TemporaryFolder folder;
  const auto path = folder.write("pattern.avi", patterned().bytes());
  StreamTable streams;
  auto video = opened({.name = "camera1", .path = path, .start = kStart, .start_offset = milliseconds{5}}, streams);
  EXPECT_FALSE(video->is_live());
  Collector collector;
  read_all(*video, collector);
  ASSERT_EQ(collector.samples.size(), 3U);
  const auto stream = streams.find("/camera1/image");
  ASSERT_TRUE(stream);
  EXPECT_EQ(streams.info(*stream).kind, "frame");
  EXPECT_EQ(streams.info(*stream).role, StreamRole::raw);
  EXPECT_EQ(streams.info(*stream).metadata.at("rate_hz"), "10");
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& header = collector.samples[i].header;
    EXPECT_EQ(header.stream, *stream);
    EXPECT_EQ(header.sequence, i);
    EXPECT_EQ(header.sample_time, kStart + milliseconds{5 + 100 * static_cast<int>(i)});
    EXPECT_EQ(header.arrival_time, header.sample_time);
    const Frame& frame = collector.frame(i);
    EXPECT_EQ(frame.format, PixelFormat::bgr8);
    ASSERT_EQ(frame.bytes().size(), 8U * 4U * 3U);
    for (std::size_t y = 0; y < 4; ++y) {
      for (std::size_t x = 0; x < 8; ++x) {
        const auto* pixel = frame.bytes().data() + y * frame.stride + x * 3;
        EXPECT_EQ(std::to_integer<std::size_t>(pixel[0]), 10 * i);
        EXPECT_EQ(std::to_integer<std::size_t>(pixel[1]), y);
        EXPECT_EQ(std::to_integer<std::size_t>(pixel[2]), x);
      }
    }
  }
  EXPECT_EQ(video->info().frames, 3U);
  EXPECT_EQ(video->info().warning, "");
}

TEST(VideoFile, MonoIsTheUsualLuminance) {
  const TemporaryFolder folder;
  RawAvi avi{.announced_frames = 1};
  avi.chunks = {avi.plain(100, 50, static_cast<char>(200))};
  StreamTable streams;
  auto video = opened({.path = folder.write("plain.avi", avi.bytes()), .format = PixelFormat::mono8, .start = kStart}, streams);
  Collector collector;
  read_all(*video, collector);
  ASSERT_EQ(collector.samples.size(), 1U);
  ASSERT_EQ(collector.frame(0).bytes().size(), 32U);
  const double expected = 0.299 * 200 + 0.587 * 50 + 0.114 * 100;
  for (const auto pixel : collector.frame(0).bytes()) EXPECT_NEAR(std::to_integer<int>(pixel), expected, 1);
}

TEST(VideoFile, AGivenRateReplacesTheContainersTimes) {
  const TemporaryFolder folder;
  StreamTable streams;
  auto video = opened({.path = folder.write("pattern.avi", patterned().bytes()), .rate_hz = 3.0, .start = kStart}, streams);
  TimesOnly sink;
  read_all(*video, sink);
  EXPECT_THAT(sink.times_s, ::testing::ElementsAre(::testing::DoubleNear(100, 1e-9), ::testing::DoubleNear(100 + 1.0 / 3, 2e-9),
                                                   ::testing::DoubleNear(100 + 2.0 / 3, 2e-9)));
}

TEST(VideoFile, TimesWithoutAPictureAreKeptOpenAndReported) {
  const TemporaryFolder folder;
  RawAvi avi{.announced_frames = 6};
  const auto picture = avi.plain(1, 2, 3);
  avi.chunks = {picture, "", "", picture, "", picture};
  StreamTable streams;
  auto video = opened({.path = folder.write("holes.avi", avi.bytes()), .start = kStart}, streams);
  TimesOnly sink;
  read_all(*video, sink);
  EXPECT_THAT(sink.times_s, ::testing::ElementsAre(::testing::DoubleNear(100, 1e-6), ::testing::DoubleNear(100.3, 1e-6),
                                                   ::testing::DoubleNear(100.5, 1e-6)));
  EXPECT_THAT(video->info().warning, HasSubstr("announces 6 frames and holds 3 pictures"));
}

TEST(VideoFile, AFileCutOffGivesWhatItHasAndSaysSo) {
  const TemporaryFolder folder;
  RawAvi avi{.announced_frames = 20};
  for (int i = 0; i < 20; ++i) avi.chunks.push_back(avi.plain(static_cast<char>(i), 0, 0));
  auto bytes = avi.bytes();
  bytes.resize(bytes.size() / 2);
  StreamTable streams;
  auto video = opened({.path = folder.write("cut.avi", bytes), .start = kStart}, streams);
  TimesOnly sink;
  read_all(*video, sink);
  EXPECT_GT(sink.times_s.size(), 5U);
  EXPECT_LT(sink.times_s.size(), 12U);
  EXPECT_THAT(video->info().warning, HasSubstr("announces 20 frames"));
}

TEST(VideoFile, SaysWhatIsWrongWithAFile) {
  const TemporaryFolder folder;
  const auto missing = opening_error({.path = (folder.path() / "missing.avi").string()});
  EXPECT_EQ(missing.code, ErrorCode::not_found);
  EXPECT_THAT(missing.message, HasSubstr("missing.avi' does not exist"));
  const auto text = opening_error({.path = folder.write("notes.txt", "no video at all")});
  EXPECT_EQ(text.code, ErrorCode::unsupported);
  EXPECT_THAT(text.message, HasSubstr("notes.txt"));
  const auto empty = opening_error({.path = folder.write("empty.avi", RawAvi{.announced_frames = 7}.bytes())});
  EXPECT_THAT(empty.message, HasSubstr("empty.avi"));
  EXPECT_NE(empty.message, "no error");
}

TEST(VideoFile, AVideoWithoutFramesSaysSo) {
  const TemporaryFolder folder;
  RawAvi avi{.announced_frames = 7};
  avi.chunks.assign(7, "");
  const auto error = opening_error({.path = folder.write("empty.avi", avi.bytes())});
  EXPECT_EQ(error.code, ErrorCode::corrupt);
  EXPECT_THAT(error.message, HasSubstr("holds no frame"));
}

TEST(VideoFile, RefusesOptionsThatMakeNoSense) {
  const TemporaryFolder folder;
  const auto path = folder.write("pattern.avi", patterned().bytes());
  EXPECT_THAT(opening_error({.path = path, .format = PixelFormat::mono16}).message, HasSubstr("bgr8 or mono8, not mono16"));
  EXPECT_THAT(opening_error({.path = path, .rate_hz = 0.0}).message, HasSubstr("0 frames per second"));
}

TEST(VideoFile, WaitsWhileItsConsumerHoldsEveryFrame) {
  const TemporaryFolder folder;
  StreamTable streams;
  auto video = opened({.path = folder.write("pattern.avi", patterned().bytes()), .start = kStart, .buffer_count = 2}, streams);
  Collector collector;
  EXPECT_EQ(*video->read(collector, milliseconds{1}), ReadStatus::more);
  EXPECT_EQ(*video->read(collector, milliseconds{1}), ReadStatus::more);
  EXPECT_EQ(*video->read(collector, milliseconds{1}), ReadStatus::idle);
  collector.samples.erase(collector.samples.begin());
  EXPECT_EQ(*video->read(collector, milliseconds{1}), ReadStatus::more);
  EXPECT_EQ(collector.samples.back().header.sequence, 2U);
  EXPECT_EQ(video->info().dropped_frames, 0U);
}

TEST(VideoFile, PacedItIsLiveAndKeepsItsTimes) {
  const TemporaryFolder folder;
  auto avi = patterned();
  avi.rate_hz = 50;
  StreamTable streams;
  auto video = opened({.path = folder.write("fast.avi", avi.bytes()), .is_paced = true}, streams);
  EXPECT_TRUE(video->is_live());
  Collector collector;
  read_all(*video, collector);
  ASSERT_EQ(collector.samples.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& header = collector.samples[i].header;
    EXPECT_GE(header.arrival_time, header.sample_time) << "no frame comes before its time";
    EXPECT_EQ(header.sample_time - collector.samples[0].header.sample_time, milliseconds{20 * static_cast<int>(i)});
  }
}

TEST(VideoFile, PacedItDropsWhatNobodyMakesRoomFor) {
  const TemporaryFolder folder;
  auto avi = patterned();
  avi.rate_hz = 200;
  StreamTable streams;
  auto video = opened({.path = folder.write("fast.avi", avi.bytes()), .is_paced = true, .buffer_count = 1}, streams);
  Collector collector;
  read_all(*video, collector);
  EXPECT_EQ(collector.samples.size(), 1U);
  EXPECT_EQ(video->info().dropped_frames, 2U);
}

TEST(VideoFile, CanBeOpenedAgain) {
  const TemporaryFolder folder;
  StreamTable streams;
  auto video = opened({.path = folder.write("pattern.avi", patterned().bytes()), .start = kStart}, streams);
  for (int round = 0; round < 2; ++round) {
    TimesOnly sink;
    read_all(*video, sink);
    EXPECT_EQ(sink.times_s.size(), 3U);
    video->close();
    ASSERT_TRUE(video->open(streams));
  }
  EXPECT_EQ(streams.size(), 1U);
}

// Debian's tree.avi: 444 frame times at 15 Hz of which only 68 hold a picture.
TEST(VideoFile, SurvivesTheHeaderOfTreeAvi) {
  ROSEAU_REQUIRE_DATA(path, "data/video_tree_opencv/tree.avi");
  StreamTable streams;
  auto video = opened({.path = path.string(), .start = kStart}, streams);
  TimesOnly sink;
  read_all(*video, sink);
  ASSERT_EQ(sink.times_s.size(), 68U);
  EXPECT_EQ(video->info().width, 320U);
  EXPECT_EQ(video->info().height, 240U);
  EXPECT_THAT(video->info().warning, HasSubstr("announces 444 frames and holds 68 pictures"));
  EXPECT_NEAR(sink.times_s[1] - 100, 11 / 15.0, 1e-4);  // eleven frame times later, by the file's own index
  EXPECT_NEAR(sink.times_s.back() - 100, 443 / 15.0, 1e-3);
}

TEST(VideoFile, ReadsPlantsAvi) {
  ROSEAU_REQUIRE_DATA(path, "data/video_plants/plants.avi");
  StreamTable streams;
  auto video = opened({.path = path.string(), .format = PixelFormat::mono8, .start = kStart}, streams);
  TimesOnly sink;
  read_all(*video, sink);
  ASSERT_EQ(sink.times_s.size(), 150U);
  EXPECT_EQ(video->info().warning, "");
  for (std::size_t i = 0; i < 150; ++i) EXPECT_NEAR(sink.times_s[i] - 100, static_cast<double>(i) / 30.0, 1e-6);
}

}  // namespace
}  // namespace roseau::camera
