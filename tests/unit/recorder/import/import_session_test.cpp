#include "recorder/tools/import/import_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "core/wind_statistics.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/recorder.h"
#include "recorder/tools/import/record_times.h"
#include "schema/conversion.h"
#include "tests/support/data.h"
#include "tests/support/raw_avi.h"
#include "tests/support/temporary_folder.h"

namespace roseau::recorder {
namespace {

using roseau::testing::RawAvi;
using roseau::testing::TemporaryFolder;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pointwise;

// Keeps times and measurements, and gives pictures back at once.
struct Session : SampleSink {
  explicit Session(StreamTable& table) : streams(table) {}
  bool receive(Sample sample) override {
    EXPECT_GE(sample.header.arrival_time, last_arrival) << "samples come in the order of their times";
    last_arrival = sample.header.arrival_time;
    ++counts[streams.info(sample.header.stream).topic];
    if (auto* frame = std::get_if<Frame>(&sample.payload)) frame->pixels = {};
    samples.push_back(std::move(sample));
    return samples.size() < capacity;
  }
  std::vector<double> times_of(const std::string& topic) const {
    std::vector<double> times_s;
    for (const auto& sample : samples) {
      if (sample.header.stream == *streams.find(topic))
        times_s.push_back(to_seconds(sample.header.sample_time.time_since_epoch()));
    }
    return times_s;
  }

  StreamTable& streams;
  std::vector<Sample> samples;
  std::map<std::string, std::size_t> counts;
  HostTime last_arrival{Duration::min()};
  std::size_t capacity = 1'000'000;
};

std::string video_file(const TemporaryFolder& folder, std::uint32_t frames) {
  RawAvi avi{.announced_frames = frames};
  for (std::uint32_t i = 0; i < frames; ++i) avi.chunks.push_back(avi.plain(static_cast<char>(i), 0, 0));
  return folder.write("video.avi", avi.bytes());
}

ImportPlan::Sonic sonic_of(const std::string& path, double rate_hz) {
  ImportPlan::Sonic sonic;
  sonic.path = path;
  sonic.file.rate_hz = rate_hz;
  return sonic;
}

Error preparation_error(const ImportPlan& plan) {
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  return import ? Error{ErrorCode::io, "no error"} : import.error();
}

TEST(VideoArgument, IsTakenApart) {
  const auto full = parse_video_argument("/camera1/image=/data/tree.avi@15", 0);
  ASSERT_TRUE(full);
  EXPECT_EQ(full->topic, "/camera1/image");
  EXPECT_EQ(full->path, "/data/tree.avi");
  EXPECT_EQ(full->rate_hz, 15.0);
  EXPECT_EQ(parse_video_argument("left=a.avi", 0)->topic, "/left/image");
  EXPECT_EQ(parse_video_argument("a.avi", 1)->topic, "/camera1/image");
  EXPECT_FALSE(parse_video_argument("a.avi", 1)->rate_hz);
  EXPECT_EQ(parse_video_argument("/left=a.avi", 0)->topic, "/left/image");
  EXPECT_EQ(parse_video_argument("/data/run=3/a@home.avi", 0)->path, "/data/run=3/a@home.avi");
  EXPECT_EQ(parse_video_argument("camera0=/data/run=3/a.avi@29.97", 0)->rate_hz, 29.97);
  EXPECT_THAT(parse_video_argument("camera0=", 0).error().message, HasSubstr("should read TOPIC=FILE"));
  EXPECT_THAT(parse_video_argument("a.avi@0", 0).error().message, HasSubstr("make no sense"));
}

TEST(SessionImport, LaysEverythingOnOneAxis) {
  const TemporaryFolder folder;
  ImportPlan plan;
  plan.videos = {{.topic = "/camera0/image", .path = video_file(folder, 3), .start_offset = milliseconds{40}}};
  plan.sonics.push_back(sonic_of(folder.write("sonic.csv", "U,V,W\n1,2,3\n4,5,6\n"), 10.0));
  plan.sonics[0].model = "HS-50";
  plan.sonics[0].north_offset_deg = 235;
  plan.sonics[0].start_offset = milliseconds{-50};
  plan.displacements = {
      {.path = folder.write("T14 P1.txt", "0.5\n0.25\n"), .file = {.rate_hz = 4.0, .unit = LengthUnit::strain}}};
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import) << import.error().message;
  EXPECT_FALSE(import->utc_minus_host_time());
  Session session(streams);
  const auto report = import->run(session);
  ASSERT_TRUE(report) << report.error().message;

