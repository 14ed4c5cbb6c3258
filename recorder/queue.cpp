#include "recorder/queue.h"

#include <time.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <thread>

#include "core/check.h"

namespace roseau::recorder {

namespace {

/// How long the writer sleeps while nothing is urgent. It looks by itself: to be woken would cost the capture's thread a system
/// call, and on a busy machine often the processor.
constexpr auto kNap = std::chrono::milliseconds(4);
constexpr std::uint64_t kBudgetPerSlot = 8U << 10U;  // 32768 slots for 256 MiB: many seconds of small samples
constexpr std::uint64_t kLeastSlots = 1024;
constexpr std::uint64_t kMostSlots = 32768;
constexpr std::size_t kMostPerPop = 1024;  // so that the writer looks at the clock between

/// What a sample holds, roughly: pixels and long payloads count, the rest is its own size.
std::uint64_t bytes_of(const Sample& sample) {
  std::uint64_t bytes = sizeof(QueuedSample);
  if (const auto* frame = std::get_if<Frame>(&sample.payload)) {
    bytes += frame->coded ? frame->coded.size : frame->bytes().size();
  }
  if (const auto* motion = std::get_if<ImageMotion>(&sample.payload))
    bytes += motion->points.size() * sizeof(ImageMotion::Point);
  if (const auto* spectrum = std::get_if<ForceSpectrum>(&sample.payload)) {
    bytes += 5 * sizeof(float) * spectrum->frequency_hz.size();
  }
  return bytes;
}

void add(std::atomic<std::uint64_t>& counter, std::uint64_t count) { counter.fetch_add(count, std::memory_order_relaxed); }

/// While one exists, begin_closing() waits: what its owner does is done before the writer's last look.
class Inside {
 public:
  explicit Inside(std::atomic<int>& callers) : callers_(callers) { ++callers_; }
  ~Inside() { --callers_; }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

