#include "recorder/recorder.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <utility>

#include "recorder/format/file_io.h"
#include "recorder/queue.h"
#include "recorder/writer_thread.h"

namespace roseau::recorder {

struct Recorder::Shared {
  explicit Shared(const RecorderOptions& options) : queue(options.queue_bytes) {}
  Queue queue;
  std::mutex writer_mutex;  // open and close, against split_now
};

Recorder::Recorder(StreamTable& streams, RecorderOptions options)
    : streams_(streams), options_(std::move(options)), shared_(std::make_unique<Shared>(options_)) {
  // A chunk must not hold so much of the queue's budget that callers wait for it to fill.
  options_.chunk_bytes = std::min(options_.chunk_bytes, options_.queue_bytes / 4);
}

Recorder::~Recorder() { static_cast<void>(close().has_value()); }

Result<void> Recorder::open(const std::filesystem::path& path, const SessionDescription& description) {
  if (writer_) return already_open();
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
  if (writer_) return already_open();
  auto writer = std::make_unique<WriterThread>(streams_, options_, shared_->queue);
  if (auto begun = writer->begin(std::move(out), name, description); !begun) return begun;
  last_received_ = HostTime{Duration::min()};
  const std::scoped_lock lock(shared_->writer_mutex);
  writer_ = std::move(writer);
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
  if (!writer_) return {};
  shared_->queue.begin_closing();
  writer_->join();
  {
    const std::scoped_lock lock(shared_->writer_mutex);
    writer_.reset();
  }
  if (const auto error = shared_->queue.first_error()) return *error;
  return {};
}

Result<void> Recorder::split_now() {
  const std::scoped_lock lock(shared_->writer_mutex);
  if (!writer_ || !shared_->queue.is_taking()) return Error{ErrorCode::invalid_argument, "nothing is being recorded"};
  writer_->split_now();
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
