// Writes and syncs that fail, each in turn: the first error stays and is shown, the file reads as far as it was written, and
// every stream's counts say what is in it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "recorder/format/indexed_reader.h"
#include "recorder/recorder.h"
#include "tests/support/memory_file.h"
#include "tests/support/samples.h"

namespace roseau::recorder {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// What a disk got, and when it fails. Outlives the recorder.
struct FaultyDisk {
  std::mutex mutex;
  std::vector<std::byte> bytes;  // on the disk
  std::vector<std::byte> torn;   // after these: a write that came half through
  int appends = 0;
  int syncs = 0;
  int failing_append = -1;  // fails, and so do all after it, where `for_good`
  int failing_sync = -1;
  bool for_good = false;
  bool failed = false;
};

Error fault(const std::string& what) { return {ErrorCode::io, what + " session.mcap: Input/output error"}; }

/// Writes at once; what fails has written nothing.
class FaultyWritable : public mcap::Writable {
 public:
  explicit FaultyWritable(FaultyDisk& disk) : disk_(disk) {}
  Result<void> append(std::span<const std::span<const std::byte>> parts) override {
    const std::scoped_lock lock(disk_.mutex);
    if (disk_.appends++ == disk_.failing_append || (disk_.failed && disk_.for_good)) return fail("cannot append to");
    for (const auto& part : parts) disk_.bytes.insert(disk_.bytes.end(), part.begin(), part.end());
    return {};
  }
  Result<void> sync() override {
    const std::scoped_lock lock(disk_.mutex);
    if (disk_.syncs++ == disk_.failing_sync || (disk_.failed && disk_.for_good)) return fail("cannot sync");
    return {};
  }

 private:
  Error fail(const std::string& what) {
    disk_.failed = true;
    return fault(what);
  }
  FaultyDisk& disk_;
};

/// Takes what is appended and writes it later: then a failure is known later, too, and for good.
class LateWritable : public mcap::Writable {
 public:
  explicit LateWritable(FaultyDisk& disk) : disk_(disk) {}
  Result<void> append(std::span<const std::span<const std::byte>> parts) override {
    const std::scoped_lock lock(disk_.mutex);
    if (disk_.failed) return fault("cannot write");
    for (const auto& part : parts) pending_.insert(pending_.end(), part.begin(), part.end());
    return pending_.size() < 3'000 ? Result<void>{} : write();
  }
  std::uint64_t written() const override {
    const std::scoped_lock lock(disk_.mutex);
    return disk_.bytes.size();
  }
  Result<void> flush() override {
    const std::scoped_lock lock(disk_.mutex);
    return write();
  }
  Result<void> sync() override { return flush(); }

 private:
  Result<void> write() {
    if (!disk_.failed && !pending_.empty() && disk_.appends++ == disk_.failing_append) {
      disk_.failed = true;
      disk_.torn.assign(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(pending_.size() / 2));
    }
    if (disk_.failed) return fault("cannot write");
    disk_.bytes.insert(disk_.bytes.end(), pending_.begin(), pending_.end());
    pending_.clear();
    return {};
  }
  FaultyDisk& disk_;
  std::vector<std::byte> pending_;
};

class WriteFaults : public ::testing::Test {
 protected:
  static constexpr std::uint32_t kSamples = 120;