 private:
  std::atomic<int>& callers_;
};

}  // namespace

Queue::Queue(std::uint64_t budget_bytes)
    : budget_bytes_(budget_bytes),
      slot_count_(std::bit_ceil(std::clamp(budget_bytes / kBudgetPerSlot, kLeastSlots, kMostSlots))) {
  ROSEAU_CHECK(::sem_init(&work_ready_, 0, 0) == 0);
}

Queue::~Queue() {
  ::sem_destroy(&work_ready_);
  for (auto& block : counts_) delete block.load();
}

void Queue::begin(const std::string& path, const std::string& session_id, std::uint32_t part) {
  ROSEAU_CHECK(!taking_ && callers_inside_ == 0);
  if (!slots_) slots_ = std::make_unique<Slot[]>(slot_count_);
  for (std::size_t i = 0; i < slot_count_; ++i) slots_[i].turn = i;
  tail_ = 0;
  head_ = 0;
  held_bytes_ = 0;
  write_failed_ = false;
  closing_ = false;
  was_full_ = false;
  for (auto& block : counts_) delete block.exchange(nullptr);
  {
    const std::scoped_lock lock(state_mutex_);
    first_error_.reset();
    state_ = {.recording = true, .state = DeviceState::running, .path = path, .session_id = session_id, .part = part};
  }
  taking_ = true;
}

/// Allocates at a stream's first sample only (or a neighbour's).
Queue::AtomicCounts& Queue::counts_of(StreamId stream) {
  auto& block = counts_[stream / kStreamsPerBlock];
  CountsBlock* known = block.load(std::memory_order_acquire);
  if (known == nullptr) {
    auto mine = std::make_unique<CountsBlock>();
    if (block.compare_exchange_strong(known, mine.get())) known = mine.release();
  }
  return (*known)[stream % kStreamsPerBlock];
}

// ---------------------------------------------------------------------------------------------------------------------
// Callers' side

bool Queue::push(const Sample& sample, HostTime log_time, bool wait_when_full) {
  const Inside inside(callers_inside_);
  if (!taking_) return true;
  AtomicCounts& counts = counts_of(sample.header.stream);
  add(counts.received, 1);
  if (write_failed_) {
    add(counts.refused, 1);
    return false;
  }
  const std::uint64_t bytes = bytes_of(sample);
  std::uint64_t position = 0;
  Slot* slot = enter(bytes, position);
  if (slot == nullptr && wait_when_full) slot = wait_to_enter(bytes, position);
  if (slot == nullptr) return refuse(sample.header.stream);

  slot->value.sample = sample;
  if (auto* frame = std::get_if<Frame>(&slot->value.sample.payload); frame != nullptr && frame->coded) {
    frame->pixels = {};  // only the stored form is needed from here on: the camera gets its buffer back
  }
  slot->value.log_time = log_time;
  slot->value.bytes = bytes;
  slot->value.position = position;
  slot->turn = position + 1;
  if (held_bytes_.load(std::memory_order_relaxed) > budget_bytes_ / 4) wake_writer();
  return true;
}

/// One sample is always let in, however large, or it could never be recorded.
bool Queue::reserve(std::uint64_t bytes) {
  std::uint64_t held = held_bytes_;
  do {
    if (held != 0 && held + bytes > budget_bytes_) return false;
  } while (!held_bytes_.compare_exchange_weak(held, held + bytes));
  return true;
}

/// Null: every slot is in use.
Queue::Slot* Queue::claim(std::uint64_t& position) {
  position = tail_;
  while (true) {
    Slot& slot = slots_[position % slot_count_];
    const std::uint64_t turn = slot.turn.load(std::memory_order_acquire);
    if (turn == position) {
      if (tail_.compare_exchange_weak(position, position + 1)) return &slot;
    } else if (turn < position) {
      return nullptr;
    } else {
      position = tail_;
    }
  }
}

Queue::Slot* Queue::enter(std::uint64_t bytes, std::uint64_t& position) {
  if (!reserve(bytes)) return nullptr;
  Slot* slot = claim(position);
  if (slot == nullptr) held_bytes_ -= bytes;
  return slot;
}

Queue::Slot* Queue::wait_to_enter(std::uint64_t bytes, std::uint64_t& position) {
  Slot* slot = nullptr;
  ++waiting_callers_;
  wake_writer();
  {
    std::unique_lock lock(space_mutex_);
    space_ready_.wait(lock, [&] {
      if (write_failed_ || !taking_) return true;
      slot = enter(bytes, position);
      return slot != nullptr;
    });
  }
  --waiting_callers_;
  return slot;
}

/// Always false: what push returns.
bool Queue::refuse(StreamId stream) {
  AtomicCounts& counts = counts_of(stream);
  if (write_failed_) {
    add(counts.refused, 1);
    return false;
  }
  add(counts.dropped_queue, 1);
  if (was_full_.exchange(true)) return false;
  report({ErrorCode::busy,
          "the disk is too slow for what is recorded: samples were dropped (counted per stream). Record to a faster disk, or "
          "record fewer, smaller or slower pictures"});
  return false;
}

void Queue::wake_writer() {
  if (writer_waits_.load() && writer_waits_.exchange(false)) ::sem_post(&work_ready_);
}

// ---------------------------------------------------------------------------------------------------------------------
// Writer's side

bool Queue::has_filled_slot() const { return slots_[head_ % slot_count_].turn.load() == head_ + 1; }

bool Queue::pop(std::vector<QueuedSample>& batch, std::chrono::steady_clock::time_point deadline) {
  batch.clear();
  if (!has_filled_slot() && !closing_ && !callers_wait()) {
    // First said, then looked again: a caller either sees that we wait, or we see its sample.
    writer_waits_ = true;
    if (!has_filled_slot() && !closing_ && !callers_wait()) {
      const auto nap_end = std::chrono::time_point_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() + kNap);
      const auto since_epoch = std::min(deadline, nap_end).time_since_epoch();
      const auto seconds = std::chrono::floor<std::chrono::seconds>(since_epoch);
      const timespec until{seconds.count(), std::chrono::nanoseconds(since_epoch - seconds).count()};
      while (::sem_clockwait(&work_ready_, CLOCK_MONOTONIC, &until) != 0 && errno == EINTR) {
      }
    }
    writer_waits_ = false;
  }
  const bool last = closing_;  // before looking: nothing is added after it was set
  while (batch.size() < kMostPerPop && has_filled_slot()) {
    Slot& slot = slots_[head_ % slot_count_];
    batch.push_back(std::move(slot.value));
    add(counts_of(batch.back().sample.header.stream).taken, 1);
    slot.turn.store(head_ + slot_count_, std::memory_order_release);
    ++head_;
  }
  if (!batch.empty() && callers_wait()) give_space_back(0);  // slots
  return !last || has_filled_slot();
}

void Queue::begin_closing() {
  taking_ = false;
  {
    const std::scoped_lock lock(space_mutex_);  // whoever waits has either not looked yet, or hears it
    space_ready_.notify_all();
  }
  while (callers_inside_ != 0) std::this_thread::yield();
  {
    const std::scoped_lock lock(state_mutex_);
    state_.recording = false;
  }
  closing_ = true;
  wake_writer();
}

