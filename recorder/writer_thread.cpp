#include "recorder/writer_thread.h"

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "core/log.h"
#include "recorder/format/crc32.h"
#include "recorder/format/file_io.h"
#include "recorder/image_storage.h"

namespace roseau::recorder {

namespace {

std::chrono::steady_clock::time_point now() { return std::chrono::steady_clock::now(); }

/// What tells sessions apart: when and by whom they were begun. The same samples must give the same file where that was asked
/// for: then it is what the session's texts make of it, and only said where parts must find each other; two simulations of one
/// scene are not one session.
std::string make_session_id(const SessionDescription& description, const std::filesystem::path& path,
                            const RecorderOptions& options) {
  const bool reproducible = options.reproducible;
  if (reproducible && options.split.bytes == 0 && options.split.time == Duration{0}) return "";
  const auto sum = [](std::uint32_t before, std::string_view text) {
    return mcap::crc32(before, std::as_bytes(std::span(text)));
  };
  std::uint32_t crc = sum(sum(0, description.config_text), description.site_text);
  std::uint32_t time_s = 0;
  if (!reproducible) {
    timespec time{};
    ::clock_gettime(CLOCK_REALTIME, &time);
    time_s = static_cast<std::uint32_t>(time.tv_sec);
    const std::uint64_t parts[] = {static_cast<std::uint64_t>(time.tv_nsec), static_cast<std::uint64_t>(::getpid())};
    crc = mcap::crc32(sum(crc, path.string()), std::as_bytes(std::span(parts)));
  }
  char text[20];
  std::snprintf(text, sizeof text, "%08x-%08x", time_s, crc);
  return text;
}

}  // namespace

WriterThread::WriterThread(StreamTable& streams, const RecorderOptions& options, Queue& queue)
    : streams_(streams), options_(options), queue_(queue), finisher_(queue, options.part_finished) {}

Result<void> WriterThread::begin(std::unique_ptr<mcap::Writable> out, const std::filesystem::path& path,
                                 const SessionDescription& description) {
  description_ = description;
  first_path_ = path;
  session_id_ = description.session_id.empty() ? make_session_id(description, path, options_) : description.session_id;
  CountsSnapshot begin;
  if (options_.upstream_counters) begin.upstream = options_.upstream_counters();
  part_ = std::make_unique<Part>(std::move(out), path, streams_, options_, queue_, std::move(begin));
  if (auto written = part_->write_head(description, {.session_id = session_id_, .part = description.first_part}); !written) {
    return written;
  }
  queue_.begin(path.string(), session_id_, description.first_part);
  look_at_disk();
  thread_ = std::jthread([this] { run(); });
  return {};
}

void WriterThread::join() {
  if (thread_.joinable()) thread_.join();
}

void WriterThread::run() {
  try {
    write_until_closed();
    finish();
  } catch (const std::exception& exception) {
    fail({ErrorCode::io, std::string("the recorder failed: ") + exception.what()});
    queue_.end(DeviceState::failed, exception.what());
  }
}

void WriterThread::write_until_closed() {
  // Half the time twice: a chunk is written when it was there at the tick before.
  const Duration tick = options_.chunk_time / 2;
  SteadyTime next_tick = now() + tick;
  SteadyTime next_sync = now() + options_.sync_interval;
  std::vector<QueuedSample> batch;
  bool open = true;
  while (open) {
    // While frames are being coded, new samples join them; then the oldest is waited for.
    open = queue_.pop(batch, coder_.empty() ? std::min(next_tick, next_sync) : now());
    for (QueuedSample& queued : batch) code(std::move(queued));
    batch.clear();  // drops the leases
    take_coded(std::min(next_tick, next_sync));
    if (now() >= next_tick) {
      next_tick = now() + tick;
      if (!options_.reproducible) attempt([this] { return part_->flush_older(); });
    }
    if (now() >= next_sync) {
      sync();
      next_sync = now() + options_.sync_interval;
    }
    if (queue_.callers_wait() && !options_.reproducible) attempt([this] { return part_->flush(); });
    settle();
  }
}

/// Frames that are stored coded and have no such form yet get it on other threads; everything keeps its order.
void WriterThread::code(QueuedSample queued) {
  const auto* frame = std::get_if<Frame>(&queued.sample.payload);
  const bool to_png = frame != nullptr && !frame->coded && !failed_ &&
                      storage_of(queued.sample, streams_.info(queued.sample.header.stream), options_) != ImageStorage::raw;
  if (!to_png && coder_.empty()) return add(queued);
  coder_.submit(std::move(queued), to_png);
}

/// What is coded goes into the file. The oldest frame is waited for until `deadline`, others not.
void WriterThread::take_coded(SteadyTime deadline) {
  while (auto done = coder_.take(deadline)) {
    if (done->error && !failed_) queue_.report(done->error->with_context("a picture could not be stored as PNG"));
    add(done->queued);
    deadline = SteadyTime{};
  }
}

void WriterThread::add(const QueuedSample& queued) {
  if (!first_log_time_) first_log_time_ = last_log_time_ = queued.log_time;
  last_log_time_ = std::max(last_log_time_, queued.log_time);
  if (!failed_ && split_is_due(queued)) begin_next_part(queued);
  remember_for_next_part(queued.sample);
  // After a failure the part counts it as lost.
  if (auto added = part_->add(queued); !added && !failed_) fail(added.error());
  if (part_->bytes() != settled_bytes_) settle();  // a chunk was written: its space is free now, not after the batch
}

void WriterThread::settle() {
  settled_bytes_ = part_->bytes();
  part_->settle();
  const std::uint64_t written = part_->written_bytes();
  queue_.set_bytes(written, earlier_bytes_ + written);
  if (first_log_time_) queue_.set_seconds(to_seconds(last_log_time_ - *first_log_time_));
}

/// Nothing is written any more after the first failure.
template <class Write>
void WriterThread::attempt(Write write) {
  if (failed_) return;
  if (auto written = write(); !written) fail(written.error());
}

void WriterThread::fail(const Error& error) {
  failed_ = true;
  log("recorder")->error("{}", error.message);
  queue_.fail(error);
  part_->abandon();
  settle();
}

CountsSnapshot WriterThread::counts() const {
  CountsSnapshot counts{.stages = queue_.counts()};
  if (options_.upstream_counters) counts.upstream = options_.upstream_counters();
  return counts;
}

/// Everything so far onto the disk, with the counters as of now.
void WriterThread::sync() {
  if (!options_.reproducible) {
    write_everything();
    attempt([this] { return part_->checkpoint(counts(), finisher_.session_counters()); });
  }
  attempt([this] { return part_->begin_sync(); });
  look_at_disk();
}

void WriterThread::write_everything() {
  while (!coder_.empty()) take_coded(SteadyTime::max());
  report_drops();
  attempt([this] { return part_->flush(); });
  settle();
}

void WriterThread::report_drops() {
  const auto all = queue_.counts();
  reported_drops_.resize(std::max(reported_drops_.size(), all.size()));
  for (std::size_t stream = 0; stream < all.size(); ++stream) {
    const std::uint64_t dropped = all[stream].dropped();
    const std::uint64_t count = dropped - std::min(dropped, std::exchange(reported_drops_[stream], dropped));
    if (count == 0 || failed_) continue;
    const StreamId own = streams_.add({.topic = "/recorder/drops", .kind = "drop", .role = StreamRole::health});
    const Sample drop{
        {.stream = own, .sequence = drop_sequence_++, .arrival_time = last_log_time_, .sample_time = last_log_time_},
        Drop{streams_.info(static_cast<StreamId>(stream)).topic, "recorder", count}};
    queue_.count_own(own);
    attempt([&] { return part_->add({.sample = drop, .log_time = last_log_time_}); });
  }
}

void WriterThread::look_at_disk() {
  std::error_code error;
  const auto& path = part_->path();
  const auto space = std::filesystem::space(path.has_parent_path() ? path.parent_path() : ".", error);
  if (!error) queue_.set_disk_free(space.available);
}

/// After a failure too: the summary of what was written before may still fit (the file keeps some space back for it).
void WriterThread::finish() {
  write_everything();
  const FinishedPart finished = finisher_.finish_last(*part_, counts());
  queue_.set_bytes(finished.bytes, finisher_.session_bytes());
  if (!finished.problem.empty()) {
    const std::string message =
        finished.path.string() + " was not closed properly: " + finished.problem + ". It reads up to its last whole chunk";
    queue_.fail({ErrorCode::io, message});
    return queue_.end(DeviceState::failed, message);
  }
  if (const auto first_error = queue_.first_error()) return queue_.end(DeviceState::degraded, first_error->message);
  queue_.end(DeviceState::finished, "");
}

// ---------------------------------------------------------------------------------------------------------------------
// Parts

void WriterThread::split_now() {
  const std::scoped_lock lock(marks_mutex_);
  marks_.push_back(queue_.next_position());
  split_from_ = marks_.front();
}

void WriterThread::forget_marks(std::uint64_t up_to) {
  const std::scoped_lock lock(marks_mutex_);
  while (!marks_.empty() && marks_.front() <= up_to) marks_.pop_front();
  split_from_ = marks_.empty() ? kNoSplit : marks_.front();
}

bool WriterThread::split_is_due(const QueuedSample& next) {
  const std::uint64_t from = split_from_;
  if (!part_->has_samples()) {
    if (next.position >= from) forget_marks(next.position);  // it begins with this sample as it is
    return false;
  }
  const bool asked = next.position >= from;
  const bool too_old = options_.split.time > Duration{0} && part_->age_at(next.log_time) >= options_.split.time;
  const bool too_large = options_.split.bytes > 0 && part_->bytes_with(next.sample) > options_.split.bytes;
  return (asked || too_old || too_large) && now() >= no_split_before_;
}

void WriterThread::begin_next_part(const QueuedSample& first) {
  const CountsSnapshot border = counts();
  auto next = make_next_part(border, first.log_time);
  if (!next) return split_failed(next.error());
  forget_marks(first.position);
  if (std::exchange(split_failed_, false)) queue_.set_split_problem("");
  part_->settle();
  earlier_bytes_ += part_->bytes();
  finisher_.add(std::exchange(part_, std::move(*next)), border);
  queue_.set_part(part_->path().string(), part_->number());
  log("recorder")->info("recording to {}", part_->path().string());
}

Result<std::unique_ptr<Part>> WriterThread::make_next_part(const CountsSnapshot& begin, HostTime log_time) {
  const std::uint32_t number = part_->number() + 1;
  const auto path = options_.part_path(first_path_, number);
  auto out = [&]() -> Result<std::unique_ptr<mcap::Writable>> {
    if (options_.create_part) return options_.create_part(path);
    auto file = mcap::FileWritable::create(path);
    if (!file) return file.error();
    return std::unique_ptr<mcap::Writable>(std::move(*file));
  }();
  if (!out) return out.error();
  auto part = std::make_unique<Part>(std::move(*out), path, streams_, options_, queue_, begin);
  auto written = part->write_head(description_, {.session_id = session_id_, .part = number, .repeated = repeats(log_time)});
  if (written) return part;
  part.reset();
  std::error_code ignored;  // the head did not fit: nothing worth keeping is in the file
  if (!options_.create_part) std::filesystem::remove(path, ignored);
  return written.error();
}

void WriterThread::split_failed(const Error& error) {
  no_split_before_ = now() + options_.sync_interval;
  const std::string message =
      "the next part of the session could not be begun: " + error.message + ". Recording goes on in " + part_->path().string();
  if (!std::exchange(split_failed_, true)) log("recorder")->error("{}", message);
  queue_.set_split_problem(message);
}

/// What a part must know to be of use alone: how the cameras look at the world, and what is tracked in their pictures.
void WriterThread::remember_for_next_part(const Sample& sample) {
  if (sample.kind() == SampleKind::camera_calibration) calibrations_[sample.header.stream] = sample;
  const auto* action = std::get_if<OperatorAction>(&sample.payload);
  if (action == nullptr) return;
  if (action->kind == OperatorAction::Kind::add_target) targets_[{action->camera, action->text}] = sample;
  if (action->kind != OperatorAction::Kind::remove_target) return;
  std::erase_if(targets_, [&](const auto& target) {
    return target.first.second == action->text && (action->camera.empty() || target.first.first == action->camera);
  });
}

/// As of the part's beginning: with the times they had, a replay of the part would begin with a long wait.
std::vector<Sample> WriterThread::repeats(HostTime log_time) const {
  std::vector<Sample> samples;
  for (const auto& [stream, sample] : calibrations_) samples.push_back(sample);
  for (const auto& [name, sample] : targets_) samples.push_back(sample);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    SampleHeader& header = samples[i].header;
    header.arrival_time = header.sample_time = log_time - Duration{static_cast<std::int64_t>(samples.size() - i)};
  }
  return samples;
}

}  // namespace roseau::recorder
