#include "structure/animation/frame_team.h"

#include <utility>

#include "core/check.h"

namespace roseau::structure {

namespace {

// Frames of a small forest last a tenth of a millisecond, less than a sleeping thread may take to wake: look for a while
// before sleeping. A forest that is drawn at 60 Hz sleeps nearly all of the time between frames.
constexpr int kLooks = 4000;

void relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

// Returns when the value is no longer `old`.
void wait_for_change(const std::atomic<std::uint32_t>& value, std::uint32_t old) {
  for (int i = 0; i < kLooks; ++i) {
    if (value.load(std::memory_order_acquire) != old) return;
    relax();
  }
  value.wait(old, std::memory_order_acquire);
}

}  // namespace

FrameTeam::FrameTeam(unsigned members, std::function<void(unsigned)> work) : work_(std::move(work)) {
  ROSEAU_CHECK(members >= 1);
  try {
    for (unsigned member = 1; member < members; ++member) {
      helpers_.emplace_back([this, member](const std::stop_token& stop) { help(stop, member); });
    }
  } catch (...) {  // no more threads to be had: those that run wait for a frame that never comes
    send_home();
    throw;
  }
}

FrameTeam::~FrameTeam() { send_home(); }

void FrameTeam::send_home() {
  for (auto& helper : helpers_) helper.request_stop();
  frame_.fetch_add(1, std::memory_order_release);
  frame_.notify_all();
}

void FrameTeam::run() {
  busy_.store(static_cast<std::uint32_t>(helpers_.size()), std::memory_order_relaxed);
  frame_.fetch_add(1, std::memory_order_release);
  frame_.notify_all();
  work_(0);
  for (std::uint32_t left = busy_.load(std::memory_order_acquire); left != 0;) {
    wait_for_change(busy_, left);
    left = busy_.load(std::memory_order_acquire);
  }
}

void FrameTeam::help(const std::stop_token& stop, unsigned member) {
  for (std::uint32_t seen = 0;;) {
    wait_for_change(frame_, seen);
    if (stop.stop_requested()) return;
    ++seen;
    work_(member);
    if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_.notify_one();
  }
}

}  // namespace roseau::structure