void Queue::give_space_back(std::uint64_t bytes) {
  held_bytes_ -= bytes;
  if (!callers_wait()) return;
  const std::scoped_lock lock(space_mutex_);
  space_ready_.notify_all();
}

void Queue::settle(const Written& written) {
  for (const auto& [stream, count] : written.samples) add(counts_of(stream).recorded, count);
  for (const auto& [stream, count] : written.lost) add(counts_of(stream).dropped_write, count);
  for (const auto& [stream, count] : written.lost_in_encoder) add(counts_of(stream).dropped_encoder, count);
  if (written.budget_bytes != 0) give_space_back(written.budget_bytes);
}

void Queue::count_own(StreamId stream) {
  AtomicCounts& counts = counts_of(stream);
  add(counts.received, 1);
  add(counts.taken, 1);
}

// ---------------------------------------------------------------------------------------------------------------------
// State

void Queue::fail(const Error& error) {
  write_failed_ = true;
  give_space_back(0);
  const std::scoped_lock lock(state_mutex_);
  state_.state = DeviceState::degraded;
  state_.message =
      error.message + ". Recording has stopped; what was recorded before is safe. Stop and start recording to go on";
  if (!first_error_ || first_error_->code == ErrorCode::busy) first_error_ = error;  // worse than being slow
}

void Queue::report(const Error& error) {
  const std::scoped_lock lock(state_mutex_);
  if (first_error_) return;
  first_error_ = error;
  state_.state = DeviceState::degraded;
  state_.message = error.message;
}

void Queue::end(DeviceState state, const std::string& message) {
  const std::scoped_lock lock(state_mutex_);
  state_.state = state;
  state_.message = message;
}

void Queue::set_disk_free(std::uint64_t bytes) {
  const std::scoped_lock lock(state_mutex_);
  state_.disk_free_bytes = bytes;
}

void Queue::set_bytes(std::uint64_t file, std::uint64_t session) {
  const std::scoped_lock lock(state_mutex_);
  state_.bytes = file;
  state_.session_bytes = session;
}

void Queue::set_seconds(double seconds) {
  const std::scoped_lock lock(state_mutex_);
  state_.seconds = seconds;
}

void Queue::set_part(const std::string& path, std::uint32_t part) {
  const std::scoped_lock lock(state_mutex_);
  state_.path = path;
  state_.part = part;
}

void Queue::set_parts_finishing(std::uint32_t count) {
  const std::scoped_lock lock(state_mutex_);
  state_.parts_finishing = count;
}

/// Shown as long as nothing worse is.
void Queue::set_split_problem(const std::string& problem) {
  const std::scoped_lock lock(state_mutex_);
  state_.split_problem = problem;
  if (first_error_) return;
  state_.state = problem.empty() ? DeviceState::running : DeviceState::degraded;
  state_.message = problem;
}

std::optional<Error> Queue::first_error() const {
  const std::scoped_lock lock(state_mutex_);
  return first_error_;
}

std::vector<StageCounts> Queue::counts() const {
  std::vector<StageCounts> all;
  for (std::size_t block = 0; block < kBlocks; ++block) {
    const CountsBlock* known = counts_[block].load(std::memory_order_acquire);
    if (known == nullptr) continue;
    all.resize((block + 1) * kStreamsPerBlock);
    for (std::size_t i = 0; i < kStreamsPerBlock; ++i) {
      const AtomicCounts& of = (*known)[i];
      // What follows from the others is read first, so that no sample is seen to have come out that was not seen going in.
      StageCounts& counts = all[block * kStreamsPerBlock + i];
      counts.recorded = of.recorded;
      counts.dropped_write = of.dropped_write;
      counts.dropped_encoder = of.dropped_encoder;
      counts.taken = of.taken;
      counts.dropped_queue = of.dropped_queue;
      counts.refused = of.refused;
      counts.received = of.received;
    }
  }
  return all;
}

RecorderState Queue::state(const StreamTable& streams) const {
  RecorderState state;
  {
    const std::scoped_lock lock(state_mutex_);
    state = state_;
  }
  const auto all = counts();
  for (std::size_t stream = 0; stream < all.size(); ++stream) {
    const StageCounts& of = all[stream];
    if (of.received == 0 && of.recorded == 0) continue;
    state.streams[streams.info(static_cast<StreamId>(stream)).topic] = {.received = of.received,
                                                                        .recorded = of.recorded,
                                                                        .dropped = of.dropped(),
                                                                        .dropped_queue = of.dropped_queue,
                                                                        .dropped_encoder = of.dropped_encoder,
                                                                        .dropped_write = of.dropped_write + of.refused};
  }
  return state;
}

}  // namespace roseau::recorder
