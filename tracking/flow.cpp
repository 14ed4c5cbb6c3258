#include "tracking/flow.h"

#include <algorithm>
#include <opencv2/video/tracking.hpp>

namespace roseau::tracking {

namespace {
// The way back starts where the point came from, so two levels tell whether it leads there: a third of the cost of the way
// there. Of points that are nowhere in the other picture a fifth passes (a tenth would with all levels, a quarter with one);
// the reference patches turn those down.
constexpr int kBackwardLevels = 1;
constexpr double kBackwardConverged = 0.03;  // px
}  // namespace

void Flow::advance(const cv::Mat& gray) {
  have_previous_ = have_current_;
  current_ = 1 - current_;
  const cv::Size window(options_.window_px, options_.window_px);
  current_levels_ = cv::buildOpticalFlowPyramid(gray, pyramids_[current_], window, options_.pyramid_levels, true);
  have_current_ = true;
}

const cv::Mat& Flow::current(int level) const {
  return pyramids_[current_][2 * static_cast<std::size_t>(std::min(level, current_levels_))];
}

void Flow::follow(std::vector<FlowPoint>& points) {
  for (FlowPoint& point : points) {
    point.to = point.guess;
    point.followed = false;
  }
  if (!have_previous_ || points.empty()) return;

  from_.clear();
  to_.clear();
  for (const FlowPoint& point : points) {
    from_.push_back(point.from);
    to_.push_back(point.guess);
  }
  back_ = from_;
  const cv::Size window(options_.window_px, options_.window_px);
  const cv::TermCriteria forward(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, options_.flow_iterations,
                                 options_.flow_converged_px);
  const cv::TermCriteria backward(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, options_.flow_iterations,
                                  kBackwardConverged);
  const auto& previous = pyramids_[1 - current_];
  const auto& current = pyramids_[current_];
  cv::calcOpticalFlowPyrLK(previous, current, from_, to_, found_, cv::noArray(), window, current_levels_, forward,
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  cv::calcOpticalFlowPyrLK(current, previous, to_, back_, found_back_, cv::noArray(), window,
                           std::min(kBackwardLevels, current_levels_), backward, cv::OPTFLOW_USE_INITIAL_FLOW);
  const double most2 = options_.forward_backward_px * options_.forward_backward_px;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Point2f miss = back_[i] - from_[i];
    points[i].to = to_[i];
    points[i].followed = found_[i] != 0 && found_back_[i] != 0 && miss.dot(miss) <= most2;
  }
}

}  // namespace roseau::tracking
