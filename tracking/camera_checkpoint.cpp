// Saving and restoring a CameraTracker.
#include <fmt/format.h>

#include "tracking/camera_tracker.h"

namespace roseau::tracking {

namespace {

constexpr std::uint32_t kVersion = 2;

/// What a checkpoint must have been made with for its state to mean the same.
std::vector<std::byte> fingerprint(const std::string& camera, const TrackerOptions& options) {
  std::vector<std::byte> bytes;
  CheckpointWriter out(bytes);
  out.put(kVersion);
  out.put(std::string_view(camera));
  for (const TargetRegion& target : options.targets) {
    out.put(std::string_view(target.name));
    for (const double value : {target.region.x, target.region.y, target.region.width, target.region.height}) out.put(value);
  }
  out.put(options.automatic_targets);
  out.put(options.subtract_background);
  for (const int value :
       {options.automatic_frames, options.automatic_most_targets, options.feature_count, options.pyramid_levels,
        options.window_px, options.flow_iterations, options.mono16_significant_bits}) {
    out.put(value);
  }
  for (const double value :
       {options.automatic_least_motion_px, options.background_share, options.flow_converged_px, options.forward_backward_px,
        options.least_correlation, options.search_radius_px, options.standard_error_floor_px}) {
    out.put(value);
  }
  return bytes;
}

void put_picture(CheckpointWriter& out, const cv::Mat& gray) {
  out.put(gray.cols);
  out.put(gray.rows);
  for (int row = 0; row < gray.rows; ++row) {
    out.put_bytes(std::as_bytes(std::span(gray.ptr<std::uint8_t>(row), static_cast<std::size_t>(gray.cols))));
  }
}

cv::Mat get_picture(CheckpointReader& in) {
  int columns = 0;
  int rows = 0;
  in.get(columns);
  in.get(rows);
  if (columns <= 0 || rows <= 0) in.fail();
  const auto bytes = in.take(in.ok() ? static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) : 0);
  if (!in.ok()) return {};
  cv::Mat gray(rows, columns, CV_8U);
  std::memcpy(gray.data, bytes.data(), bytes.size());
  return gray;
}

}  // namespace

void CameraTracker::save(std::vector<std::byte>& bytes) const {
  CheckpointWriter out(bytes);
  const std::vector<std::byte> made_with = fingerprint(camera_, options_);
  out.put(static_cast<std::uint32_t>(made_with.size()));
  out.put_bytes(made_with);

  out.put(motion_output_.sequence);
  out.put(static_cast<std::uint32_t>(outputs_.size()));
  for (const auto& [name, output] : outputs_) {
    out.put(std::string_view(name));
    out.put(output.sequence);
  }
  out.put(converter_.mono16_bits());
  out.put(frames_);
  out.put(last_time_.has_value());
  out.put(last_time_ ? to_ns(*last_time_) : std::int64_t{0});
  out.put(flow_.has_current());
  if (flow_.has_current()) put_picture(out, flow_.current());

  out.put(background_.has_value());
  if (background_) background_->save(out);
  out.put(static_cast<std::uint32_t>(targets_.size()));
  for (const RegionTracker& target : targets_) {
    out.put(std::string_view(target.name()));
    target.save(out);
  }
  out.put(static_cast<std::uint32_t>(pending_.size()));
  for (const TargetRegion& target : pending_) {
    out.put(std::string_view(target.name));
    for (const double value : {target.region.x, target.region.y, target.region.width, target.region.height}) out.put(value);
  }
  out.put(automatic_.has_value());
  if (automatic_) automatic_->save(out);
}

void CameraTracker::load_state(CheckpointReader& in) {
  in.get(motion_output_.sequence);
  const std::size_t outputs = in.get_count(2 * sizeof(std::uint32_t));
  for (std::size_t i = 0; i < outputs && in.ok(); ++i) {
    std::string name;
    in.get(name);
    if (!is_target_name(name)) in.fail();
    if (in.ok()) in.get(output_of(name).sequence);
  }
  int mono16_bits = 0;
  in.get(mono16_bits);
  if (mono16_bits != 0 && (mono16_bits < 9 || mono16_bits > 16)) in.fail();
  converter_.set_mono16_bits(mono16_bits);
  in.get(frames_);
  bool has_time = false;
  std::int64_t time_ns = 0;
  in.get(has_time);
  in.get(time_ns);
  if (has_time) last_time_ = host_time_from_ns(time_ns);
  bool has_picture = false;
  in.get(has_picture);
  if (has_picture) {
    const cv::Mat gray = get_picture(in);
    if (in.ok()) flow_.advance(gray);
  }

  bool has_background = false;
  in.get(has_background);
  if (has_background) background_.emplace(options_, "background", RegionKind::background).load(in);
  const std::size_t targets = in.get_count(sizeof(std::uint32_t));
  for (std::size_t i = 0; i < targets && in.ok(); ++i) {
    std::string name;
    in.get(name);
    targets_.emplace_back(options_, name, RegionKind::target).load(in);
  }
  const std::size_t pending = in.get_count(sizeof(std::uint32_t));
  for (std::size_t i = 0; i < pending && in.ok(); ++i) {
    TargetRegion& target = pending_.emplace_back();
    in.get(target.name);
    for (double* value : {&target.region.x, &target.region.y, &target.region.width, &target.region.height}) in.get(*value);
  }
  bool has_automatic = false;
  in.get(has_automatic);
  if (has_automatic) automatic_.emplace(options_).load(in);
  if (!in.at_end()) in.fail();
}

Result<void> CameraTracker::load(std::span<const std::byte> bytes) {
  CheckpointReader in(bytes);
  const std::size_t size = in.get_count(1);
  const auto made_with = in.take(size);
  if (in.ok() && !std::ranges::equal(made_with, fingerprint(camera_, options_))) {
    return Error{ErrorCode::unsupported,
                 fmt::format("the tracking checkpoint was not made by this version for camera \"{}\" with these options: "
                             "replay with the session's own configuration",
                             camera_)};
  }
  restart();
  automatic_.reset();
  pending_.clear();
  last_time_.reset();
  if (in.ok()) load_state(in);
  if (!in.ok()) {
    restart();
    last_time_.reset();
    motion_output_.sequence = 0;
    for (auto& [name, output] : outputs_) output.sequence = 0;
    return Error{ErrorCode::corrupt,
                 fmt::format("the tracking checkpoint of camera \"{}\" ({} bytes) is damaged: replay from the session's "
                             "beginning",
                             camera_, bytes.size())};
  }
  observe_work(observer_);
  return {};
}

}  // namespace roseau::tracking
