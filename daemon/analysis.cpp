#include "daemon/analysis.h"

#include <algorithm>
#include <utility>

#include "daemon/cpu_time.h"

namespace roseau::daemon {

namespace {

double thread_cpu_seconds() { return cpu_seconds_of(CLOCK_THREAD_CPUTIME_ID); }

struct Collector : SampleSink {
  explicit Collector(std::vector<Sample>& into) : samples(into) {}
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  std::vector<Sample>& samples;
};

}  // namespace

Analysis::Analysis(const StreamTable& streams, std::vector<Tracker> trackers, std::unique_ptr<Stage> estimation, Output output,
                   std::size_t capacity)
    : streams_(streams), estimation_(std::move(estimation)), output_(std::move(output)), slots_(capacity) {
  for (auto& tracker : trackers) {
    workers_.push_back(std::make_unique<Worker>());
    workers_.back()->tracker = std::move(tracker);
  }
  for (auto& slot : slots_) slot.derived.resize(workers_.size());
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    workers_[i]->thread = std::jthread([this, i](const std::stop_token& stop) { work(i, stop); });
  }
  join_thread_ = std::jthread([this](const std::stop_token& stop) { join(stop); });
}

Analysis::~Analysis() { finish(); }

bool Analysis::concerns(const Worker& worker, const Sample& sample) const {
  return sample.kind() == SampleKind::operator_action || streams_.info(sample.header.stream).device == worker.tracker.device;
}

void Analysis::submit(Sample&& sample, HostTime log_time) {
  std::unique_lock lock(mutex_);
  space_.wait(lock, [this] { return submitted_ - joined_ < slots_.size(); });
  const std::size_t number = submitted_++;
  Slot& next = slot(number);
  next.sample = std::move(sample);
  next.log_time = log_time;
  next.pending = 0;
  for (auto& worker : workers_) {
    if (!concerns(*worker, next.sample)) continue;
    ++next.pending;
    worker->todo.push_back(number);
    if (next.sample.kind() == SampleKind::frame) ++worker->frames;
  }
  if (next.pending > 0) {
    work_ready_.notify_all();
  } else {
    slot_done_.notify_one();
  }
}

std::size_t Analysis::frames_waiting(const std::string& device) const {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find_if(workers_, [&device](const auto& worker) { return worker->tracker.device == device; });
  return found == workers_.end() ? 0 : (*found)->frames;
}

void Analysis::work(std::size_t index, const std::stop_token& stop) {
  Worker& worker = *workers_[index];
  std::unique_lock lock(mutex_);
  while (work_ready_.wait(lock, stop, [&worker] { return !worker.todo.empty(); })) {
    const std::size_t number = worker.todo.front();
    worker.todo.pop_front();
    Slot& mine = slot(number);
    // Only this worker writes derived[index], and the slot is not reused before pending is 0: no lock while tracking.
    lock.unlock();
    Collector collector(mine.derived[index]);
    if (!abandoned_) worker.tracker.stage->process(mine.sample, collector);
    const double cpu_s = thread_cpu_seconds();
    lock.lock();
    worker.cpu_s = cpu_s;
    if (mine.sample.kind() == SampleKind::frame) --worker.frames;
    if (--mine.pending == 0) slot_done_.notify_one();
  }
}

void Analysis::join(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (slot_done_.wait(lock, stop, [this] { return joined_ < submitted_ && slot(joined_).pending == 0; })) {
    Slot& done = slot(joined_);
    lock.unlock();
    if (!abandoned_) emit(done);
    done.sample = Sample{};  // lets go of the frame
    for (auto& derived : done.derived) derived.clear();
    lock.lock();
    ++joined_;
    space_.notify_all();
  }
}

void Analysis::emit(Slot& slot) {
  emit_one(slot.sample, slot.log_time);
  for (const auto& derived : slot.derived) {
    for (const auto& sample : derived) emit_one(sample, slot.log_time);
  }
}

/// Puts the sample out and through estimation, then what estimation made of it.
void Analysis::emit_one(const Sample& sample, HostTime log_time) {
  output_(sample, log_time);
  std::vector<Sample> estimates;
  Collector collector(estimates);
  const double begin_s = thread_cpu_seconds();
  estimation_->process(sample, collector);
  const double estimated_s = thread_cpu_seconds();
  for (const auto& estimate : estimates) output_(estimate, log_time);
  const double end_s = thread_cpu_seconds();
  const std::scoped_lock lock(mutex_);
  estimation_cpu_s_ += estimated_s - begin_s;
  output_cpu_s_ += end_s - estimated_s;
}

void Analysis::finish() {
  {
    std::unique_lock lock(mutex_);
    space_.wait(lock, [this] { return joined_ == submitted_; });
  }
  for (auto& worker : workers_) {
    worker->thread.request_stop();
    if (worker->thread.joinable()) worker->thread.join();
  }
  join_thread_.request_stop();
  if (join_thread_.joinable()) join_thread_.join();
}

void Analysis::abandon() {
  abandoned_ = true;
  finish();
}

std::vector<std::pair<std::string, double>> Analysis::cpu_seconds() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::pair<std::string, double>> used;
  for (const auto& worker : workers_) used.emplace_back("tracking/" + worker->tracker.device, worker->cpu_s);
  used.emplace_back("estimation", estimation_cpu_s_);
  used.emplace_back("output", output_cpu_s_);
  return used;
}

}  // namespace roseau::daemon
