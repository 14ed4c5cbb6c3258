// Sessions of pictures that are stored as PNG or JPEG.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/image_coding/image_decoder.h"
#include "drivers/camera/jpeg/jpeg_camera.h"
#include "recorder/format/file_io.h"
#include "recorder/format/writer.h"
#include "recorder/recorder.h"
#include "replay/session_source.h"
#include "schema/conversion.h"
#include "tests/support/samples.h"
#include "tests/support/temporary_folder.h"

namespace roseau::replay {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kWidth = 40;
constexpr std::uint32_t kHeight = 24;
constexpr std::uint32_t kFrames = 30;

struct Collector : SampleSink {
  bool receive(Sample sample) override {
    // Copies: the pool has fewer buffers than the session frames.
    if (const auto* frame = std::get_if<Frame>(&sample.payload)) {
      pixels.emplace_back(frame->bytes().begin(), frame->bytes().end());
      coded.emplace_back();
      if (frame->coded) coded.back().assign(frame->coded.bytes().begin(), frame->coded.bytes().end());
      formats.push_back(frame->format);
      if (out != nullptr) out->receive(std::move(sample));
    }
    return true;
  }
  std::vector<std::vector<std::byte>> pixels;
  std::vector<std::vector<std::byte>> coded;
  std::vector<PixelFormat> formats;
  SampleSink* out = nullptr;
};

class CodedSessions : public ::testing::Test {
 protected:
  /// What the camera gave is in `live`.
  std::string record(const std::string& name, ImageStorage storage, Collector& live) {
    StreamTable streams;
    const StreamId camera = streams.add({.topic = "/camera0/image", .kind = "frame", .device = "camera0"});
    const auto path = folder_.path() / name;
    recorder::Recorder recorder(streams,
                                {.wait_when_full = true, .reproducible = true, .image_storage = {{"camera0", storage}}});
    EXPECT_TRUE(recorder.open(path, {}));
    live.out = &recorder;
    camera::FrameCoder coder(85);
    camera::CodedBuffers buffers;
    camera::JpegSink jpeg(live, coder, buffers);
    SampleSink& entrance = storage == ImageStorage::jpeg ? static_cast<SampleSink&>(jpeg) : live;
    FramePool pool(kFrames, kWidth * 3 * kHeight);
    for (std::uint32_t i = 0; i < kFrames; ++i) {
      Sample sample{
          {.stream = camera, .sequence = i, .arrival_time = HostTime{1s + i * 10ms}, .sample_time = HostTime{1s + i * 10ms}},
          testing::filled_frame(pool, kWidth, kHeight, kWidth * 3)};
      std::get<Frame>(sample.payload).format = PixelFormat::bgr8;
      const auto pixels = std::get<Frame>(sample.payload).pixels.writable_bytes();
      for (std::size_t at = 0; at < pixels.size(); ++at) pixels[at] = static_cast<std::byte>(at / 7 + i * 3 + at % 3 * 20);
      entrance.receive(std::move(sample));
    }
    EXPECT_TRUE(recorder.close());
    return path.string();
  }
  static void replay(const std::string& path, SampleSink& sink, StreamTable& streams) {
    auto source =
        SessionSource::open_file(path, {.speed = std::numeric_limits<double>::infinity(), .now = [] { return HostTime{}; }});
    ASSERT_TRUE(source) << source.error().message;
    ASSERT_TRUE((*source)->open(streams));
    while (true) {
      const auto status = (*source)->read(sink, 10ms);
      ASSERT_TRUE(status) << status.error().message;
      if (*status == ReadStatus::finished) break;
    }
  }
  testing::TemporaryFolder folder_;
};

TEST_F(CodedSessions, GiveThePixelsThatWereSeenLive) {
  for (const ImageStorage storage : {ImageStorage::raw, ImageStorage::png, ImageStorage::jpeg}) {
    SCOPED_TRACE(to_string(storage));
    Collector live;
    const auto path = record(std::string(to_string(storage)) + ".mcap", storage, live);
    Collector replayed;
    StreamTable streams;
    replay(path, replayed, streams);
    ASSERT_EQ(replayed.pixels.size(), kFrames);
    EXPECT_TRUE(replayed.pixels == live.pixels);
    EXPECT_EQ(replayed.formats, live.formats);
    EXPECT_EQ(replayed.coded.front().empty(), storage == ImageStorage::raw);
  }
}

TEST_F(CodedSessions, RecordedAgainKeepTheirFilesByteForByte) {
  for (const ImageStorage storage : {ImageStorage::png, ImageStorage::jpeg}) {
    Collector live;
    const auto path = record(std::string(to_string(storage)) + ".mcap", storage, live);
    Collector first;
    StreamTable streams;
    const auto again = folder_.path() / (std::string(to_string(storage)) + "_again.mcap");
    recorder::Recorder recorder(streams, {.wait_when_full = true});
    ASSERT_TRUE(recorder.open(again, {}));
    first.out = &recorder;
    replay(path, first, streams);
    ASSERT_TRUE(recorder.close());
    Collector second;
    StreamTable others;
    replay(again.string(), second, others);
    EXPECT_EQ(second.coded.size(), kFrames);
    EXPECT_TRUE(second.coded == first.coded);
    EXPECT_TRUE(second.pixels == live.pixels);
  }
}

TEST_F(CodedSessions, OfOtherProgramsPlayAndABrokenPictureCostsOnlyItself) {
  Collector live;
  Collector original;
  StreamTable streams;
  replay(record("jpeg.mcap", ImageStorage::jpeg, live), original, streams);
  const auto path = folder_.path() / "other.mcap";
  {
    auto file = mcap::FileWritable::create(path);
    ASSERT_TRUE(file);
    mcap::Writer writer(**file);
    ASSERT_TRUE(writer.begin({"", "other"}));
    const auto schema = mcap::make_schema({.topic = "/cam", .kind = "frame", .metadata = {{"storage", "jpeg"}}}, 1);
    ASSERT_TRUE(writer.write(schema));
    ASSERT_TRUE(writer.write(mcap::Channel{.id = 1, .schema_id = 1, .topic = "/cam", .message_encoding = "protobuf"}));
    for (std::uint32_t i = 0; i < 3; ++i) {
      auto coded = original.coded.at(i);
      if (i == 1) coded.resize(coded.size() / 2);
      std::vector<std::byte> message;
      schema::serialize_compressed_image({.sample_time = HostTime{1s + i * 10ms}}, "cam", "jpeg", coded, message);
      mcap::Message record{
          .channel_id = 1, .sequence = i, .log_time_ns = 1'000'000'000 + i, .publish_time_ns = 1, .data = message};
      ASSERT_TRUE(writer.write(record));
    }
    ASSERT_TRUE(writer.finish());
    ASSERT_TRUE((*file)->close());
  }
  Collector replayed;
  StreamTable others;
  replay(path.string(), replayed, others);
  ASSERT_EQ(replayed.pixels.size(), 2U);
  EXPECT_TRUE(replayed.coded[0] == original.coded[0]);
  EXPECT_TRUE(replayed.coded[1] == original.coded[2]);
  EXPECT_EQ(others.info(0).metadata.at("storage"), "as_received");
}

}  // namespace
}  // namespace roseau::replay
