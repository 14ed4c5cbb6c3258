// Flow: where points of the previous picture are in this one, by pyramidal Lucas-Kanade (OpenCV) with a forward-backward
// check (Kalal, Mikolajczyk, Matas 2010). Pyramids are kept, so that each picture's is built once.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "tracking/options.h"

namespace roseau::tracking {

struct FlowPoint {
  cv::Point2f from;       // in the previous picture, px (origin at a pixel's centre)
  cv::Point2f guess;      // where it is expected in this one
  cv::Point2f to;         // where it was found
  bool followed = false;  // found, and found again backwards
};

class Flow {
 public:
  explicit Flow(const TrackerOptions& options) : options_(options) {}

  /// Makes `gray` the current picture and what was current the previous one.
  void advance(const cv::Mat& gray);
  /// Forgets the previous picture: the next advance() starts anew.
  void restart() { have_current_ = have_previous_ = false; }
  bool has_current() const { return have_current_; }
  bool has_previous() const { return have_previous_; }

  /// Fills `to` and `followed`. Without a previous picture nothing is followed.
  void follow(std::vector<FlowPoint>& points);

  /// Grey picture of the current frame at half resolution to the power `level`; level 0 is the frame itself.
  const cv::Mat& current(int level = 0) const;
  int levels() const { return current_levels_; }

 private:
  TrackerOptions options_;
  std::array<std::vector<cv::Mat>, 2> pyramids_;  // per level: picture, gradient
  std::size_t current_ = 0;
  int current_levels_ = 0;
  bool have_current_ = false;
  bool have_previous_ = false;
  std::vector<cv::Point2f> from_;
  std::vector<cv::Point2f> to_;
  std::vector<cv::Point2f> back_;
  std::vector<unsigned char> found_;
  std::vector<unsigned char> found_back_;
};

}  // namespace roseau::tracking
