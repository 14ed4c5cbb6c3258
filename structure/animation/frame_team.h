// FrameTeam: the caller's thread and its helpers, that work on one frame together, frame after frame.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace roseau::structure {

class FrameTeam {
 public:
  /// `work(member)` does one member's share of a frame; member 0 is the caller of run. It must not throw.
  FrameTeam(unsigned members, std::function<void(unsigned)> work);
  ~FrameTeam();
  FrameTeam(const FrameTeam&) = delete;
  FrameTeam& operator=(const FrameTeam&) = delete;

  unsigned size() const { return static_cast<unsigned>(helpers_.size()) + 1; }

  /// Runs every member once and returns when all are through. One caller at a time. Allocates nothing.
  void run();

 private:
  void send_home();
  void help(const std::stop_token& stop, unsigned member);

  std::function<void(unsigned)> work_;
  std::atomic<std::uint32_t> frame_ = 0;
  std::atomic<std::uint32_t> busy_ = 0;
  std::vector<std::jthread> helpers_;
};

}  // namespace roseau::structure
