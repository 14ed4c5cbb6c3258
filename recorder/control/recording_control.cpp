#include "recorder/control/recording_control.h"

#include <algorithm>
#include <utility>

#include "core/log.h"

namespace roseau::recorder {

namespace {

std::uint64_t bytes_in_buffers(const Sample& sample) {
  const auto* frame = std::get_if<Frame>(&sample.payload);
  return frame == nullptr ? 0 : frame->pixels.bytes().size() + frame->coded.size;
}

/// A trigger that results of the analysis set off lies a little behind the newest input: the past must reach that much further
/// back, or it would fall short by it.
PastOptions past_options(const ControlOptions& options) {
  PastOptions past = options.past;
  const Duration pre_trigger = options.policy.pre_trigger;
  past.length = pre_trigger > Duration{0} ? pre_trigger + options.policy.settling : Duration{0};
  return past;
}

}  // namespace

RecordingControl::RecordingControl(Recorder& recorder, ControlOptions options, ControlCallbacks callbacks)
    : recorder_(recorder),
      options_(options),
      callbacks_(std::move(callbacks)),
      policy_(options.policy),
      past_(past_options(options)),
      thread_([this] { work(); }) {}

RecordingControl::~RecordingControl() { static_cast<void>(finish().has_value()); }

bool RecordingControl::take(const Sample& sample, HostTime log_time) {
  const std::scoped_lock lock(mutex_);
  move_on(log_time);
  remember(sample, log_time);
  if (policy_.wants(log_time)) return is_direct_ ? recorder_.record(sample, log_time) : line_up(sample, log_time);
  // What comes behind the end of a recording may be the past of the next one.
  const auto ends_at = policy_.ends_at();
  if (!policy_.is_open() || (ends_at && log_time > *ends_at)) past_.keep(sample, log_time);
  return true;
}

void RecordingControl::tick(HostTime now) {
  const std::scoped_lock lock(mutex_);
  move_on(now);
}

void RecordingControl::move_on(HostTime now) {
  now_ = std::max(now_, now);
  if (policy_.is_over(now_)) add(CloseFile{});
}

bool RecordingControl::line_up(const Sample& sample, HostTime log_time) {
  Waiting waiting;
  if (auto copied = past_.copy(sample, log_time)) {
    waiting.kept = std::move(*copied);
  } else {
    waiting.kept = {sample, log_time, bytes_without_pixels(sample) + bytes_in_buffers(sample)};
    waiting.is_leased = true;
  }
  if (waiting_bytes_ + waiting.kept.bytes > options_.waiting_bytes) {
    lose(sample.header.stream);
    return false;
  }
  waiting_bytes_ += waiting.kept.bytes;
  add(std::move(waiting));
  return true;
}

void RecordingControl::lose(StreamId stream) {
  ++lost_;
  if (callbacks_.lost) callbacks_.lost(stream);
}

void RecordingControl::add(Step step) {
  if (std::holds_alternative<OpenFile>(step)) is_file_due_ = true;
  if (std::holds_alternative<CloseFile>(step)) is_file_due_ = false;
  is_direct_ = false;
  line_.push_back(std::move(step));
  work_ready_.notify_one();
}

Result<void> RecordingControl::may_begin() const {
  if (refusal_.empty()) return {};
  return Error{ErrorCode::busy, refusal_};
}

/// The past goes into the line: behind the file's opening, or behind what is recorded already.
void RecordingControl::began(bool is_new, HostTime at) {
  std::vector<KeptSample> past;
  while (auto kept = past_.take_oldest()) {
    if (policy_.wants(kept->log_time)) past.push_back(std::move(*kept));
  }
  if (is_new) {
    failure_.clear();
    if (is_file_due_) add(CloseFile{});  // of a recording that was stopped a moment ago
    add(OpenFile{policy_.cause(), ++recordings_});
    restate(past, at);
  }
  for (KeptSample& kept : past) wait_in_line(std::move(kept));
}

void RecordingControl::wait_in_line(KeptSample kept) {
  waiting_bytes_ += kept.bytes;
  add(Waiting{std::move(kept)});
}

void RecordingControl::remember(const Sample& sample, HostTime log_time) {
  const auto* action = std::get_if<OperatorAction>(&sample.payload);
  if (action == nullptr && sample.kind() != SampleKind::camera_calibration) return;
  using Kind = OperatorAction::Kind;
  if (action != nullptr && action->kind != Kind::add_target && action->kind != Kind::remove_target) return;
  // What is said anew or taken back is no longer in force.
  std::erase_if(context_, [&](const KeptSample& known) {
    const auto* target = std::get_if<OperatorAction>(&known.sample.payload);
    if (action == nullptr) return target == nullptr && known.sample.header.stream == sample.header.stream;
    return target != nullptr && target->text == action->text && (action->camera.empty() || target->camera == action->camera);
  });
  if (action == nullptr || action->kind == Kind::add_target) {
    context_.push_back({sample, log_time, bytes_without_pixels(sample)});
  }
}

/// With the times they had, a replay would begin with a long wait.
void RecordingControl::restate(const std::vector<KeptSample>& past, HostTime at) {
  const HostTime begin = past.empty() ? at : past.front().log_time;
  auto ahead = static_cast<std::int64_t>(context_.size());
  for (KeptSample restated : context_) {
    const bool is_there = std::ranges::any_of(past, [&](const KeptSample& kept) {
      return kept.log_time == restated.log_time && kept.sample.header.stream == restated.sample.header.stream;
    });
    if (is_there) continue;
    restated.log_time = begin - Duration{ahead--};
    restated.sample.header.arrival_time = restated.sample.header.sample_time = restated.log_time;
    wait_in_line(std::move(restated));
  }
}

Result<void> RecordingControl::start(HostTime at, const std::string& cause) {
  const std::scoped_lock lock(mutex_);
  move_on(at);
  if (auto may = may_begin(); !may) return may;
  began(policy_.start(at, cause), at);
  return {};
}

Result<void> RecordingControl::trigger(HostTime at, const std::string& name) {
  const std::scoped_lock lock(mutex_);
  move_on(at);
  if (auto may = may_begin(); !may) return may;
  began(policy_.trigger(at, name), at);
  return {};
}

Result<void> RecordingControl::begin_trigger(HostTime at, const std::string& name) {
  const std::scoped_lock lock(mutex_);
  move_on(at);
  if (auto may = may_begin(); !may) return may;
  began(policy_.begin_trigger(at, name), at);
  return {};
}

void RecordingControl::end_trigger(HostTime at, const std::string& name) {
  const std::scoped_lock lock(mutex_);
  move_on(at);
  policy_.end_trigger(at, name);
}

void RecordingControl::stop(HostTime at) {
  const std::scoped_lock lock(mutex_);
  move_on(at);
  policy_.stop(at);
}

void RecordingControl::end_here() {
  const std::scoped_lock lock(mutex_);
  if (policy_.is_open()) {
    policy_.abandon();
    add(CloseFile{});
  }
  now_ = HostTime::min();
}

void RecordingControl::refuse(const std::string& reason) {
  const std::scoped_lock lock(mutex_);
  refusal_ = reason;
}

void RecordingControl::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    work_ready_.wait(lock, [this] { return !line_.empty() || is_ending_; });
    if (line_.empty()) return;
    std::deque<Step> steps = std::exchange(line_, {});
    is_working_ = true;
    std::uint64_t done_bytes = 0;
    lock.unlock();
    while (!steps.empty()) {
      if (const auto* waiting = std::get_if<Waiting>(&steps.front())) done_bytes += waiting->kept.bytes;
      carry_out(steps.front());
      steps.pop_front();  // its pixels may be used again
    }
    lock.lock();
    is_working_ = false;
    waiting_bytes_ -= done_bytes;
    is_direct_ = line_.empty() && is_open_;
    if (line_.empty()) settled_.notify_all();
  }
}

