// What tracking one 1280x1024 frame with some 500 points costs, by part, and how near the truth it comes: the simulated rig's
// large camera, whose tree moves as it does in the demo.
#include <time.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "synthesis/rig/camera_view.h"
#include "tracking/camera_tracker.h"

namespace roseau::bench {

namespace {

constexpr int kFrames = 300;
constexpr std::array<const char*, 7> kWorkNames = {"gray", "pyramid", "flow", "patches", "robust", "renewal", "output"};

// CPU of the whole process, so that what OpenCV's threads do counts too.
double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

class Stopwatch final : public tracking::WorkObserver {
 public:
  void enters(tracking::Work work) override {
    stop();
    running_ = static_cast<int>(work);
  }
  void stop() {
    const double now_ms = cpu_ms();
    if (running_ >= 0) used_ms[static_cast<std::size_t>(running_)] += now_ms - since_ms_;
    since_ms_ = now_ms;
    running_ = -1;
  }
  std::array<double, kWorkNames.size()> used_ms{};

 private:
  int running_ = -1;
  double since_ms_ = 0;
};

class Collector final : public SampleSink {
 public:
  bool receive(Sample sample) override {
    if (const auto* found = std::get_if<Displacement>(&sample.payload)) displacement = *found;
    if (const auto* found = std::get_if<ImageMotion>(&sample.payload)) points = found->points.size();
    return true;
  }
  Displacement displacement;
  std::size_t points = 0;
};

// The large camera's pictures, one after the other, and the truth about each.
class LargeCamera {
 public:
  struct Picture {
    Sample sample;
    Vec2 displacement_px;
  };
  LargeCamera(StreamId stream, std::shared_ptr<const synthesis::World> world)
      : stream_(stream), world_(std::move(world)), view_(world_, 0), pool_(2, view_.frame_bytes()) {}

  ImageRect target() const { return world_->target_region(target_of_scene(), 0, {}); }

  Picture next() {
    const double time_s = index_ / view_.camera().rate_hz;
    Frame frame = view_.take(static_cast<std::uint64_t>(index_), time_s, pool_);
    SampleHeader header;
    header.stream = stream_;
    header.sequence = static_cast<std::uint32_t>(index_++);
    header.sample_time = header.arrival_time = host_time_from_ns(1'000'000'000) + from_seconds(time_s);
    Eigen::VectorXd amplitudes;
    world_->tree_motion().amplitudes(time_s, amplitudes);
    return {{header, std::move(frame)},
            world_->target_displacement_px(target_of_scene(), 0, target_of_scene().displacement_m(amplitudes))};
  }

 private:
  const synthesis::PlacedTarget& target_of_scene() const { return world_->targets().front(); }

  StreamId stream_;
  std::shared_ptr<const synthesis::World> world_;
  synthesis::CameraView view_;
  FramePool pool_;
  int index_ = 0;
};

Result<nlohmann::ordered_json> track() {
  StreamTable streams;
  const StreamId images = streams.add({.topic = "/camera0/image", .kind = "frame", .device = "camera0"});
  auto world = synthesis::World::build(synthesis::large_camera_scene());
  if (!world) return world.error();
  LargeCamera source(images, std::move(*world));
  tracking::TrackerOptions options;
  options.targets = {{"branch", source.target()}};
  options.feature_count = 620;  // some find no place in this picture: 500 are left
  tracking::CameraTracker tracker(streams, "camera0", options);
  Stopwatch watch;
  Collector collected;
  std::vector<std::byte> checkpoint;

  double points = 0;
  double square = 0;
  double claimed = 0;
  double first_ms = 0;
  double worst_ms = 0;
  double total_ms = 0;
  Vec2 rest;
  for (int i = 0; i <= kFrames; ++i) {
    const LargeCamera::Picture picture = source.next();
    if (i == 1) tracker.observe_work(&watch);
    const double before_ms = cpu_ms();
    tracker.process(picture.sample, collected);
    watch.stop();
    const double used_ms = cpu_ms() - before_ms;
    if (i == 0) {
      first_ms = used_ms;
      rest = picture.displacement_px;
      continue;
    }
    total_ms += used_ms / kFrames;
    worst_ms = std::max(worst_ms, used_ms);
    points += static_cast<double>(collected.points) / kFrames;
    const double error_x = collected.displacement.x - (picture.displacement_px.x - rest.x);
    const double error_y = collected.displacement.y - (picture.displacement_px.y - rest.y);
    square += (error_x * error_x + error_y * error_y) / (2 * kFrames);
    claimed += (collected.displacement.covariance.xx + collected.displacement.covariance.yy) / (2 * kFrames);
  }
  tracker.observe_work(nullptr);
  tracker.save(checkpoint);

  nlohmann::ordered_json figures{{"case", "track"}, {"frame_ms", total_ms}};
  for (std::size_t i = 0; i < kWorkNames.size(); ++i) {
    figures[std::string(kWorkNames[i]) + "_ms"] = watch.used_ms[i] / kFrames;
  }
  figures["worst_frame_ms"] = worst_ms;
  figures["first_frame_ms"] = first_ms;
  figures["points_count"] = points;
  figures["error_rms_px"] = std::sqrt(square);
  figures["claimed_error_rms_px"] = std::sqrt(claimed);
  figures["checkpoint_bytes"] = checkpoint.size();
  return figures;
}

}  // namespace

void add_tracking_cases(std::vector<Case>& cases) {
  cases.push_back({"track", "CPU per 1280x1024 frame of tracking some 500 points, by part; error against truth", track});
}

}  // namespace roseau::bench