  EXPECT_THAT(session.times_of("/sonic/wind"), Pointwise(DoubleNear(1e-9), std::vector<double>{1.0, 1.1}));
  EXPECT_THAT(session.times_of("/camera0/image"), Pointwise(DoubleNear(1e-9), std::vector<double>{1.09, 1.19, 1.29}));
  EXPECT_THAT(session.times_of("/displacement/T14_P1"), Pointwise(DoubleNear(1e-9), std::vector<double>{1.05, 1.3}));
  for (const char* topic : {"/sonic/wind", "/camera0/image", "/displacement/T14_P1"}) {
    EXPECT_EQ(streams.info(*streams.find(topic)).role, StreamRole::raw) << topic;
  }
  const auto& wind = streams.info(*streams.find("/sonic/wind"));
  EXPECT_EQ(wind.device, "sonic");
  EXPECT_EQ(wind.metadata.at("north_offset_deg"), "235");
  EXPECT_EQ(wind.metadata.at("axes"), "gill_spar");
  EXPECT_EQ(wind.metadata.at("model"), "HS-50");
  EXPECT_EQ(streams.info(*streams.find("/displacement/T14_P1")).metadata.at("unit"), "strain");

  ASSERT_EQ(report->streams.size(), 3U);
  EXPECT_EQ(report->streams[0].samples, 3U);
  EXPECT_NEAR(report->streams[1].begin_s, 0, 1e-9);
  EXPECT_NEAR(report->duration_s, 0.3, 1e-9);
}

TEST(SessionImport, FilesWithTimeStampsFindTheirPlaces) {
  const TemporaryFolder folder;
  ImportPlan plan;
  plan.sonics = {{.path = folder.write("sonic.csv", "time,U,V\n2019-07-30 12:00:02,1,2\n2019-07-30 12:00:03,1,2\n")}};
  plan.displacements = {{.path = folder.write("sway.csv", "time,x\n2019-07-30 12:00:00.5,1\n2019-07-30 12:00:01.5,2\n")}};
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import) << import.error().message;
  Session session(streams);
  ASSERT_TRUE(import->run(session));
  EXPECT_THAT(session.times_of("/displacement/sway"), Pointwise(DoubleNear(1e-9), std::vector<double>{1.0, 2.0}));
  EXPECT_THAT(session.times_of("/sonic/wind"), Pointwise(DoubleNear(1e-9), std::vector<double>{2.5, 3.5}));
  ASSERT_TRUE(import->utc_minus_host_time());
  EXPECT_EQ(format_time_stamp(*import->utc_minus_host_time() + seconds{1}), "2019-07-30T12:00:00.500");
}

TEST(SessionImport, MissingValuesAreIncompleteSamples) {
  const TemporaryFolder folder;
  ImportPlan plan;
  plan.sonics = {{.path = folder.write("sonic.csv", "U,V\n1,2\n-9999,2\n"), .file = {.rate_hz = 10.0}}};
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import);
  Session session(streams);
  const auto report = import->run(session);
  ASSERT_TRUE(report);
  EXPECT_EQ(session.samples.at(0).header.status, kStatusOk);
  EXPECT_EQ(session.samples.at(1).header.status, kStatusIncomplete);
  EXPECT_EQ(report->streams.at(0).invalid_samples, 1U);
}

TEST(SessionImport, SaysWhatIsWrongBeforeAnythingIsWritten) {
  const TemporaryFolder folder;
  const auto csv = folder.write("sonic.csv", "U,W\n1,2\n");
  EXPECT_THAT(preparation_error({}).message, HasSubstr("nothing to import"));
  EXPECT_THAT(preparation_error({.sonics = {{.path = csv, .file = {.rate_hz = 10.0}}}}).message,
              ::testing::AllOf(HasSubstr(csv), HasSubstr("no column for v")));
  EXPECT_EQ(preparation_error({.sonics = {{.path = "/does/not/exist.csv"}}}).code, ErrorCode::not_found);
  EXPECT_EQ(preparation_error({.videos = {{.topic = "/camera0/image", .path = "/does/not/exist.avi"}}}).code,
            ErrorCode::not_found);
  EXPECT_THAT(preparation_error({.displacements = {{.path = folder.path().string()}}}).message, HasSubstr("is a folder"));
  const auto series = folder.write("sway.txt", "1\n2\n");
  const ImportPlan::DisplacementSeries one{.path = series, .file = {.rate_hz = 4.0}};
  EXPECT_THAT(preparation_error({.displacements = {one, one}}).message,
              HasSubstr("topic /displacement/sway is given to two files"));
}

TEST(SessionImport, StopsWhenAsked) {
  const TemporaryFolder folder;
  ImportPlan plan;
  plan.displacements = {{.path = folder.write("sway.txt", "1\n2\n3\n"), .file = {.rate_hz = 4.0}}};
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import);
  Session session(streams);
  std::stop_source stop;
  stop.request_stop();
  const auto report = import->run(session, stop.get_token());
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->was_stopped);
  EXPECT_EQ(report->streams.at(0).samples, 1U);
}

TEST(SessionImport, ASessionThatTakesNoMoreIsAnError) {
  const TemporaryFolder folder;
  ImportPlan plan;
  plan.displacements = {{.path = folder.write("sway.txt", "1\n2\n3\n"), .file = {.rate_hz = 4.0}}};
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import);
  Session session(streams);
  session.capacity = 2;
  EXPECT_FALSE(import->run(session));
}

