#include "drivers/camera/file/opencv_video_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "core/log.h"
#include "drivers/camera/file/plugin_interface.h"

namespace roseau::camera {

namespace {

HostTime monotonic_now() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return HostTime{std::chrono::seconds{now.tv_sec} + std::chrono::nanoseconds{now.tv_nsec}};
}

std::uint64_t to_count(double property) { return property > 0 ? static_cast<std::uint64_t>(std::llround(property)) : 0; }

std::size_t buffer_count_for(std::size_t frame_bytes, std::size_t asked_for) {
  constexpr std::size_t kUsualBytes = std::size_t{64} << 20U;
  return asked_for > 0 ? asked_for : std::clamp<std::size_t>(kUsualBytes / frame_bytes, 4, 64);
}

// OpenCV reports by exception what it does not report by false.
template <class Function>
auto guarded(const std::string& what, const Function& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& error) {
    return Error{ErrorCode::corrupt, what + " cannot be decoded: " + error.what()};
  }
}

}  // namespace

Result<void> OpencvVideoFile::check_options() const {
  if (options_.format != PixelFormat::bgr8 && options_.format != PixelFormat::mono8) {
    return Error{ErrorCode::unsupported,
                 quoted_path() + ": frames can be bgr8 or mono8, not " + std::string(to_string(options_.format))};
  }
  if (options_.rate_hz && !(std::isfinite(*options_.rate_hz) && *options_.rate_hz > 0)) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("{}: {} frames per second make no sense", quoted_path(), *options_.rate_hz)};
  }
  std::error_code error;
  if (!std::filesystem::exists(options_.path, error)) {
    return Error{ErrorCode::not_found, quoted_path() + " does not exist: check its path"};
  }
  return {};
}

Result<void> OpencvVideoFile::open(StreamTable& streams) {
  close();
  if (auto checked = check_options(); !checked) return checked;
  if (auto opened = guarded(quoted_path(), [this] { return open_file(); }); !opened) {
    close();
    return opened;
  }
  const std::string topic = options_.topic.empty() ? "/" + options_.name + "/image" : options_.topic;
  stream_ = streams.add({.topic = topic,
                         .kind = std::string(to_string(SampleKind::frame)),
                         .role = StreamRole::raw,
                         .device = options_.name,
                         .metadata = {{"rate_hz", fmt::format("{}", info_.rate_hz)}, {"link", "file " + options_.path}}});
  start_ = options_.start.value_or(monotonic_now());
  return {};
}

Result<void> OpencvVideoFile::open_file() {
  info_ = {};
  grabbed_index_ = 0;
  has_ended_ = false;
  trusts_container_ = true;
  // FFmpeg by name: the other back ends give other times for the same file.
  if (!capture_.open(options_.path, cv::CAP_FFMPEG)) {
    return Error{ErrorCode::unsupported, quoted_path() + " is no video that FFmpeg can read: check that it plays elsewhere"};
  }
  info_.rate_hz = options_.rate_hz.value_or(std::max(0.0, capture_.get(cv::CAP_PROP_FPS)));
  info_.announced_frames = to_count(capture_.get(cv::CAP_PROP_FRAME_COUNT));
  // The first frame tells what the header may be wrong about.
  if (!capture_.grab() || !capture_.retrieve(colour_) || colour_.empty()) {
    return Error{ErrorCode::corrupt,
                 quoted_path() +
                     " holds no frame that can be decoded: it was cut off, or is no recording; check that it plays elsewhere"};
  }
  if (colour_.type() != CV_8UC3) return Error{ErrorCode::unsupported, quoted_path() + " has pictures of an unknown kind"};
  info_.width = static_cast<std::uint32_t>(colour_.cols);
  info_.height = static_cast<std::uint32_t>(colour_.rows);
  grabbed_time_ = time_in_file().value_or(Duration{0});
  has_grabbed_ = true;
  const std::size_t frame_bytes = std::size_t{info_.width} * info_.height * bytes_per_pixel(options_.format);
  pool_.emplace(buffer_count_for(frame_bytes, options_.buffer_count), frame_bytes);
  return {};
}

// Of the frame just grabbed; nothing when neither the file nor the options tell. Stated times that do not move on are none:
// from there on the frame rate counts.
std::optional<Duration> OpencvVideoFile::time_in_file() {
  if (options_.rate_hz) return from_seconds(static_cast<double>(grabbed_index_) / *options_.rate_hz);
  if (trusts_container_) {
    const Duration stated = from_seconds(capture_.get(cv::CAP_PROP_POS_MSEC) * 1e-3);
    if (grabbed_index_ == 0 || stated > grabbed_time_) return stated;
    trusts_container_ = false;
    log(options_.name)
        ->warn("{}: frame {} has no later time than the one before; from there on {} frames per second are taken",
               quoted_path(), grabbed_index_, info_.rate_hz);
  }
  if (info_.rate_hz <= 0) return std::nullopt;
  return grabbed_time_ + from_seconds(1.0 / info_.rate_hz);
}

