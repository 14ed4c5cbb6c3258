#include "recorder/recorder.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <thread>
#include <utility>
#include <vector>

#include "core/log.h"
#include "recorder/format/file_io.h"
#include "recorder/queue.h"
#include "recorder/session_writer.h"

namespace roseau::recorder {

namespace {

using SteadyTime = std::chrono::steady_clock::time_point;

/// Ours where we count, the others' where they do; drops in front of us are drops too.
mcap::TopicCounters merge(mcap::TopicCounters counters, const mcap::TopicCounters& upstream) {
  for (const auto& [topic, theirs] : upstream) {
    StreamCounters& ours = counters[topic];
    ours.received = std::max(ours.received, theirs.received);
    ours.dropped += theirs.dropped;
    ours.gaps = theirs.gaps;
    ours.bad = theirs.bad;
    ours.late = theirs.late;
  }
  return counters;
}

}  // namespace

struct Recorder::Shared {
  explicit Shared(const RecorderOptions& options) : queue(options.queue_bytes) {}
  Queue queue;
};

/// One open file and the thread that writes it.
class Recorder::FileThread {
 public:
  FileThread(std::unique_ptr<mcap::Writable> out, std::filesystem::path path, StreamTable& streams,
             const RecorderOptions& options, Queue& queue)
      : out_(std::move(out)),
        path_(std::move(path)),
        streams_(streams),
        options_(options),
        queue_(queue),
        session_(*out_, streams, options) {}
  ~FileThread() { join(); }

  Result<void> begin(const SessionDescription& description) {
    auto begun = session_.begin(description);
    if (!begun) return begun;
    queue_.begin(path_.string());
    look_at_disk();
    thread_ = std::jthread([this] { run(); });
    return {};
  }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run() {
    try {
      write_until_closed();
      finish();
    } catch (const std::exception& exception) {
      fail({ErrorCode::io, std::string("the recorder failed: ") + exception.what()});
      queue_.end(DeviceState::failed, exception.what());
    }
  }

  void write_until_closed() {
    // Half the time twice: a chunk is written when it was there at the tick before.
    const Duration tick = options_.chunk_time / 2;
    SteadyTime next_tick = now() + tick;
    SteadyTime next_sync = now() + options_.sync_interval;
    std::vector<QueuedSample> batch;
    bool open = true;
    while (open) {
      open = queue_.pop(batch, std::min(next_tick, next_sync));
      for (const QueuedSample& queued : batch) add(queued);
      batch.clear();  // drops the leases
      if (now() >= next_tick) {
        next_tick = now() + tick;
        if (!options_.reproducible) attempt([this] { return session_.flush_older(); });
      }
      if (now() >= next_sync) {
        sync();
        next_sync = now() + options_.sync_interval;
      }
      if (queue_.callers_wait() && !options_.reproducible) attempt([this] { return session_.flush(); });
      settle();
    }
  }

  static SteadyTime now() { return std::chrono::steady_clock::now(); }

  void add(const QueuedSample& queued) {
    if (failed_) {
      return queue_.settle({.lost = {{queued.sample.header.stream, 1}}, .budget_bytes = queued.bytes}, session_.bytes());
    }
    attempt([&] { return session_.add(queued.sample, queued.log_time, queued.bytes); });
    if (session_.bytes() != settled_bytes_) settle();  // a chunk was written: its space is free now, not after the batch
  }

  void settle() {
    settled_bytes_ = session_.bytes();
    queue_.settle(session_.take_written(), settled_bytes_);
  }

  /// Nothing is written any more after the first failure.
  template <class Write>
  void attempt(Write write) {
    if (failed_) return;
    if (auto written = write(); !written) fail(written.error());
  }

  void fail(const Error& error) {
    failed_ = true;
    log("recorder")->error("{}", error.message);
    queue_.fail(error);
    session_.abandon();
    settle();
  }

  mcap::TopicCounters counters() const {
    auto counters = queue_.state(streams_).streams;
    return options_.upstream_counters ? merge(std::move(counters), options_.upstream_counters()) : counters;
  }

  /// Everything so far onto the disk, with the counters as of now.
  void sync() {
    if (!options_.reproducible) {
      write_everything();
      attempt([this] { return session_.checkpoint(counters()); });
    }
    attempt([this] { return out_->sync(); });
    look_at_disk();
  }

  void write_everything() {
    report_drops();
    attempt([this] { return session_.flush(); });
    settle();
  }

