#include "recorder/recorder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <condition_variable>
#include <csignal>
#include <fstream>
#include <mutex>
#include <thread>

#include "recorder/format/codec.h"
#include "recorder/format/file_io.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/format/record_reader.h"
#include "recorder/format/stream_reader.h"
#include "schema/conversion.h"
#include "tests/support/memory_file.h"
#include "tests/support/samples.h"

namespace roseau::recorder {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

const SessionDescription kDescription{
    "0.1.0", "[run]\nrate_hz = 20\n", "[site]\nname = 'Inra'\n", Duration{1'000}, {{"operator", "J"}}};

/// Memory that outlives the recorder, and can be told to hold writes back or to be full.
struct Disk {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::byte> bytes;
  std::vector<const std::byte*> parts;  // where what was written lay in memory
  bool stuck = false;
  std::size_t capacity = std::numeric_limits<std::size_t>::max();
  std::size_t reserve = 0;  // usable for closing only
  bool closing = false;

  void set_stuck(bool value) {
    const std::scoped_lock lock(mutex);
    stuck = value;
    changed.notify_all();
  }
  std::vector<std::byte> contents() {
    const std::scoped_lock lock(mutex);
    return bytes;
  }
};

class DiskWritable : public mcap::Writable {
 public:
  explicit DiskWritable(Disk& disk) : disk_(disk) {}
  Result<void> append(std::span<const std::span<const std::byte>> parts) override {
    std::unique_lock lock(disk_.mutex);
    disk_.changed.wait(lock, [this] { return !disk_.stuck; });
    std::size_t size = 0;
    for (const auto& part : parts) size += part.size();
    if (disk_.bytes.size() + size > disk_.capacity + (disk_.closing ? disk_.reserve : 0)) {
      return Error{ErrorCode::no_space, "cannot write session.mcap: No space left on device: free some space"};
    }
    for (const auto& part : parts) {
      disk_.parts.push_back(part.data());
      disk_.bytes.insert(disk_.bytes.end(), part.begin(), part.end());
    }
    return {};
  }
  Result<void> sync() override { return {}; }
  void begin_closing() override {
    const std::scoped_lock lock(disk_.mutex);
    disk_.closing = true;
  }

 private:
  Disk& disk_;
};

class RecorderTest : public ::testing::Test {
 protected:
  Result<void> open(Recorder& recorder) {
    return recorder.open(std::make_unique<DiskWritable>(disk), "session.mcap", kDescription);
  }
  std::unique_ptr<mcap::IndexedReader> read() { return read(disk.contents()); }
  static std::unique_ptr<mcap::IndexedReader> read(std::vector<std::byte> bytes) {
    auto reader = mcap::IndexedReader::open(std::make_unique<testing::MemoryReadable>(std::move(bytes)));
    EXPECT_TRUE(reader) << (reader ? "" : reader.error().message);
    return std::move(*reader);
  }
  StreamId add_stream(const std::string& topic, SampleKind kind) {
    return streams.add({.topic = topic, .kind = std::string(to_string(kind)), .device = "test"});
  }
  Sample bytes_sample(StreamId stream, std::uint32_t sequence) const {
    return {{.stream = stream, .sequence = sequence, .arrival_time = time(sequence), .sample_time = time(sequence)},
            testing::raw_bytes_of("record " + std::to_string(sequence))};
  }
  static HostTime time(std::uint32_t sequence) { return host_time_from_ns(1'000'000'000 + std::int64_t{sequence} * 1'000'000); }
  /// Until `condition`, which is certain to come; gives up loudly.
  static void wait_until(const std::function<bool()>& condition) {
    for (int i = 0; i < 10'000; ++i) {
      if (condition()) return;
      std::this_thread::sleep_for(1ms);
    }
    FAIL() << "waited in vain";
  }
  static std::uint64_t count(mcap::IndexedReader& reader, const std::string& topic) {
    const auto* channel = reader.channel_of_topic(topic);
    return channel == nullptr ? 0 : reader.index().statistics.channel_message_counts.at(channel->id);
  }

  Disk disk;
  StreamTable streams;
  FramePool pool{16, 100'000};
};

TEST_F(RecorderTest, EveryKindOfSampleComesBackBitForBit) {
  Recorder recorder(streams);
  ASSERT_TRUE(open(recorder));
  std::map<std::string, std::vector<std::byte>> expected;
  for (std::size_t i = 0; i < kSampleKindCount; ++i) {
    const Sample sample = testing::filled_sample(static_cast<SampleKind>(i), streams, pool);
    EXPECT_TRUE(recorder.record(sample, host_time_from_ns(1'000 + static_cast<std::int64_t>(i))));
    schema::serialize(sample, streams, expected[streams.info(sample.header.stream).topic]);
  }
  ASSERT_TRUE(recorder.close());
  EXPECT_EQ(recorder.state().state, DeviceState::finished);

  const auto reader = read();
  EXPECT_TRUE(reader->index().complete);
  auto cursor = reader->messages();
  std::uint64_t expected_log_time_ns = 1'000;
  while (const auto message = *cursor.next()) {
    const auto& channel = *message->channel;
    EXPECT_EQ(message->message.log_time_ns, expected_log_time_ns++);
    EXPECT_EQ(message->message.publish_time_ns, 123'456'700'000'001U);
    EXPECT_EQ(message->message.sequence, 4'000'000'000U);
    const auto info = mcap::stream_info_from(channel, reader->catalog().schema_of(channel));
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->device, "camera0");
    const auto kind = sample_kind_from_string(info->kind);
    ASSERT_TRUE(kind);
    const auto sample = schema::parse(*kind, message->message.data, {.stream = *streams.find(channel.topic)}, streams, &pool);
    ASSERT_TRUE(sample) << sample.error().message;
    std::vector<std::byte> again;
    schema::serialize(*sample, streams, again);
    EXPECT_EQ(again, expected.at(channel.topic)) << channel.topic;
    expected.erase(channel.topic);
  }
  EXPECT_TRUE(expected.empty());
}

TEST_F(RecorderTest, TheHeadSaysWhoAndHow) {
  Recorder recorder(streams);
  ASSERT_TRUE(open(recorder));
  const auto head = disk.contents();  // already there: a session that is killed at once still says it
  ASSERT_TRUE(recorder.close());
  const auto reader = read(head);
  EXPECT_EQ(reader->index().header.library, "roseau 0.1.0");
  const auto info = mcap::session_info_from(reader->find_metadata(mcap::kSessionMetadata)->value());
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->schema_version, schema::kSchemaVersion);
  EXPECT_EQ(info->program_version, "0.1.0");
  EXPECT_EQ(info->utc_minus_host_time, Duration{1'000});
  EXPECT_EQ(info->other.at("operator"), "J");
  ASSERT_EQ(reader->index().attachments.size(), 2U);
  std::vector<std::byte> buffer;
  const auto text_of = [&](std::size_t i) {
    const auto attachment = *reader->read(reader->index().attachments[i], buffer);
    return attachment.name + ": " + std::string(reinterpret_cast<const char*>(attachment.data.data()), attachment.data.size());
  };
  EXPECT_EQ(text_of(0), "config.toml: " + kDescription.config_text);
  EXPECT_EQ(text_of(1), "site.toml: " + kDescription.site_text);
}

TEST_F(RecorderTest, PicturesAreWrittenFromTheirOwnBufferIntoChunksOfTheirOwn) {
  const StreamId camera = add_stream("/camera0/image", SampleKind::frame);
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  Recorder recorder(streams);
  ASSERT_TRUE(open(recorder));
  std::vector<const std::byte*> buffers;
  for (std::uint32_t i = 0; i < 5; ++i) {
    Sample frame{{.stream = camera, .sequence = i}, testing::filled_frame(pool, 300, 300, 300)};
    buffers.push_back(std::get<Frame>(frame.payload).bytes().data());
    recorder.record(frame, time(2 * i));
    for (std::uint32_t k = 0; k < 40; ++k) recorder.record(bytes_sample(sonic, i), time(2 * i + 1));
  }
  ASSERT_TRUE(recorder.close());
  EXPECT_EQ(pool.free_count(), 16U);
  for (const std::byte* buffer : buffers) EXPECT_EQ(std::ranges::count(disk.parts, buffer), 1);

  testing::MemoryReadable file(disk.contents());
  mcap::RecordReader records(file, mcap::kMagic.size(), file.size());
  std::map<std::string, int> chunks_by_compression;
  while (const auto place = *records.next()) {
    if (place->opcode == static_cast<std::uint8_t>(mcap::Opcode::footer)) break;
    if (place->opcode != static_cast<std::uint8_t>(mcap::Opcode::chunk)) continue;
    ++chunks_by_compression[std::get<mcap::Chunk>(*records.decode(*place)).compression];
  }
  EXPECT_GE(chunks_by_compression[""], 1);
  EXPECT_GE(chunks_by_compression["zstd"], 1);
  const auto reader = read();
  for (const auto& block : reader->index().blocks) EXPECT_EQ(block.channels->size(), 1U);
  EXPECT_EQ(count(*reader, "/camera0/image"), 5U);
  EXPECT_EQ(count(*reader, "/sonic/raw"), 200U);
}

TEST_F(RecorderTest, ChunksAreSlicesOfTime) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  Recorder recorder(streams, {.chunk_time = 100ms});
  ASSERT_TRUE(open(recorder));
  for (std::uint32_t i = 0; i < 1000; ++i) recorder.record(bytes_sample(sonic, i), time(i));  // one second
  ASSERT_TRUE(recorder.close());
  const auto reader = read();
  EXPECT_GE(reader->index().blocks.size(), 10U);
  for (const auto& block : reader->index().blocks) EXPECT_LE(block.end_time_ns - block.start_time_ns, 100'000'000U);
}

TEST_F(RecorderTest, ASlowDiskDropsAndCountsAndSaysSo) {
  const StreamId camera = add_stream("/camera0/image", SampleKind::frame);
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  Recorder recorder(streams, {.queue_bytes = 500'000, .chunk_bytes = 100'000});
  ASSERT_TRUE(open(recorder));
  disk.set_stuck(true);
  std::uint64_t dropped = 0;
  for (std::uint32_t i = 0; i < 10; ++i) {
    const Sample frame{{.stream = camera, .sequence = i}, testing::filled_frame(pool, 300, 300, 300)};
    dropped += recorder.record(frame, time(i)) ? 0U : 1U;  // returns at once, stuck or not
  }
  EXPECT_EQ(dropped, 5U);  // five of 90,000 bytes fit in half a megabyte
  recorder.record(bytes_sample(sonic, 0), time(20));
  RecorderState state = recorder.state();
  EXPECT_TRUE(state.recording);
  EXPECT_EQ(state.state, DeviceState::degraded);
  EXPECT_THAT(state.message, HasSubstr("too slow"));
  EXPECT_EQ(state.streams.at("/camera0/image").dropped, 5U);
  disk.set_stuck(false);
  const auto closed = recorder.close();
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().code, ErrorCode::busy);

  state = recorder.state();
  EXPECT_FALSE(state.recording);
  EXPECT_EQ(state.streams.at("/camera0/image").received, 10U);
  EXPECT_EQ(state.streams.at("/camera0/image").recorded, 5U);
  const auto reader = read();
  EXPECT_TRUE(reader->index().complete);
  EXPECT_EQ(count(*reader, "/camera0/image"), 5U);
  EXPECT_EQ(count(*reader, "/sonic/raw"), 1U);
  const auto counters = mcap::counters_from(reader->find_metadata(mcap::kCountersMetadata)->value());
  ASSERT_TRUE(counters);
  EXPECT_EQ(counters->at("/camera0/image").dropped, 5U);
  EXPECT_EQ(counters->at("/camera0/image").recorded, 5U);
  auto drops = reader->messages({.channels = {{reader->channel_of_topic("/recorder/drops")->id}}});
  std::uint64_t reported = 0;
  while (const auto message = *drops.next()) {
    const auto sample = schema::parse(SampleKind::drop, message->message.data, {}, streams);
    ASSERT_TRUE(sample);
    EXPECT_EQ(std::get<Drop>(sample->payload).topic, "/camera0/image");
    EXPECT_EQ(std::get<Drop>(sample->payload).stage, "recorder");
    reported += std::get<Drop>(sample->payload).count;
  }
  EXPECT_EQ(reported, 5U);
}

TEST_F(RecorderTest, WaitingInsteadLosesNothing) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  Recorder recorder(streams, {.queue_bytes = 5'000, .wait_when_full = true});
  ASSERT_TRUE(open(recorder));
  disk.set_stuck(true);
  std::atomic<std::uint32_t> taken{0};
  std::jthread caller([&] {
    for (std::uint32_t i = 0; i < 500; ++i, ++taken) recorder.record(bytes_sample(sonic, i), time(i));
  });
  wait_until([&] { return taken >= 5; });
  EXPECT_LT(taken, 500U);
  disk.set_stuck(false);
  caller.join();
  ASSERT_TRUE(recorder.close());
  EXPECT_EQ(count(*read(), "/sonic/raw"), 500U);
  EXPECT_EQ(recorder.state().streams.at("/sonic/raw").dropped, 0U);
}

TEST_F(RecorderTest, AFullDiskLosesNothingAlreadyRecordedAndSaysWhatToDo) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  disk.capacity = 6'000;
  disk.reserve = 100'000;
  Recorder recorder(streams, {.chunk_time = 5ms});
  ASSERT_TRUE(open(recorder));
  std::uint32_t sent = 0;
  for (; sent < 2'000; ++sent) recorder.record(bytes_sample(sonic, sent), time(sent));
  wait_until([&] { return recorder.state().state == DeviceState::degraded; });
  EXPECT_THAT(recorder.state().message, HasSubstr("free some space"));
  EXPECT_THAT(recorder.state().message, HasSubstr("Recording has stopped"));
  wait_until([&] { return !recorder.record(bytes_sample(sonic, sent), time(sent)) || ++sent > 10'000; });
  const auto closed = recorder.close();
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().code, ErrorCode::no_space);

  const auto state = recorder.state();
  const auto& counters = state.streams.at("/sonic/raw");
  EXPECT_EQ(counters.received, counters.recorded + counters.dropped);
  const auto reader = read();
  EXPECT_TRUE(reader->index().complete);  // closed properly in the space kept back
  EXPECT_GT(counters.recorded, 10U);
  EXPECT_EQ(count(*reader, "/sonic/raw"), counters.recorded);
  auto cursor = reader->messages();
  std::uint32_t expected = 0;
  while (const auto message = *cursor.next()) EXPECT_EQ(message->message.sequence, expected++);
}

TEST_F(RecorderTest, AFullDiskWithoutRoomForTheEndStillReads) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  disk.capacity = 6'000;
  Recorder recorder(streams, {.chunk_time = 5ms});
  ASSERT_TRUE(open(recorder));
  for (std::uint32_t i = 0; i < 2'000; ++i) recorder.record(bytes_sample(sonic, i), time(i));
  EXPECT_FALSE(recorder.close());
  EXPECT_EQ(recorder.state().state, DeviceState::failed);
  EXPECT_THAT(recorder.state().message, HasSubstr("not closed properly"));
  const auto reader = read();
  EXPECT_FALSE(reader->index().complete);
  EXPECT_EQ(count(*reader, "/sonic/raw"), recorder.state().streams.at("/sonic/raw").recorded);
  EXPECT_GT(count(*reader, "/sonic/raw"), 10U);
}

TEST_F(RecorderTest, DevFullIsRefusedAtOnce) {
  Recorder recorder(streams);
  const auto opened =
      recorder.open(mcap::FileWritable::adopt(::open("/dev/full", O_WRONLY), "/dev/full"), "/dev/full", kDescription);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::no_space);
  EXPECT_TRUE(recorder.record(bytes_sample(add_stream("/sonic/raw", SampleKind::raw_bytes), 0), time(0)));  // nobody records
  EXPECT_TRUE(open(recorder));  // and another file may be opened
}

TEST_F(RecorderTest, ACutFileSaysWhatItLacks) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  // Others count since the program began; the file says what happened since it began.
  std::atomic<bool> recording{false};
  const auto upstream = [&] {
    return recording ? mcap::TopicCounters{{"/sonic/raw", {.gaps = 4}},
                                           {"/camera0/image", {.received = 9, .dropped = 8, .dropped_intake = 7}}}
                     : mcap::TopicCounters{{"/sonic/raw", {.gaps = 1}}, {"/camera0/image", {.received = 2, .dropped = 1}}};
  };
  Recorder recorder(streams, {.sync_interval = 10ms, .upstream_counters = upstream});
  ASSERT_TRUE(open(recorder));
  recording = true;
  for (std::uint32_t i = 0; i < 20; ++i) recorder.record(bytes_sample(sonic, i), time(i));
  std::vector<std::byte> cut;
  wait_until([&] {
    cut = disk.contents();
    const auto cut_reader = read(cut);
    return !cut_reader->index().private_records.empty() && count(*cut_reader, "/sonic/raw") == 20;
  });
  const auto reader = read(cut);
  EXPECT_FALSE(reader->index().complete);
  const auto counters = mcap::counters_from(*reader->read(reader->index().private_records.back()));
  ASSERT_TRUE(counters);
  EXPECT_EQ(counters->at("/sonic/raw").recorded, count(*reader, "/sonic/raw"));
  EXPECT_EQ(counters->at("/sonic/raw").gaps, 3U);
  EXPECT_EQ(counters->at("/camera0/image").received, 7U);
  EXPECT_EQ(counters->at("/camera0/image").dropped, 7U);
  EXPECT_EQ(counters->at("/camera0/image").dropped_intake, 7U);
  EXPECT_TRUE(recorder.close());
}

TEST_F(RecorderTest, SamplesWithoutASequencerAreNumberedByArrival) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  Recorder recorder(streams);
  ASSERT_TRUE(open(recorder));
  for (const std::uint32_t sequence : {5U, 5U, 3U, 9U}) EXPECT_TRUE(recorder.receive(bytes_sample(sonic, sequence)));
  ASSERT_TRUE(recorder.close());
  auto reader = read();
  auto cursor = reader->messages();
  std::vector<std::pair<std::uint64_t, std::uint32_t>> read_back;
  while (const auto message = *cursor.next()) read_back.emplace_back(message->message.log_time_ns, message->message.sequence);
  const auto at = mcap::log_time_from(time(5));
  EXPECT_THAT(read_back, ::testing::ElementsAre(std::pair(at, 5U), std::pair(at + 1, 5U), std::pair(at + 2, 3U),
                                                std::pair(mcap::log_time_from(time(9)), 9U)));
}

TEST_F(RecorderTest, ManyThreadsMayRecordAndAsk) {
  std::vector<StreamId> ids;
  for (int i = 0; i < 4; ++i) ids.push_back(add_stream("/sonic" + std::to_string(i) + "/raw", SampleKind::raw_bytes));
  Recorder recorder(streams, {.chunk_time = 2ms, .sync_interval = 5ms});
  ASSERT_TRUE(open(recorder));
  {
    std::vector<std::jthread> threads;
    for (const StreamId id : ids) {
      threads.emplace_back([&, id] {
        for (std::uint32_t i = 0; i < 2'000; ++i) recorder.record(bytes_sample(id, i), time(i));
      });
    }
    threads.emplace_back([&] {
      for (int i = 0; i < 200; ++i) EXPECT_EQ(recorder.state().state, DeviceState::running);
    });
  }
  ASSERT_TRUE(recorder.close());
  const auto reader = read();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(count(*reader, "/sonic" + std::to_string(i) + "/raw"), 2'000U);
}

// ---------------------------------------------------------------------------------------------------------------------
// Real files

class RecorderFile : public RecorderTest {
 protected:
  std::filesystem::path directory =
      std::filesystem::temp_directory_path() /
      ("roseau-recorder-" + std::to_string(::getpid()) + ::testing::UnitTest::GetInstance()->current_test_info()->name());
  void SetUp() override { std::filesystem::create_directories(directory); }
  void TearDown() override { std::filesystem::remove_all(directory); }
};

TEST_F(RecorderFile, OneFileAfterTheOther) {
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  Recorder recorder(streams);
  EXPECT_TRUE(recorder.record(bytes_sample(sonic, 0), time(0)));  // not recording: ignored
  ASSERT_TRUE(recorder.open(directory / "a.mcap", kDescription));
  EXPECT_EQ(recorder.open(directory / "b.mcap", kDescription).error().code, ErrorCode::busy);
  recorder.record(bytes_sample(sonic, 1), time(1));
  recorder.record(bytes_sample(sonic, 2), time(2001));
  ASSERT_TRUE(recorder.close());
  const auto state = recorder.state();
  EXPECT_EQ(state.path, (directory / "a.mcap").string());
  EXPECT_EQ(state.bytes, std::filesystem::file_size(directory / "a.mcap"));
  EXPECT_DOUBLE_EQ(state.seconds, 2);
  EXPECT_GT(state.disk_free_bytes, 0U);
  EXPECT_THAT(recorder.open(directory / "a.mcap", kDescription).error().message, HasSubstr("never overwritten"));
  ASSERT_TRUE(recorder.open(directory / "b.mcap", kDescription));
  EXPECT_EQ(recorder.state().streams.size(), 0U);
  EXPECT_TRUE(recorder.close());
  EXPECT_TRUE(recorder.close());
  for (const char* name : {"a.mcap", "b.mcap"}) {
    const auto reader = mcap::IndexedReader::open(directory / name);
    ASSERT_TRUE(reader);
    EXPECT_TRUE((*reader)->index().complete);
  }
  EXPECT_EQ((*mcap::IndexedReader::open(directory / "a.mcap"))->index().statistics.message_count, 2U);
}

TEST_F(RecorderFile, KilledItKeepsWhatItSaidWasRecorded) {
  const auto path = directory / "killed.mcap";
  const StreamId sonic = add_stream("/sonic/raw", SampleKind::raw_bytes);
  const StreamId camera = add_stream("/camera0/image", SampleKind::frame);
  constexpr std::uint32_t kSamples = 100;
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    Recorder recorder(streams);
    if (!recorder.open(path, kDescription)) ::_exit(1);
    for (std::uint32_t i = 0; i < kSamples; ++i) recorder.record(bytes_sample(sonic, i), time(i));
    for (std::uint32_t i = 0; i < 3; ++i) recorder.record({{.stream = camera}, testing::filled_frame(pool)}, time(i));
    // No more samples come: what is in the open chunks must reach the file by itself.
    wait_until([&] {
      auto counters = recorder.state().streams;
      return counters["/sonic/raw"].recorded == kSamples && counters["/camera0/image"].recorded == 3;
    });
    static_cast<void>(::write(ready[1], "x", 1));
    for (std::uint32_t i = kSamples;; ++i) recorder.record(bytes_sample(sonic, i), time(i));  // killed in the middle of it
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);

  const auto reader = mcap::IndexedReader::open(path);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_FALSE((*reader)->index().complete);
  EXPECT_EQ(count(**reader, "/camera0/image"), 3U);
  auto cursor = (*reader)->messages({.channels = {{(*reader)->channel_of_topic("/sonic/raw")->id}}});
  std::uint32_t expected = 0;
  while (const auto message = *cursor.next()) EXPECT_EQ(message->message.sequence, expected++);
  EXPECT_GE(expected, kSamples);
}

}  // namespace
}  // namespace roseau::recorder
