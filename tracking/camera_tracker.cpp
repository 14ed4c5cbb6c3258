#include "tracking/camera_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace roseau::tracking {

namespace {

constexpr std::uint16_t kUnusable = kStatusIncomplete | kStatusMalformed | kStatusDeviceError;
constexpr std::uint32_t kRetryEvery = 30;  // frames: what found too little texture (a cap on the lens) is tried again

// The project's pixel coordinates begin at the upper left corner of the upper left pixel, tracking's at its centre.
constexpr double kCorner = 0.5;

ImageRect moved(const ImageRect& rect, double by) { return {rect.x + by, rect.y + by, rect.width, rect.height}; }

}  // namespace

CameraTracker::CameraTracker(StreamTable& streams, std::string camera, TrackerOptions options)
    : streams_(streams), camera_(std::move(camera)), options_(std::move(options)), flow_(options_) {
  ROSEAU_CHECK(validate(options_).has_value());
  motion_output_.stream = streams_.add({.topic = fmt::format("/{}/motion", camera_),
                                        .kind = std::string(to_string(SampleKind::image_motion)),
                                        .role = StreamRole::derived,
                                        .device = camera_});
  for (const TargetRegion& target : options_.targets) output_of(target.name);
  restart();
}

void CameraTracker::restart() {
  flow_.restart();
  converter_ = GrayConverter(options_.mono16_significant_bits);
  background_.reset();
  targets_.clear();
  automatic_.reset();
  pending_.clear();
  for (const TargetRegion& target : options_.targets) pending_.push_back({target.name, moved(target.region, -kCorner)});
  if (pending_.empty() && options_.automatic_targets) automatic_.emplace(options_);
  frames_ = 0;
}

CameraTracker::Output& CameraTracker::output_of(const std::string& target) {
  const auto [found, is_new] = outputs_.try_emplace(target);
  if (is_new) {
    found->second.stream = streams_.add({.topic = fmt::format("/{}/target/{}/displacement", camera_, target),
                                         .kind = std::string(to_string(SampleKind::displacement)),
                                         .role = StreamRole::derived,
                                         .device = camera_});
  }
  return found->second;
}

void CameraTracker::observe_work(WorkObserver* observer) {
  observer_ = observer;
  if (background_) background_->observe_work(observer);
  for (RegionTracker& target : targets_) target.observe_work(observer);
}

void CameraTracker::process(const Sample& input, SampleSink& out) {
  if (const auto* action = std::get_if<OperatorAction>(&input.payload)) {
    obey(*action);
  } else if (const auto* frame = std::get_if<Frame>(&input.payload); frame != nullptr && is_mine(input)) {
    process_frame(input.header, *frame, out);
  }
}

bool CameraTracker::is_mine(const Sample& frame) {
  if (!image_stream_) image_stream_ = streams_.find(fmt::format("/{}/image", camera_));
  return image_stream_ && frame.header.stream == *image_stream_;
}

void CameraTracker::obey(const OperatorAction& action) {
  if (action.camera != camera_) return;
  if (action.kind == OperatorAction::Kind::add_target) {
    add_target({action.text, action.region});
  } else if (action.kind == OperatorAction::Kind::remove_target) {
    remove_target(action.text);
  }
}

void CameraTracker::add_target(const TargetRegion& target) {
  TrackerOptions asked;
  asked.targets = {target};
  if (const auto good = validate(asked); !good) {
    log("tracking")->warn("{}: not added: {}", camera_, good.error().message);
    return;
  }
  remove_target(target.name);
  if (targets_.size() + pending_.size() >= kMostTargets) {
    log("tracking")->warn("{}: target \"{}\" not added: there are {} already, remove one", camera_, target.name, kMostTargets);
    return;
  }
  automatic_.reset();
  output_of(target.name);
  pending_.push_back({target.name, moved(target.region, -kCorner)});
}

void CameraTracker::remove_target(const std::string& name) {
  std::erase_if(targets_, [&](const RegionTracker& target) { return target.name() == name; });
  std::erase_if(pending_, [&](const TargetRegion& target) { return target.name == name; });
}

