#include "daemon/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "daemon/host_clock.h"

namespace roseau::daemon {

namespace {
constexpr double kQuiet_s = 1;
constexpr double kInterval_s = 0.1;
constexpr int kWidth = 32;

double now_s() { return to_seconds(host_now().time_since_epoch()); }
}  // namespace

Progress::Progress(std::string what) : what_(std::move(what)), shown_(isatty(STDERR_FILENO) == 1), begin_s_(now_s()) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::update(double share) {
  if (!shown_ || !std::isfinite(share)) return;
  const double time_s = now_s();
  if (time_s - begin_s_ < kQuiet_s || time_s - last_drawn_s_ < kInterval_s) return;
  last_drawn_s_ = time_s;
  drawn_ = true;
  share = std::clamp(share, 0.0, 1.0);
  const int filled = static_cast<int>(share * kWidth);
  const double left_s = share > 0 ? (time_s - begin_s_) * (1 - share) / share : 0;
  std::fputs(
      fmt::format("\r\033[K{} [{}{}] {:3.0f} %  {:.0f} s left", what_, std::string(static_cast<std::size_t>(filled), '='),
                  std::string(static_cast<std::size_t>(kWidth - filled), ' '), share * 100, left_s)
          .c_str(),
      stderr);
}

}  // namespace roseau::daemon
