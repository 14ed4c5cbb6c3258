#include "recorder/part.h"

#include <algorithm>
#include <utility>

namespace roseau::recorder {

namespace {

std::uint64_t since(std::uint64_t now, std::uint64_t before) { return now - std::min(now, before); }

StageCounts at(const std::vector<StageCounts>& counts, std::size_t stream) {
  return stream < counts.size() ? counts[stream] : StageCounts{};
}

}  // namespace

Part::Part(std::unique_ptr<mcap::Writable> out, std::filesystem::path path, StreamTable& streams,
           const RecorderOptions& options, Queue& queue, CountsSnapshot begin)
    : out_(std::move(out)),
      path_(std::move(path)),
      streams_(streams),
      queue_(queue),
      begin_(std::move(begin)),
      session_(*out_, streams, options) {}

Result<void> Part::write_head(const SessionDescription& description, PartHead head) {
  head_ = std::move(head);
  auto begun = session_.begin(description, head_);
  for (const Sample& sample : head_.repeated) {
    ++counts_of(sample.header.stream).repeated;
    ++counts_of(sample.header.stream).repeats_open;
  }
  head_.repeated.clear();
  return begun;
}

Part::Counts& Part::counts_of(StreamId stream) {
  if (stream >= counts_.size()) counts_.resize(stream + 1U);
  return counts_[stream];
}

Duration Part::age_at(HostTime log_time) const { return first_log_time_ ? log_time - *first_log_time_ : Duration{0}; }

Result<void> Part::add(const QueuedSample& queued) {
  ++counts_of(queued.sample.header.stream).taken;
  if (failed_) {
    ++counts_of(queued.sample.header.stream).dropped_write;
    queue_.settle({.lost = {{queued.sample.header.stream, 1}}, .budget_bytes = queued.bytes});
    return {};
  }
  if (!first_log_time_) first_log_time_ = last_log_time_ = queued.log_time;
  last_log_time_ = std::max(last_log_time_, queued.log_time);
  return session_.add(queued.sample, queued.log_time, queued.bytes);
}

/// What is held back in the file's own buffers goes out too.
Result<void> Part::flush_older() {
  if (auto flushed = session_.flush_older(); !flushed) return flushed;
  return out_->flush();
}

void Part::settle() {
  Written written = session_.take_written();
  take_out_repeats(written.samples, &Counts::recorded);
  take_out_repeats(written.lost, nullptr);
  for (const auto& [stream, count] : written.samples) counts_of(stream).recorded += count;
  for (const auto& [stream, count] : written.lost) counts_of(stream).dropped_write += count;
  for (const auto& [stream, count] : written.lost_in_encoder) counts_of(stream).dropped_encoder += count;
  queue_.settle(written);
}

/// Repeats are in the file, so its own counters hold them; the session's do not.
void Part::take_out_repeats(std::map<StreamId, std::uint64_t>& settled, std::uint64_t Counts::*counter) {
  for (auto& [stream, count] : settled) {
    Counts& counts = counts_of(stream);
    const std::uint64_t repeats = std::min(count, counts.repeats_open);
    counts.repeats_open -= repeats;
    count -= repeats;
    if (counter != nullptr) counts.*counter += repeats;
  }
}

void Part::abandon() {
  failed_ = true;
  session_.abandon();
  settle();
}

/// This file's alone. Ours where we count, the others' where they do; drops in front of us are drops too. `with_queue`: what is
/// on its way counts as received (a cut file says what it lacks); in the end that is the next part's.
mcap::TopicCounters Part::counters(const CountsSnapshot& now, bool with_queue) const {
  mcap::TopicCounters counters;
  const std::size_t streams = std::max(counts_.size(), now.stages.size());
  for (std::size_t stream = 0; stream < streams; ++stream) {
    const Counts mine = stream < counts_.size() ? counts_[stream] : Counts{};
    const StageCounts stages = at(now.stages, stream);
    const StageCounts before = at(begin_.stages, stream);
    const std::uint64_t refused = since(stages.refused, before.refused);
    StreamCounters of{.recorded = mine.recorded,
                      .dropped_queue = since(stages.dropped_queue, before.dropped_queue),
                      .dropped_encoder = mine.dropped_encoder,
                      .dropped_write = mine.dropped_write + refused,
                      .repeated = mine.repeated};
    of.dropped = of.dropped_queue + of.dropped_encoder + of.dropped_write;
    of.received = mine.taken + of.dropped_queue + refused + (with_queue ? stages.in_queue() : 0);
    if (of.received == 0 && of.recorded == 0) continue;
    counters[streams_.info(static_cast<StreamId>(stream)).topic] = of;
  }
  for (const auto& [topic, theirs] : now.upstream) {
    const auto found = begin_.upstream.find(topic);
    const StreamCounters before = found == begin_.upstream.end() ? StreamCounters{} : found->second;
    StreamCounters& ours = counters[topic];
    if (ours.received == 0) ours.received = since(theirs.received, before.received);
    ours.dropped += since(theirs.dropped, before.dropped);
    ours.dropped_intake = since(theirs.dropped_intake, before.dropped_intake);
    ours.gaps = since(theirs.gaps, before.gaps);
    ours.bad = since(theirs.bad, before.bad);
    ours.late = since(theirs.late, before.late);
  }
  return counters;
}

namespace {

void add_to(mcap::TopicCounters& sums, const mcap::TopicCounters& counters) {
  for (const auto& [topic, of] : counters) {
    StreamCounters& sum = sums[topic];
    for (const auto member : {&StreamCounters::received, &StreamCounters::dropped, &StreamCounters::gaps, &StreamCounters::bad,
                              &StreamCounters::late, &StreamCounters::dropped_intake, &StreamCounters::dropped_queue,
                              &StreamCounters::dropped_encoder, &StreamCounters::dropped_write}) {
      sum.*member += of.*member;
    }
    sum.recorded += of.recorded - of.repeated;
  }
}

}  // namespace

Result<void> Part::checkpoint(const CountsSnapshot& now, const mcap::TopicCounters& earlier) {
  const auto file = counters(now, true);
  auto session = earlier;
  add_to(session, file);
  auto record = number() > 1 ? mcap::to_metadata(file, session) : mcap::to_metadata(file);
  if (last_checkpoint_ && last_checkpoint_->metadata == record.metadata) return {};
  last_checkpoint_ = record;
  return session_.checkpoint(record);
}

FinishedPart Part::finish(const CountsSnapshot& end, mcap::TopicCounters& session) {
  Result<void> flushed = session_.flush();
  // The counters must say what the file has got, so it must have got it.
  if (flushed) flushed = out_->sync();
  if (!flushed) abandon();
  settle();
  out_->begin_closing();
  const auto file = counters(end, false);
  add_to(session, file);
  auto finished = session_.finish(number() > 1 ? mcap::to_metadata(file, session) : mcap::to_metadata(file));
  auto closed = out_->close();
  if (finished) finished = closed;
  settle();
  if (!flushed && finished) queue_.report(flushed.error());
  return {.path = path_,
          .session_id = head_.session_id,
          .part = head_.part,
          .bytes = written_bytes(),
          .seconds = to_seconds(age_at(last_log_time_)),
          .problem = finished ? "" : finished.error().message};
}

}  // namespace roseau::recorder