// False at the end of the file.
Result<bool> OpencvVideoFile::grab() {
  if (has_grabbed_) return true;
  if (has_ended_) return false;
  if (!capture_.grab()) {
    has_ended_ = true;
    report_end();
    return false;
  }
  ++grabbed_index_;
  const auto time = time_in_file();
  if (!time) {
    return Error{ErrorCode::unsupported,
                 quoted_path() + " says neither when its frames were taken nor their rate: give it (@FPS)"};
  }
  grabbed_time_ = *time;
  has_grabbed_ = true;
  return true;
}

void OpencvVideoFile::report_end() {
  const std::uint64_t held = grabbed_index_ + 1;
  if (info_.announced_frames == 0 || info_.announced_frames == held) return;
  info_.warning = fmt::format("{} announces {} frames and holds {} pictures (it was cut off, or some were never taken)",
                              quoted_path(), info_.announced_frames, held);
  log(options_.name)->warn("{}", info_.warning);
}

// False when the frame's time has not come within `timeout`.
Result<bool> OpencvVideoFile::wait_for_time(std::chrono::milliseconds timeout) const {
  if (!options_.is_paced) return true;
  const Duration ahead = time_of_grabbed() - monotonic_now();
  if (ahead > timeout) {
    std::this_thread::sleep_for(timeout);
    return false;
  }
  if (ahead > Duration{0}) std::this_thread::sleep_for(ahead);
  return true;
}

Result<void> OpencvVideoFile::retrieve_into(std::span<std::byte> pixels) {
  const int height = static_cast<int>(info_.height);
  const int width = static_cast<int>(info_.width);
  const bool is_mono = options_.format == PixelFormat::mono8;
  cv::Mat target(height, width, is_mono ? CV_8UC1 : CV_8UC3, pixels.data());
  cv::Mat& decoded = is_mono ? colour_ : target;
  if (!capture_.retrieve(decoded) || decoded.rows != height || decoded.cols != width || decoded.type() != CV_8UC3) {
    return Error{ErrorCode::corrupt, fmt::format("{}: frame {} cannot be decoded, or is not {} x {} as those before it",
                                                 quoted_path(), grabbed_index_, width, height)};
  }
  if (is_mono) cv::cvtColor(colour_, target, cv::COLOR_BGR2GRAY);
  return {};
}

Result<ReadStatus> OpencvVideoFile::read(SampleSink& sink, std::chrono::milliseconds timeout) {
  const auto grabbed = guarded(quoted_path(), [this] { return grab(); });
  if (!grabbed) return grabbed.error();
  if (!*grabbed) return ReadStatus::finished;
  const auto its_time = wait_for_time(timeout);
  if (!*its_time) return ReadStatus::idle;

  FrameLease lease = pool_->acquire();
  if (!lease) {
    if (!options_.is_paced) {
      std::this_thread::sleep_for(std::min(timeout, std::chrono::milliseconds{1}));
      return ReadStatus::idle;
    }
    // As a camera whose buffers are all out: the picture is lost, the gap in the numbering shows it.
    ++info_.dropped_frames;
    has_grabbed_ = false;
    return ReadStatus::more;
  }
  if (auto retrieved = guarded(quoted_path(), [&] { return retrieve_into(lease.writable_bytes()); }); !retrieved) {
    return retrieved.error();
  }
  Sample sample;
  sample.header.stream = stream_;
  sample.header.sequence = static_cast<std::uint32_t>(grabbed_index_);
  sample.header.sample_time = time_of_grabbed();
  sample.header.arrival_time = options_.is_paced ? monotonic_now() : sample.header.sample_time;
  const auto stride = static_cast<std::uint32_t>(info_.width * bytes_per_pixel(options_.format));
  sample.payload = Frame{
      .pixels = std::move(lease), .width = info_.width, .height = info_.height, .stride = stride, .format = options_.format};
  has_grabbed_ = false;
  ++info_.frames;
  // A full sink counts the drop itself.
  sink.receive(std::move(sample));
  return ReadStatus::more;
}

void OpencvVideoFile::close() {
  capture_.release();
  has_grabbed_ = false;
}

}  // namespace roseau::camera

extern "C" std::uint64_t roseau_video_plugin_version() { return roseau::camera::kVideoPluginVersion; }

extern "C" roseau::camera::VideoFile* roseau_video_plugin_make(const roseau::camera::VideoFileOptions& options) {
  return new roseau::camera::OpencvVideoFile(options);
}