void RecordingControl::carry_out(Step& step) {
  if (const auto* waiting = std::get_if<Waiting>(&step)) {
    if (is_open_) {  // what the recorder drops it counts itself
      recorder_.record_waiting(waiting->kept.sample, waiting->kept.log_time);
      return;
    }
    const std::scoped_lock lock(mutex_);
    lose(waiting->kept.sample.header.stream);
  } else if (const auto* open = std::get_if<OpenFile>(&step)) {
    opened_ = callbacks_.open(open->cause);
    is_open_ = opened_.has_value();
    if (is_open_) return;
    log("recorder")->error("{}", opened_.error().message);
    const std::scoped_lock lock(mutex_);
    failure_ = opened_.error().message;
    if (open->number == recordings_) policy_.abandon();
  } else if (std::exchange(is_open_, false)) {
    closed_ = recorder_.close();
    if (!closed_) log("recorder")->error("{}", closed_.error().message);
    if (callbacks_.closed) callbacks_.closed(closed_);
  }
}

Result<void> RecordingControl::settle() {
  std::unique_lock lock(mutex_);
  settled_.wait(lock, [this] { return line_.empty() && !is_working_; });
  return opened_;
}

Result<void> RecordingControl::finish() {
  {
    end_here();
    const std::scoped_lock lock(mutex_);
    is_ending_ = true;
    refusal_ = "the session has ended";
    work_ready_.notify_one();
  }
  if (thread_.joinable()) thread_.join();
  return opened_ ? closed_ : opened_;
}

ControlStatus RecordingControl::status() const {
  const std::scoped_lock lock(mutex_);
  ControlStatus status;
  status.phase = policy_.phase(now_);
  if (status.phase != RecordingPhase::idle) status.cause = policy_.cause();
  if (status.phase == RecordingPhase::post_trigger) status.ends_in = *policy_.ends_at() - now_;
  status.past_span = std::min(past_.span(), options_.policy.pre_trigger);
  status.past_bytes = past_.bytes();
  status.past_cut_off = past_.cut_off();
  status.lost = lost_;
  status.refusal = refusal_;
  status.failure = failure_;
  return status;
}

}  // namespace roseau::recorder
