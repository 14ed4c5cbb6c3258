// A progress line on a terminal; silent where standard error is not one.
#pragma once

#include <string>

namespace roseau::daemon {

class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `share`: 0 to 1 done. Draws at most ten times a second, and only from the second second on.
  void update(double share);

 private:
  const std::string what_;
  const bool shown_;
  double begin_s_;
  double last_drawn_s_ = 0;
  bool drawn_ = false;
};

}  // namespace roseau::daemon