void CameraTracker::process_frame(const SampleHeader& header, const Frame& frame, SampleSink& out) {
  if (last_time_ && header.sample_time <= *last_time_) return;
  last_time_ = header.sample_time;
  bool usable = (header.status & kUnusable) == 0;
  try {
    usable = usable && analyse(header, frame);
  } catch (const cv::Exception& error) {
    complain(header, fmt::format("OpenCV: {}; tracking starts anew", error.what()));
    restart();
    usable = false;
  }
  enters(Work::output);
  emit(header, usable, out);
}

void CameraTracker::complain(const SampleHeader& header, const std::string& message) {
  if (!complaints_.allow(to_ns(header.arrival_time))) return;
  log("tracking")->warn("{}: {} ({} like this before)", camera_, message, complaints_.suppressed());
}

bool CameraTracker::analyse(const SampleHeader& header, const Frame& frame) {
  enters(Work::gray);
  const Result<cv::Mat> gray = converter_.convert(frame, gray_storage_);
  if (!gray) {
    complain(header, gray.error().message);
    return false;
  }
  if (flow_.has_current() && flow_.current().size() != gray->size()) {
    log("tracking")
        ->warn("{}: frames are {}x{} now: tracking starts anew with the configured targets", camera_, frame.width,
               frame.height);
    restart();
    if (const Result<cv::Mat> again = converter_.convert(frame, gray_storage_); !again) return false;
  }
  enters(Work::pyramid);
  flow_.advance(*gray);
  if (flow_.has_previous()) follow();
  enters(Work::renewal);
  start_pending();
  if (frames_ % kRetryEvery == 0) retry_failed_starts();
  choose_automatically();
  ++frames_;
  return true;
}

void CameraTracker::follow() {
  enters(Work::flow);
  points_.clear();
  if (background_) background_->collect(points_);
  std::size_t first = points_.size();
  const std::size_t of_background = first;
  std::vector<std::size_t> counts;
  for (const RegionTracker& target : targets_) {
    target.collect(points_);
    counts.push_back(points_.size() - first);
    first = points_.size();
  }
  flow_.follow(points_);

  const std::span<const FlowPoint> all(points_);
  if (background_) background_->update(all.first(of_background), flow_, CameraMotion{});
  const CameraMotion camera = camera_motion();
  first = of_background;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    targets_[i].update(all.subspan(first, counts[i]), flow_, camera);
    first += counts[i];
  }
  if (background_) background_->replenish(flow_, target_regions());
  for (RegionTracker& target : targets_) target.replenish(flow_, {});
}

CameraMotion CameraTracker::camera_motion() const {
  if (!options_.subtract_background || !background_ || !background_->started()) return {};
  return {background_->placement().centre, background_->placement().motion, background_->covariance()};
}

std::vector<ImageRect> CameraTracker::target_regions() const {
  std::vector<ImageRect> regions;
  for (const RegionTracker& target : targets_) regions.push_back(target.region_now());
  for (const TargetRegion& target : pending_) regions.push_back(target.region);
  return regions;
}

/// What the targets have no use for is the background's.
int CameraTracker::background_share() const {
  int left = options_.feature_count;
  for (const RegionTracker& target : targets_) left -= target.wanted();
  const double least = targets_.empty() ? 0 : options_.feature_count * options_.background_share;
  return std::max(left, static_cast<int>(std::lround(least)));
}

int CameraTracker::target_share() const {
  const auto targets = static_cast<double>(std::max<std::size_t>(1, targets_.size() + pending_.size()));
  return std::max(1, static_cast<int>(options_.feature_count * (1 - options_.background_share) / targets));
}

void CameraTracker::start_background() {
  const ImageRect everywhere{0, 0, static_cast<double>(flow_.current().cols), static_cast<double>(flow_.current().rows)};
  background_.emplace(options_, "background", RegionKind::background);
  background_->observe_work(observer_);
  background_->start(flow_, everywhere, background_share(), target_regions(), {});
}