TEST(SessionImport, TellsHowFarItIs) {
  const TemporaryFolder folder;
  ImportPlan plan;
  plan.displacements = {{.path = folder.write("sway.txt", "1\n2\n3\n4\n"), .file = {.rate_hz = 4.0}}};
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import);
  Session session(streams);
  std::vector<double> fractions;
  ASSERT_TRUE(import->run(session, {}, [&](double fraction) { fractions.push_back(fraction); }));
  EXPECT_THAT(fractions, ElementsAre(0.25, 0.5, 0.75, 1.0));
}

TEST(SessionImport, RealVideosAndHohesHolz) {
  ROSEAU_REQUIRE_DATA(tree, "data/video_tree_opencv/tree.avi");
  ROSEAU_REQUIRE_DATA(plants, "data/video_plants/plants.avi");
  ROSEAU_REQUIRE_DATA(wind, "data/sonic_dehoh_rflux/DE-HoH_EC_201907301200_v01.csv");
  ImportPlan plan;
  plan.videos = {{.topic = "/camera0/image", .path = tree.string()},
                 {.topic = "/camera1/image", .path = plants.string(), .format = PixelFormat::mono8}};
  plan.sonics = {{.path = wind.string(), .file = {.rate_hz = 20.0}, .north_offset_deg = 235}};
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import) << import.error().message;
  Session session(streams);
  const auto report = import->run(session);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(session.counts.at("/camera0/image"), 68U);
  EXPECT_EQ(session.counts.at("/camera1/image"), 150U);
  EXPECT_EQ(session.counts.at("/sonic/wind"), 36'000U);
  EXPECT_THAT(report->streams.at(0).remarks, ElementsAre(HasSubstr("announces 444 frames and holds 68 pictures")));
  EXPECT_NEAR(report->duration_s, 1799.95, 1e-6);
  WindStatistics statistics;
  for (const auto& sample : session.samples) {
    if (const auto* one = std::get_if<WindSample>(&sample.payload)) statistics.add(*one);
  }
  EXPECT_NEAR(statistics.unit_vector_mean_direction_deg(235), 292.276, 0.0005);
}

TEST(SessionImport, EveryPullAndReleaseTest) {
  ROSEAU_REQUIRE_DATA(folder, "data/tree_pull_release");
  ImportPlan plan;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const auto name = entry.path().filename().string();
    if (name.starts_with("T14_") || name.starts_with("T16_")) {
      plan.displacements.push_back({.path = entry.path().string(), .file = {.rate_hz = 4.0, .unit = LengthUnit::strain}});
    }
  }
  ASSERT_EQ(plan.displacements.size(), 12U);
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import) << import.error().message;
  Session session(streams);
  ASSERT_TRUE(import->run(session));
  EXPECT_EQ(session.counts.at("/displacement/T14_P3_winter"), 601U);
  EXPECT_EQ(session.samples.size(), 201U + 501 + 261 + 401 + 201 + 601 + 411 + 181 + 206 + 101 + 401 + 101);
}

// Through the recorder and back: what is in the file is what was in the files.
TEST(SessionImport, BecomesASessionFile) {
  const TemporaryFolder folder;
  ImportPlan plan;
  plan.videos.push_back({.topic = "/camera0/image", .path = video_file(folder, 200)});
  plan.sonics.push_back(sonic_of(folder.write("sonic.csv", "U,V,W\n1.5,-2,3\n4,5,6\n"), 10.0));
  StreamTable streams;
  auto import = SessionImport::prepare(plan, streams);
  ASSERT_TRUE(import) << import.error().message;
  const auto path = folder.path() / "session.mcap";
  Recorder recorder(streams, {.wait_when_full = true});
  ASSERT_TRUE(recorder.open(path, {.program_version = "test"}));
  ASSERT_TRUE(import->run(recorder));
  const auto closed = recorder.close();
  ASSERT_TRUE(closed) << closed.error().message;

  const auto reader = mcap::IndexedReader::open(path);
  ASSERT_TRUE(reader) << reader.error().message;
  std::map<std::string, std::size_t> counts;
  std::vector<double> u_mps;
  auto messages = (*reader)->messages();
  for (auto next = messages.next(); next && *next; next = messages.next()) {
    const auto& [channel, message] = **next;
    ++counts[channel->topic];
    if (channel->topic == "/camera0/image") {
      const auto frame = schema::parse_frame(message.data, {});
      ASSERT_TRUE(frame);
      ASSERT_EQ(std::to_integer<std::size_t>(frame->pixels[0]), frame->header.sequence)
          << "each picture has its own number for colour";
    } else {
      const auto sample = schema::parse(SampleKind::wind, message.data, {}, streams);
      ASSERT_TRUE(sample);
      u_mps.push_back(std::get<WindSample>(sample->payload).u_mps);
    }
  }
  EXPECT_EQ(counts.at("/camera0/image"), 200U);
  EXPECT_THAT(u_mps, ElementsAre(1.5, 4));
}

}  // namespace
}  // namespace roseau::recorder
