#include "sync/intake.h"

#include <chrono>
#include <utility>

namespace roseau::sync {

namespace {
// Waits are bounded as well as notified: a missed wake-up costs this much, never a standstill.
constexpr std::chrono::milliseconds kConsumerWait{20};
constexpr std::chrono::milliseconds kProducerWait{5};
}  // namespace

Inlet::Inlet(Intake& intake, bool live, std::size_t capacity) : intake_(intake), live_(live), ring_(capacity) {}

bool Inlet::receive(Sample sample) {
  const StreamId stream = sample.header.stream;
  while (!ring_.try_push(sample)) {
    if (live_ || !wait_for_space()) {
      drop(stream, 1);
      return false;
    }
  }
  intake_.wake_consumer();
  return true;
}

void Inlet::drop(StreamId stream, std::uint64_t count) {
  StreamCounts& counts = intake_.counters_.of(stream);
  counts.dropped.fetch_add(count, std::memory_order_relaxed);
  counts.dropped_intake.fetch_add(count, std::memory_order_relaxed);
}

bool Inlet::wait_for_space() {
  if (intake_.closed_.load()) return false;
  std::unique_lock lock(intake_.mutex_);
  intake_.producers_wait_.fetch_add(1);
  intake_.space_ready_.wait_for(lock, kProducerWait);
  intake_.producers_wait_.fetch_sub(1);
  return !intake_.closed_.load();
}

void Inlet::request(Request request) {
  request_.store(request);
  std::unique_lock lock(intake_.mutex_);
  intake_.samples_ready_.notify_one();
  while (request_.load() != Request::none && !intake_.closed_.load()) intake_.space_ready_.wait_for(lock, kProducerWait);
}

void Inlet::flush() { request(Request::flush); }

void Inlet::restart(bool discard) { request(discard ? Request::discard_and_restart : Request::restart); }

void Inlet::finish() {
  finished_.store(true);
  intake_.wake_consumer();
}

Inlet& Intake::add_inlet(bool live, std::size_t capacity) { return inlets_.emplace_back(*this, live, capacity); }

void Intake::wake_consumer() {
  if (!consumer_waits_.load()) return;
  const std::scoped_lock lock(mutex_);
  samples_ready_.notify_one();
}

Intake::Merge Intake::look() {
  Merge merge;
  for (auto& inlet : inlets_) {
    // The order of these reads matters: a source pushes before it finishes or asks, so finished and then empty is final.
    const bool finished = inlet.finished_.load();
    const Inlet::Request request = inlet.request_.load();
    if (request == Inlet::Request::discard_and_restart) discard(inlet);
    if (!inlet.head_) inlet.head_ = inlet.ring_.try_pop();
    if (!inlet.head_) {
      if (request != Inlet::Request::none) merge.asking = &inlet;
      merge.all_done = merge.all_done && finished;
      merge.must_wait = merge.must_wait || (!inlet.live_ && !finished);
      continue;
    }
    merge.all_done = false;
    if (merge.earliest == nullptr || inlet.head_->header.arrival_time < merge.earliest->head_->header.arrival_time) {
      merge.earliest = &inlet;
    }
  }
  return merge;
}

void Intake::discard(Inlet& inlet) {
  inlet.head_.reset();
  while (inlet.ring_.try_pop()) {
  }
}

void Intake::carry_out(Inlet& inlet, const Callbacks& callbacks) {
  const Inlet::Request request = inlet.request_.load();
  if (request == Inlet::Request::flush) {
    callbacks.flush();
  } else {
    callbacks.restart(request == Inlet::Request::discard_and_restart);
  }
  inlet.request_.store(Inlet::Request::none);
  const std::scoped_lock lock(mutex_);
  space_ready_.notify_all();
}

void Intake::wait_for_samples() {
  std::unique_lock lock(mutex_);
  consumer_waits_.store(true);
  samples_ready_.wait_for(lock, kConsumerWait);
  consumer_waits_.store(false);
}

void Intake::run(const std::stop_token& stop, const Callbacks& callbacks) {
  while (!stop.stop_requested()) {
    const Merge merge = look();
    if (merge.asking != nullptr) {
      carry_out(*merge.asking, callbacks);
      continue;
    }
    if (merge.all_done) return;
    if (merge.earliest == nullptr || merge.must_wait) {
      callbacks.idle();
      wait_for_samples();
      continue;
    }
    callbacks.take(std::move(*merge.earliest->head_));
    merge.earliest->head_.reset();
    if (producers_wait_.load() > 0) {
      const std::scoped_lock lock(mutex_);
      space_ready_.notify_all();
    }
  }
}

void Intake::close() {
  closed_.store(true);
  const std::scoped_lock lock(mutex_);
  space_ready_.notify_all();
  samples_ready_.notify_all();
}

}  // namespace roseau::sync
