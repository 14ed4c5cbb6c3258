#include "recorder/finisher.h"

#include <exception>
#include <utility>

#include "core/log.h"

namespace roseau::recorder {

void Finisher::add(std::unique_ptr<Part> part, CountsSnapshot end) {
  std::size_t open = 0;
  {
    const std::scoped_lock lock(mutex_);
    work_.push_back({std::move(part), std::move(end)});
    open = work_.size();
  }
  queue_.set_parts_finishing(static_cast<std::uint32_t>(open));
  changed_.notify_all();
  if (!thread_.joinable()) thread_ = std::jthread([this] { run(); });
}

void Finisher::run() {
  while (true) {
    Work* work = nullptr;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return ending_ || !work_.empty(); });
      if (work_.empty()) return;
      work = &work_.front();  // stays where it is: a deque's front does not move when more is added
    }
    finish(*work->part, work->end, false);
    std::size_t open = 0;
    {
      const std::scoped_lock lock(mutex_);
      work_.pop_front();
      open = work_.size();
    }
    queue_.set_parts_finishing(static_cast<std::uint32_t>(open));
  }
}

/// One part at a time: by the thread, or after it has ended.
FinishedPart Finisher::finish(Part& part, const CountsSnapshot& end, bool last) {
  auto session = session_counters();
  FinishedPart finished = part.finish(end, session);
  finished.last = last;
  {
    const std::scoped_lock lock(mutex_);
    session_ = std::move(session);
    session_bytes_ += finished.bytes;
  }
  if (!finished.problem.empty()) {
    const Error error{ErrorCode::io, finished.path.string() + " was not closed properly: " + finished.problem +
                                         ". It reads up to its last whole chunk"};
    log("recorder")->error("{}", error.message);
    if (!last) queue_.report(error);
  }
  if (!finished_) return finished;
  try {
    finished_(finished);
  } catch (const std::exception& exception) {
    log("recorder")->error("{}: after it was finished: {}", finished.path.string(), exception.what());
  }
  return finished;
}

FinishedPart Finisher::finish_last(Part& part, const CountsSnapshot& end) {
  drain();
  return finish(part, end, true);
}

void Finisher::drain() {
  if (!thread_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

mcap::TopicCounters Finisher::session_counters() const {
  const std::scoped_lock lock(mutex_);
  return session_;
}

std::uint64_t Finisher::session_bytes() const {
  const std::scoped_lock lock(mutex_);
  return session_bytes_;
}

}  // namespace roseau::recorder