void CameraTracker::retry_failed_starts() {
  if (!background_ || !background_->started()) start_background();
  for (RegionTracker& target : targets_) {
    if (target.started()) continue;
    target.start(flow_, target.region_now(), target_share(), {}, camera_motion());
  }
}

void CameraTracker::start_pending() {
  if (pending_.empty()) return;
  const int share = target_share();
  for (RegionTracker& target : targets_) target.limit(share);
  for (const TargetRegion& wanted : pending_) {
    if (background_) background_->drop_inside(wanted.region);
    RegionTracker& target = targets_.emplace_back(options_, wanted.name, RegionKind::target);
    target.observe_work(observer_);
    if (!target.start(flow_, wanted.region, share, {}, camera_motion())) {
      log("tracking")
          ->warn("{}: target \"{}\" has too little texture to be followed: give a larger or richer region", camera_,
                 wanted.name);
    }
  }
  if (background_) background_->limit(background_share());
  pending_.clear();
}

void CameraTracker::choose_automatically() {
  if (!automatic_ || !background_ || !flow_.has_previous()) return;
  automatic_->observe(background_->features(), camera_motion());
  if (!automatic_->complete()) return;
  const std::vector<ImageRect> regions = automatic_->choose();
  if (regions.empty()) return;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const std::string name = fmt::format("auto{}", i);
    output_of(name);
    pending_.push_back({name, regions[i]});
  }
  automatic_.reset();
  start_pending();
}

void CameraTracker::emit(const SampleHeader& header, bool usable, SampleSink& out) {
  const auto send = [&](Output& output, Payload payload) {
    SampleHeader derived;
    derived.stream = output.stream;
    derived.sequence = output.sequence++;
    derived.arrival_time = header.arrival_time;
    derived.sample_time = header.sample_time;
    out.receive({derived, std::move(payload)});
  };
  send(motion_output_, image_motion(usable));
  for (const RegionTracker& target : targets_) send(output_of(target.name()), displacement_of(target, usable));
}

ImageMotion CameraTracker::image_motion(bool usable) const {
  ImageMotion motion;
  for (const RegionTracker& target : targets_) {
    motion.targets.push_back(
        {target.name(), moved(target.region_now(), kCorner), usable ? target.health() : 0.0F, usable && target.valid()});
  }
  if (!usable) return motion;
  const auto add = [&](const RegionTracker& region, std::uint8_t index) {
    for (const Feature& feature : region.features()) {
      if (!feature.active) continue;
      const Eigen::Vector2f at = feature.position.cast<float>();
      const Eigen::Vector2f step = (feature.position - feature.previous).cast<float>();
      motion.points.push_back({at.x() + static_cast<float>(kCorner), at.y() + static_cast<float>(kCorner), step.x(), step.y(),
                               index, feature.agrees});
    }
  };
  motion.points.reserve(points_.size());
  for (std::size_t i = 0; i < targets_.size(); ++i) add(targets_[i], static_cast<std::uint8_t>(i));
  if (background_) add(*background_, ImageMotion::kBackground);
  return motion;
}

Displacement CameraTracker::displacement_of(const RegionTracker& target, bool usable) const {
  const CameraMotion camera = camera_motion();
  const double floor2 = options_.standard_error_floor_px * options_.standard_error_floor_px;
  const Eigen::Matrix2d covariance = target.covariance() + camera.covariance;
  Displacement displacement;
  displacement.x = target.displacement().x();
  displacement.y = target.displacement().y();
  displacement.covariance = {covariance(0, 0) + floor2, covariance(0, 1), covariance(1, 1) + floor2};
  displacement.unit = LengthUnit::pixel;
  displacement.region = moved(target.region_now(), kCorner);
  displacement.features = static_cast<std::uint16_t>(usable && target.valid() ? target.agreeing() : 0);
  displacement.health = usable ? target.health() : 0.0F;
  displacement.valid = usable && target.valid();
  return displacement;
}

}  // namespace roseau::tracking