  static HostTime time(std::uint32_t sequence) { return host_time_from_ns(1'000'000'000 + std::int64_t{sequence} * 1'000'000); }

  /// A short recording of two streams. Nothing: not even the head could be written.
  std::optional<RecorderState> record(std::unique_ptr<mcap::Writable> out) {
    StreamTable streams;
    const StreamId ids[] = {streams.add({.topic = "/sonic/raw", .kind = "raw_bytes"}),
                            streams.add({.topic = "/tracker/raw", .kind = "raw_bytes"})};
    const StreamId camera = streams.add({.topic = "/camera0/image", .kind = "frame"});
    Recorder recorder(streams, {.chunk_time = 20ms, .sync_interval = 1ms});
    if (auto opened = recorder.open(std::move(out), "session.mcap", {.program_version = "1"}); !opened) {
      first_error = opened.error().message;
      return std::nullopt;
    }
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      for (const StreamId id : ids) recorder.record({{.stream = id, .sequence = i}, testing::raw_bytes_of("record")}, time(i));
      if (i % 10 == 0) recorder.record({{.stream = camera, .sequence = i}, testing::filled_frame(pool)}, time(i));
      if (i % 40 == 0) std::this_thread::sleep_for(3ms);  // syncs come by the clock
    }
    const auto closed = recorder.close();
    first_error = closed ? "" : closed.error().message;
    return recorder.state();
  }

  /// How many messages of each topic can be read.
  static void count_messages(std::vector<std::byte> bytes, std::map<std::string, std::uint64_t>& held) {
    auto opened = mcap::IndexedReader::open(std::make_unique<testing::MemoryReadable>(std::move(bytes)));
    ASSERT_TRUE(opened) << opened.error().message;
    auto cursor = (*opened)->messages();
    while (true) {
      const auto message = cursor.next();
      ASSERT_TRUE(message) << message.error().message;
      if (!*message) break;
      ++held[(*message)->channel->topic];
    }
  }

  static void expect_honest(const FaultyDisk& disk, const RecorderState& state) {
    std::map<std::string, std::uint64_t> held;
    count_messages(disk.bytes, held);
    if (!disk.torn.empty()) {  // does not keep the rest from being read, and may give some more
      std::vector<std::byte> all = disk.bytes;
      all.insert(all.end(), disk.torn.begin(), disk.torn.end());
      std::map<std::string, std::uint64_t> with_torn;
      count_messages(all, with_torn);
      for (const auto& [topic, messages] : held) EXPECT_GE(with_torn[topic], messages) << topic;
    }
    std::uint64_t received = 0;
    for (const auto& [topic, counters] : state.streams) {
      EXPECT_EQ(counters.recorded, held[topic]) << topic;
      EXPECT_EQ(counters.received, counters.recorded + counters.dropped) << topic;
      EXPECT_EQ(counters.dropped, counters.dropped_write) << topic;
      if (topic != "/recorder/drops") received += counters.received;
    }
    EXPECT_EQ(received, 2 * kSamples + kSamples / 10);
  }

  FramePool pool{32, 100};
  std::string first_error;
};

TEST_F(WriteFaults, EachAppendInTurn) {
  int failed_while_recording = 0;
  for (const bool for_good : {false, true}) {
    for (int k = 0;; ++k) {
      SCOPED_TRACE("append " + std::to_string(k) + (for_good ? " and all after it" : ""));
      FaultyDisk disk;
      disk.failing_append = k;
      disk.for_good = for_good;
      const auto state = record(std::make_unique<FaultyWritable>(disk));
      if (!state) {
        EXPECT_THAT(first_error, HasSubstr("cannot append"));
        continue;
      }
      expect_honest(disk, *state);
      if (!disk.failed) {
        EXPECT_EQ(state->state, DeviceState::finished);
        break;  // one further than the last append
      }
      ++failed_while_recording;
      EXPECT_THAT(first_error, HasSubstr("cannot append"));
      EXPECT_THAT(state->message, HasSubstr("cannot append"));
      EXPECT_TRUE(state->state == DeviceState::degraded || state->state == DeviceState::failed);
      EXPECT_TRUE(!for_good || state->state == DeviceState::failed) << "no end could be written";
      ASSERT_LT(k, 200);
    }
  }
  EXPECT_GT(failed_while_recording, 20);
}

TEST_F(WriteFaults, EachSyncInTurn) {
  int failed = 0;
  for (int k = 0; k < 100; ++k) {
    SCOPED_TRACE("sync " + std::to_string(k));
    FaultyDisk disk;
    disk.failing_sync = k;
    const auto state = record(std::make_unique<FaultyWritable>(disk));
    ASSERT_TRUE(state);
    expect_honest(disk, *state);
    if (!disk.failed) break;  // so many there were not: they come by the clock
    ++failed;
    EXPECT_THAT(first_error, HasSubstr("cannot sync"));
    EXPECT_THAT(state->message, HasSubstr("cannot sync"));
  }
  EXPECT_GE(failed, 2) << "there are always those of closing";
}

TEST_F(WriteFaults, WritesThatFailAfterTheyWerePutOff) {
  int failed = 0;
  for (int k = 0;; ++k) {
    SCOPED_TRACE("write " + std::to_string(k));
    FaultyDisk disk;
    disk.failing_append = k;
    const auto state = record(std::make_unique<LateWritable>(disk));
    if (!state) continue;
    if (!disk.failed) break;
    ++failed;
    // A file whose head is not whole is no session, and holds nothing that was counted.
    if (disk.bytes.size() > 500) {
      expect_honest(disk, *state);
    } else {
      EXPECT_EQ(state->streams.at("/sonic/raw").recorded, 0U);
    }
    EXPECT_THAT(first_error, HasSubstr("cannot write"));
    EXPECT_EQ(state->state, DeviceState::failed);
    ASSERT_LT(k, 200);
  }
  EXPECT_GT(failed, 4);
}

}  // namespace
}  // namespace roseau::recorder