  void report_drops() {
    for (const auto& [stream, count] : queue_.take_new_drops()) {
      if (failed_) return;
      const HostTime time = queue_.last_log_time();
      const Sample drop{{.stream = drop_stream(), .sequence = drop_sequence_++, .arrival_time = time, .sample_time = time},
                        Drop{streams_.info(stream).topic, "recorder", count}};
      attempt([&] { return session_.add(drop, time, 0); });
    }
  }
  StreamId drop_stream() { return streams_.add({.topic = "/recorder/drops", .kind = "drop", .role = StreamRole::health}); }

  void look_at_disk() {
    std::error_code error;
    const auto space = std::filesystem::space(path_.has_parent_path() ? path_.parent_path() : ".", error);
    if (!error) queue_.set_disk_free(space.available);
  }

  /// After a failure too: the summary of what was written before may still fit (the file keeps some space back for it).
  void finish() {
    write_everything();
    out_->begin_closing();
    auto finished = session_.finish(counters());
    auto closed = out_->close();
    if (finished) finished = closed;
    queue_.settle({}, session_.bytes());
    const auto first_error = queue_.first_error();
    if (!finished) {
      queue_.fail(finished.error());
      return queue_.end(DeviceState::failed, path_.string() + " was not closed properly: " + finished.error().message +
                                                 ". It reads up to its last whole chunk");
    }
    if (first_error) return queue_.end(DeviceState::degraded, first_error->message);
    queue_.end(DeviceState::finished, "");
  }

  std::unique_ptr<mcap::Writable> out_;
  std::filesystem::path path_;
  StreamTable& streams_;
  const RecorderOptions& options_;
  Queue& queue_;
  SessionWriter session_;
  bool failed_ = false;
  std::uint64_t settled_bytes_ = 0;
  std::uint32_t drop_sequence_ = 0;
  std::jthread thread_;
};

Recorder::Recorder(StreamTable& streams, RecorderOptions options)
    : streams_(streams), options_(std::move(options)), shared_(std::make_unique<Shared>(options_)) {
  // A chunk must not hold so much of the queue's budget that callers wait for it to fill.
  options_.chunk_bytes = std::min(options_.chunk_bytes, options_.queue_bytes / 4);
}

Recorder::~Recorder() { static_cast<void>(close().has_value()); }

Result<void> Recorder::open(const std::filesystem::path& path, const SessionDescription& description) {
  if (file_) return already_open();
  auto file = mcap::FileWritable::create(path);
  if (!file) return file.error();
  auto opened = open(std::move(*file), path.string(), description);
  if (!opened) {
    std::error_code ignored;  // the head did not fit: nothing worth keeping is in the file
    std::filesystem::remove(path, ignored);
  }
  return opened;
}

Result<void> Recorder::open(std::unique_ptr<mcap::Writable> out, const std::string& name,
                            const SessionDescription& description) {
  if (file_) return already_open();
  auto file = std::make_unique<FileThread>(std::move(out), name, streams_, options_, shared_->queue);
  if (auto begun = file->begin(description); !begun) return begun;
  last_received_ = HostTime{Duration::min()};
  file_ = std::move(file);
  return {};
}

Error Recorder::already_open() const { return {ErrorCode::busy, "already recording to " + state().path + ": stop that first"}; }

bool Recorder::record(const Sample& sample, HostTime log_time) {
  return shared_->queue.push(sample, log_time, options_.wait_when_full);
}

bool Recorder::record_waiting(const Sample& sample, HostTime log_time) {
  return shared_->queue.push(sample, log_time, /*wait_when_full=*/true);
}

bool Recorder::receive(Sample sample) {
  last_received_ = std::max(sample.header.arrival_time, last_received_ + Duration{1});
  return record(sample, last_received_);
}

Result<void> Recorder::close() {
  if (!file_) return {};
  shared_->queue.begin_closing();
  file_->join();
  file_.reset();
  if (const auto error = shared_->queue.first_error()) return *error;
  return {};
}

RecorderState Recorder::state() const { return shared_->queue.state(streams_); }

std::filesystem::path default_part_path(const std::filesystem::path& first, std::uint32_t part) {
  if (part <= 1) return first;
  std::string number = std::to_string(part);
  if (number.size() < 3) number.insert(0, 3 - number.size(), '0');  // so that names sort as the parts do
  return first.parent_path() / (first.stem().string() + ".part" + number + first.extension().string());
}

Duration current_utc_minus_host_time() {
  const auto read = [](clockid_t clock) {
    timespec time{};
    ::clock_gettime(clock, &time);
    return std::chrono::seconds(time.tv_sec) + Duration{time.tv_nsec};
  };
  // The civil clock between two readings of the monotonic one: as if all three were taken at one time.
  const Duration before = read(CLOCK_MONOTONIC);
  const Duration civil = read(CLOCK_REALTIME);
  const Duration after = read(CLOCK_MONOTONIC);
  return civil - (before + (after - before) / 2);
}

}  // namespace roseau::recorder
