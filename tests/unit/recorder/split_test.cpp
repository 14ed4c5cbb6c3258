// Recordings that are split into parts: every sample is in exactly one, each part is a whole session, and the counters add up.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <thread>

#include "recorder/format/indexed_reader.h"
#include "recorder/recorder.h"
#include "recorder/tools/inspect/verification.h"
#include "schema/conversion.h"
#include "tests/support/samples.h"
#include "tests/support/temporary_folder.h"

namespace roseau::recorder {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const SessionDescription kDescription{"0.1.0", "[run]\nrate_hz = 20\n", "[site]\nname = 'Inra'\n", Duration{1'000}, {}};

/// What one file says of itself and holds.
struct ReadPart {
  mcap::SessionInfo info;
  std::map<std::string, std::vector<std::uint32_t>> sequences;  // by topic, in order of log time
  std::vector<std::uint64_t> log_times_ns;                      // of all messages, in that order
  mcap::TopicCounters counters;
  mcap::TopicCounters session_counters;
  std::vector<std::string> attachments;
};

class SplitTest : public ::testing::Test {
 protected:
  std::unique_ptr<Recorder> make_recorder(RecorderOptions options) {
    options.part_finished = [this](const FinishedPart& part) {
      const std::scoped_lock lock(mutex);
      finished.push_back(part);
    };
    return std::make_unique<Recorder>(streams, options);
  }
  StreamId add_stream(const std::string& topic, SampleKind kind) {
    return streams.add({.topic = topic, .kind = std::string(to_string(kind)), .device = "test"});
  }
  Sample bytes_sample(StreamId stream, std::uint32_t sequence) const {
    return {{.stream = stream, .sequence = sequence, .arrival_time = time(sequence), .sample_time = time(sequence)},
            testing::raw_bytes_of("record " + std::to_string(sequence))};
  }
  static HostTime time(std::uint32_t sequence) { return host_time_from_ns(1'000'000'000 + std::int64_t{sequence} * 1'000'000); }
  static ReadPart read(const std::filesystem::path& path) {
    ReadPart part;
    auto opened = mcap::IndexedReader::open(path);
    EXPECT_TRUE(opened) << (opened ? "" : opened.error().message);
    mcap::IndexedReader& reader = **opened;
    EXPECT_TRUE(reader.index().complete) << path;
    part.info = *mcap::session_info_from(reader.find_metadata(mcap::kSessionMetadata)->value());
    const auto counters = reader.find_metadata(mcap::kCountersMetadata)->value();
    part.counters = *mcap::counters_from(counters);
    part.session_counters = *mcap::session_counters_from(counters);
    for (const auto& attachment : reader.index().attachments) part.attachments.push_back(attachment.name);
    auto cursor = reader.messages();
    while (const auto message = *cursor.next()) {
      part.sequences[message->channel->topic].push_back(message->message.sequence);
      part.log_times_ns.push_back(message->message.log_time_ns);
    }
    const auto verification = verify_session(path);
    EXPECT_TRUE(verification) << path;
    if (verification) {
      EXPECT_THAT(verification->problems, ElementsAre()) << path;
    }
    return part;
  }
  std::vector<ReadPart> read_finished() const {
    std::vector<ReadPart> parts;
    for (const FinishedPart& part : finished) {
      EXPECT_EQ(part.problem, "");
      EXPECT_EQ(part.bytes, std::filesystem::file_size(part.path));
      parts.push_back(read(part.path));
    }
    return parts;
  }
  static std::vector<std::uint32_t> all_of(const std::vector<ReadPart>& parts, const std::string& topic) {
    std::vector<std::uint32_t> sequences;
    for (const ReadPart& part : parts) {
      const auto found = part.sequences.find(topic);
      if (found != part.sequences.end()) sequences.insert(sequences.end(), found->second.begin(), found->second.end());
    }
    return sequences;
  }
  static std::vector<std::uint32_t> numbers(std::uint32_t count) {
    std::vector<std::uint32_t> numbers(count);
    for (std::uint32_t i = 0; i < count; ++i) numbers[i] = i;
    return numbers;
  }
  static void wait_until(const std::function<bool()>& condition) {
    for (int i = 0; i < 10'000; ++i) {
      if (condition()) return;
      std::this_thread::sleep_for(1ms);
    }
    FAIL() << "waited in vain";
  }
  /// The sums over all files are what the recorder counted, and what the last file says of the whole session.
  static void expect_counters_add_up(const std::vector<ReadPart>& parts, const RecorderState& state) {
    for (const auto& [topic, total] : state.streams) {
      StreamCounters sum;
      for (const ReadPart& part : parts) {
        const auto found = part.counters.find(topic);
        if (found == part.counters.end()) continue;
        sum.received += found->second.received;
        sum.recorded += found->second.recorded - found->second.repeated;
        sum.dropped += found->second.dropped;
        sum.dropped_queue += found->second.dropped_queue;
        EXPECT_EQ(found->second.received, found->second.recorded - found->second.repeated + found->second.dropped) << topic;
      }
      EXPECT_EQ(sum.received, total.received) << topic;
      EXPECT_EQ(sum.recorded, total.recorded) << topic;
      EXPECT_EQ(sum.dropped, total.dropped) << topic;
      EXPECT_EQ(sum.dropped_queue, total.dropped_queue) << topic;
      const auto& session = parts.back().session_counters;
      ASSERT_TRUE(session.contains(topic)) << topic;
      EXPECT_EQ(session.at(topic).received, total.received) << topic;
      EXPECT_EQ(session.at(topic).recorded, total.recorded) << topic;
      EXPECT_EQ(session.at(topic).dropped, total.dropped) << topic;
    }
  }

  testing::TemporaryFolder folder;
  std::mutex mutex;
  std::vector<FinishedPart> finished;
  StreamTable streams;
  FramePool pool{8, 100'000};
};

TEST_F(SplitTest, BySizeEverySampleIsInExactlyOnePartAndNoPartIsLarger) {
  constexpr std::uint64_t kMostBytes = 600'000;
  constexpr std::uint32_t kRounds = 60;
  const StreamId camera = add_stream("/camera0/image", SampleKind::frame);
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  auto recorder = make_recorder({.wait_when_full = true, .chunk_bytes = 200'000, .split = {.bytes = kMostBytes}});
  ASSERT_TRUE(recorder->open(folder.path() / "a.mcap", kDescription));
  for (std::uint32_t i = 0; i < kRounds; ++i) {
    Frame frame;
    while (!frame.pixels) frame.pixels = pool.acquire();
    frame.width = frame.height = frame.stride = 300;
    recorder->record({{.stream = camera, .sequence = i, .arrival_time = time(i), .sample_time = time(i)}, frame}, time(i));
    recorder->record(bytes_sample(sonic, i), time(i));
  }
  ASSERT_TRUE(recorder->close());

  const auto state = recorder->state();
  const auto parts = read_finished();
  ASSERT_GE(parts.size(), kRounds * 90'000 / kMostBytes);
  EXPECT_EQ(all_of(parts, "/camera0/image"), numbers(kRounds));
  EXPECT_EQ(all_of(parts, "/sonic/raw"), numbers(kRounds));
  expect_counters_add_up(parts, state);
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_LE(finished[i].bytes, kMostBytes);
    if (i + 1 < parts.size()) {
      EXPECT_GE(finished[i].bytes, kMostBytes - 2 * 90'000) << "no smaller than need be";
    }
    EXPECT_EQ(finished[i].part, i + 1);
    EXPECT_EQ(finished[i].last, i + 1 == parts.size());
    EXPECT_EQ(finished[i].session_id, state.session_id);
    EXPECT_EQ(parts[i].info.part, i + 1);
    EXPECT_EQ(parts[i].info.session_id, state.session_id);
    EXPECT_EQ(parts[i].info.utc_minus_host_time, Duration{1'000});
    EXPECT_THAT(parts[i].attachments, ElementsAre("config.toml", "site.toml"));
    bytes += finished[i].bytes;
  }
  EXPECT_EQ(finished[0].path, folder.path() / "a.mcap");
  EXPECT_EQ(finished[1].path, folder.path() / "a.part002.mcap");
  EXPECT_EQ(state.part, parts.size());
  EXPECT_EQ(state.session_bytes, bytes);
  EXPECT_EQ(state.bytes, finished.back().bytes);
  EXPECT_EQ(state.parts_finishing, 0U);
  EXPECT_EQ(state.state, DeviceState::finished);
}

TEST_F(SplitTest, ByLogTimeToTheSample) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  auto recorder = make_recorder({.wait_when_full = true, .split = {.time = 100ms}});
  ASSERT_TRUE(recorder->open(folder.path() / "a.mcap", kDescription));
  for (std::uint32_t i = 0; i < 250; ++i) recorder->record(bytes_sample(sonic, i), time(i));  // one each millisecond
  ASSERT_TRUE(recorder->close());
  const auto parts = read_finished();
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[0].sequences.at("/sonic/raw"), numbers(100));
  EXPECT_EQ(parts[1].sequences.at("/sonic/raw").front(), 100U);
  EXPECT_EQ(parts[1].sequences.at("/sonic/raw").size(), 100U);
  EXPECT_EQ(all_of(parts, "/sonic/raw"), numbers(250));
  EXPECT_DOUBLE_EQ(finished[1].seconds, 0.099);
  EXPECT_DOUBLE_EQ(recorder->state().seconds, 0.249);
  expect_counters_add_up(parts, recorder->state());
}

TEST_F(SplitTest, WhenAskedForBetweenTheSamplesBeforeAndAfter) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  auto recorder = make_recorder({});
  EXPECT_EQ(recorder->split_now().error().code, ErrorCode::invalid_argument);
  ASSERT_TRUE(recorder->open(folder.path() / "a.mcap", kDescription));
  EXPECT_TRUE(recorder->split_now());  // nothing yet: the first part stays the first
  for (std::uint32_t i = 0; i < 30; ++i) {
    if (i == 7 || i == 19) {
      EXPECT_TRUE(recorder->split_now());
    }
    recorder->record(bytes_sample(sonic, i), time(i));
  }
  EXPECT_TRUE(recorder->split_now());  // nothing after: no empty part
  ASSERT_TRUE(recorder->close());
  EXPECT_EQ(recorder->split_now().error().code, ErrorCode::invalid_argument);
  const auto parts = read_finished();
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[0].sequences.at("/sonic/raw").size(), 7U);
  EXPECT_EQ(parts[1].sequences.at("/sonic/raw").size(), 12U);
  EXPECT_EQ(parts[2].sequences.at("/sonic/raw").size(), 11U);
  EXPECT_EQ(all_of(parts, "/sonic/raw"), numbers(30));
}

TEST_F(SplitTest, EachPartKnowsTheCamerasAndTheTargets) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  const StreamId calibrations = add_stream("/camera0/calibration", SampleKind::camera_calibration);
  const StreamId actions = add_stream("/operator", SampleKind::operator_action);
  auto recorder = make_recorder({.split = {.time = 10ms}});
  ASSERT_TRUE(recorder->open(folder.path() / "a.mcap", kDescription));
  const auto record = [&](StreamId stream, std::uint32_t at, Payload payload) {
    recorder->record({{.stream = stream, .sequence = at, .arrival_time = time(at), .sample_time = time(at)}, payload},
                     time(at));
  };
  record(calibrations, 0, CameraCalibration{.fx_px = 1});
  record(calibrations, 1, CameraCalibration{.fx_px = 2});
  record(actions, 2, OperatorAction{OperatorAction::Kind::add_target, "branch", "camera0", {1, 2, 3, 4}});
  record(actions, 3, OperatorAction{OperatorAction::Kind::add_target, "trunk", "camera0", {1, 2, 3, 4}});
  record(actions, 4, OperatorAction{OperatorAction::Kind::remove_target, "trunk", "camera0", {}});
  record(actions, 5, OperatorAction{OperatorAction::Kind::mark, "gust", "", {}});
  for (std::uint32_t i = 10; i < 30; ++i) record(sonic, i, testing::raw_bytes_of("x"));
  ASSERT_TRUE(recorder->close());

  const auto parts = read_finished();
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[0].info.repeated_messages, 0U);
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_EQ(parts[i].info.repeated_messages, 2U);
    EXPECT_THAT(parts[i].sequences.at("/camera0/calibration"), ElementsAre(1));  // the latest
    EXPECT_THAT(parts[i].sequences.at("/operator"), ElementsAre(2));             // the target that is still there
    EXPECT_EQ(parts[i].counters.at("/operator").recorded, 1U);
    EXPECT_EQ(parts[i].counters.at("/operator").repeated, 1U);
    EXPECT_EQ(parts[i].counters.at("/operator").received, 0U);
    // Just before the part's own first sample, so that a replay of this part does not begin with a wait.
    EXPECT_EQ(parts[i].log_times_ns[0], parts[i].log_times_ns[2] - 2);
    EXPECT_EQ(parts[i].log_times_ns[1], parts[i].log_times_ns[2] - 1);
  }
  expect_counters_add_up(parts, recorder->state());
  EXPECT_EQ(recorder->state().streams.at("/camera0/calibration").recorded, 2U);
}

TEST_F(SplitTest, WhereTheNextFileCannotBeMadeRecordingGoesOnAndSaysSo) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  const auto later = folder.path() / "later";  // not there yet
  RecorderOptions options{.sync_interval = 1ms, .split = {.time = 10ms}};
  options.part_path = [&](const std::filesystem::path&, std::uint32_t part) { return later / std::to_string(part); };
  auto recorder = make_recorder(options);
  ASSERT_TRUE(recorder->open(folder.path() / "a.mcap", kDescription));
  std::uint32_t sent = 0;
  for (; sent < 20; ++sent) recorder->record(bytes_sample(sonic, sent), time(sent));
  wait_until([&] { return !recorder->state().split_problem.empty(); });
  auto state = recorder->state();
  EXPECT_EQ(state.state, DeviceState::degraded);
  EXPECT_THAT(state.message, HasSubstr("goes on in " + (folder.path() / "a.mcap").string()));
  EXPECT_EQ(state.message, state.split_problem);
  EXPECT_EQ(state.part, 1U);
  std::filesystem::create_directory(later);
  wait_until([&] {
    recorder->record(bytes_sample(sonic, sent), time(sent));
    ++sent;
    return recorder->state().part == 2;
  });
  state = recorder->state();
  EXPECT_EQ(state.state, DeviceState::running);
  EXPECT_EQ(state.split_problem, "");
  std::filesystem::remove_all(folder.path() / "never");
  ASSERT_TRUE(recorder->close()) << "nothing was lost";
  const auto parts = read_finished();
  ASSERT_GE(parts.size(), 2U);
  EXPECT_EQ(all_of(parts, "/sonic/raw"), numbers(sent));
}

TEST_F(SplitTest, FinishingAPartHoldsUpNoSample) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  RecorderOptions options{.chunk_time = 2ms, .split = {.time = 10ms}};
  std::mutex hold;
  hold.lock();
  std::vector<std::uint32_t> seen;
  options.part_finished = [&](const FinishedPart& part) {
    const std::scoped_lock held(hold);  // a slow copy to another disk
    seen.push_back(part.part);
  };
  Recorder recorder(streams, options);
  ASSERT_TRUE(recorder.open(folder.path() / "a.mcap", kDescription));
  for (std::uint32_t i = 0; i < 100; ++i) recorder.record(bytes_sample(sonic, i), time(i));
  wait_until([&] { return recorder.state().part == 10 && recorder.state().parts_finishing == 9; });
  hold.unlock();
  ASSERT_TRUE(recorder.close());
  EXPECT_THAT(seen, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  EXPECT_EQ(recorder.state().streams.at("/sonic/raw").recorded, 100U);
}

TEST_F(SplitTest, ASessionThatWasInterruptedGoesOn) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  SessionDescription description = kDescription;
  description.session_id = "0a1b";
  description.first_part = 4;
  auto recorder = make_recorder({});
  ASSERT_TRUE(recorder->open(folder.path() / "a.mcap", description));
  recorder->record(bytes_sample(sonic, 0), time(0));
  ASSERT_TRUE(recorder->split_now());
  recorder->record(bytes_sample(sonic, 1), time(1));
  ASSERT_TRUE(recorder->close());
  const auto parts = read_finished();
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].info.session_id, "0a1b");
  EXPECT_EQ(parts[0].info.part, 4U);
  EXPECT_EQ(parts[1].info.part, 5U);
  EXPECT_EQ(finished[1].path, folder.path() / "a.part005.mcap");
}

TEST_F(SplitTest, TheSameSamplesGiveTheSamePartsWhereThatIsAskedFor) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  const auto contents = [](const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  for (const char* name : {"a.mcap", "b.mcap"}) {
    auto recorder = make_recorder({.wait_when_full = true, .reproducible = true, .split = {.bytes = 30'000}});
    ASSERT_TRUE(recorder->open(folder.path() / name, kDescription));
    for (std::uint32_t i = 0; i < 1'000; ++i) recorder->record(bytes_sample(sonic, i), time(i));
    ASSERT_TRUE(recorder->close());
  }
  ASSERT_GE(finished.size(), 4U);
  ASSERT_EQ(finished.size() % 2, 0U);
  for (std::size_t i = 0; i < finished.size() / 2; ++i) {
    EXPECT_EQ(contents(finished[i].path), contents(finished[i + finished.size() / 2].path));
  }
}

}  // namespace
}  // namespace roseau::recorder
