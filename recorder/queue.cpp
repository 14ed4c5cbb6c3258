#include "recorder/queue.h"

#include <algorithm>
#include <utility>

namespace roseau::recorder {

namespace {

/// What a sample holds, roughly: pixels and long payloads count, the rest is its own size.
std::uint64_t bytes_of(const Sample& sample) {
  std::uint64_t bytes = sizeof(QueuedSample);
  if (const auto* frame = std::get_if<Frame>(&sample.payload)) bytes += frame->bytes().size();
  if (const auto* motion = std::get_if<ImageMotion>(&sample.payload))
    bytes += motion->points.size() * sizeof(ImageMotion::Point);
  if (const auto* spectrum = std::get_if<ForceSpectrum>(&sample.payload)) {
    bytes += 5 * sizeof(float) * spectrum->frequency_hz.size();
  }
  return bytes;
}

}  // namespace

void Queue::begin(const std::string& path) {
  const std::scoped_lock lock(mutex_);
  taking_ = true;
  closing_ = false;
  samples_.clear();
  held_bytes_ = 0;
  counts_.clear();
  first_error_.reset();
  write_failed_ = false;
  first_log_time_.reset();
  last_log_time_ = HostTime{Duration{0}};
  state_ = {.recording = true, .state = DeviceState::running, .path = path};
}

Queue::Counts& Queue::counts_of(StreamId stream) {
  if (stream >= counts_.size()) counts_.resize(stream + 1U);
  return counts_[stream];
}

void Queue::drop(StreamId stream, std::uint64_t count) { counts_of(stream).dropped += count; }

bool Queue::push(const Sample& sample, HostTime log_time, bool wait_when_full) {
  const std::uint64_t bytes = bytes_of(sample);
  std::unique_lock lock(mutex_);
  if (!taking_) return true;
  ++counts_of(sample.header.stream).received;
  if (!first_log_time_) first_log_time_ = log_time;
  last_log_time_ = std::max(last_log_time_, log_time);

  // One sample is always let in, however large, or it could never be recorded.
  const auto fits = [&] { return held_bytes_ == 0 || held_bytes_ + bytes <= budget_bytes_; };
  if (wait_when_full && !fits()) {
    ++waiting_callers_;
    wake_writer();
    space_ready_.wait(lock, [&] { return fits() || write_failed_ || !taking_; });
    --waiting_callers_;
  }
  if (write_failed_ || !taking_ || !fits()) {
    drop(sample.header.stream, 1);
    if (!first_error_) {
      first_error_ = Error{ErrorCode::busy,
                           "the disk is too slow for what is recorded: samples were dropped (counted per stream). Record to a "
                           "faster disk, or record fewer, smaller or slower pictures"};
      state_.state = DeviceState::degraded;
      state_.message = first_error_->message;
    }
    return false;
  }
  samples_.push_back({sample, log_time, bytes});
  held_bytes_ += bytes;
  wake_writer();
  return true;
}

void Queue::wake_writer() {
  if (std::exchange(writer_waits_, false)) work_ready_.notify_one();
}

bool Queue::callers_wait() const {
  const std::scoped_lock lock(mutex_);
  return waiting_callers_ > 0;
}

bool Queue::pop(std::vector<QueuedSample>& batch, std::chrono::steady_clock::time_point deadline) {
  batch.clear();
  std::unique_lock lock(mutex_);
  if (samples_.empty() && !closing_ && waiting_callers_ == 0) {
    writer_waits_ = true;
    work_ready_.wait_until(lock, deadline, [this] { return !writer_waits_; });
    writer_waits_ = false;
  }
  std::swap(batch, samples_);
  return !closing_;
}

void Queue::begin_closing() {
  const std::scoped_lock lock(mutex_);
  taking_ = false;
  closing_ = true;
  state_.recording = false;
  wake_writer();
  space_ready_.notify_all();
}

void Queue::settle(const Written& written, std::uint64_t file_bytes) {
  const std::scoped_lock lock(mutex_);
  for (const auto& [stream, count] : written.samples) counts_of(stream).recorded += count;
  for (const auto& [stream, count] : written.lost) drop(stream, count);
  state_.bytes = file_bytes;
  if (written.budget_bytes == 0) return;
  held_bytes_ -= std::min(held_bytes_, written.budget_bytes);
  space_ready_.notify_all();
}

void Queue::fail(const Error& error) {
  const std::scoped_lock lock(mutex_);
  write_failed_ = true;
  space_ready_.notify_all();
  state_.state = DeviceState::degraded;
  state_.message =
      error.message + ". Recording has stopped; what was recorded before is safe. Stop and start recording to go on";
  if (!first_error_ || first_error_->code == ErrorCode::busy) first_error_ = error;  // worse than being slow
}

bool Queue::has_failed() const {
  const std::scoped_lock lock(mutex_);
  return write_failed_;
}

void Queue::end(DeviceState state, const std::string& message) {
  const std::scoped_lock lock(mutex_);
  state_.state = state;
  state_.message = message;
}

void Queue::set_disk_free(std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  state_.disk_free_bytes = bytes;
}

std::vector<std::pair<StreamId, std::uint64_t>> Queue::take_new_drops() {
  std::vector<std::pair<StreamId, std::uint64_t>> drops;
  const std::scoped_lock lock(mutex_);
  for (std::size_t stream = 0; stream < counts_.size(); ++stream) {
    Counts& counts = counts_[stream];
    if (counts.dropped == counts.dropped_reported) continue;
    drops.emplace_back(static_cast<StreamId>(stream), counts.dropped - counts.dropped_reported);
    counts.dropped_reported = counts.dropped;
  }
  return drops;
}

HostTime Queue::last_log_time() const {
  const std::scoped_lock lock(mutex_);
  return last_log_time_;
}

std::optional<Error> Queue::first_error() const {
  const std::scoped_lock lock(mutex_);
  return first_error_;
}

RecorderState Queue::state(const StreamTable& streams) const {
  RecorderState state;
  std::vector<Counts> counts;
  {
    const std::scoped_lock lock(mutex_);
    state = state_;
    counts = counts_;
    if (first_log_time_) state.seconds = to_seconds(last_log_time_ - *first_log_time_);
  }
  for (std::size_t stream = 0; stream < counts.size(); ++stream) {
    const Counts& of = counts[stream];
    if (of.received == 0 && of.recorded == 0) continue;
    state.streams[streams.info(static_cast<StreamId>(stream)).topic] = {
        .received = of.received, .recorded = of.recorded, .dropped = of.dropped};
  }
  return state;
}

}  // namespace roseau::recorder
