// display_demo: a live display fed with made-up samples at real rates, for the tests of the page. Two cameras see a swaying
// branch each; a sonic, estimates, spectra and health go with them. Nothing here is measured or estimated: it only looks so.
//
//   display_demo [--port N] [--for SECONDS] [--trouble] [--settling] [--no-target] [--replay] [--web DIR]
//
// --replay: of ten minutes, with two marks; it can be sought, and paused it shows one moment.
//
// Prints "http://127.0.0.1:PORT" when it serves. --trouble: a silent sonic, gaps, a lost target, a full disk.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "display/server.h"

namespace {

using namespace roseau;
using namespace std::chrono_literals;

std::atomic<bool> stop_requested{false};

constexpr int kWidth_px = 1280;
constexpr int kHeight_px = 1024;
constexpr double kNaturalFrequency_hz = 0.62;
constexpr double kDampingRatio = 0.043;
constexpr double kPi = std::numbers::pi;

/// Wind from a direction near 240 degrees, as a sum of slow waves: the same at every run.
double wind_mps(double t_s) {
  return 5.6 + 1.5 * std::sin(0.21 * t_s) + 1.1 * std::sin(0.53 * t_s + 1) + 0.7 * std::sin(1.31 * t_s + 2) +
         0.35 * std::sin(2.9 * t_s) + 0.2 * std::sin(7.3 * t_s + 0.5);
}

double direction_deg(double t_s) { return 243 + 14 * std::sin(0.13 * t_s) + 6 * std::sin(0.71 * t_s); }

/// One mode pushed by the wind.
class Branch {
 public:
  explicit Branch(double gain) : gain_(gain) {}
  double step(double t_s, double dt_s) {
    const double w0 = 2 * kPi * kNaturalFrequency_hz;
    const double wind = wind_mps(t_s);
    velocity_ += dt_s * (gain_ * wind * wind - 2 * kDampingRatio * w0 * velocity_ - w0 * w0 * x_);
    x_ += dt_s * velocity_;
    return x_;
  }

 private:
  double gain_;
  double x_ = 0;
  double velocity_ = 0;
};

struct Leaf {
  cv::Point2d at;
  double size_px;
  double share;  // of the branch's motion
  int gray;
};

/// A still background and leaves that sway.
class Scene {
 public:
  explicit Scene(std::uint64_t seed) : random_(seed) {
    cv::Mat noise(kHeight_px / 8, kWidth_px / 8, CV_8U);
    random_.fill(noise, cv::RNG::UNIFORM, 60, 190);
    cv::resize(noise, background_, cv::Size(kWidth_px, kHeight_px), 0, 0, cv::INTER_CUBIC);
    cv::GaussianBlur(background_, background_, cv::Size(0, 0), 5);
    for (int row = 0; row < kHeight_px; ++row) background_.row(row) += cv::Scalar(70.0 * (kHeight_px - row) / kHeight_px);
    for (int i = 0; i < 260; ++i) {
      const double along = random_.uniform(0.15, 1.0);
      const double x = 250 + 620 * along + random_.gaussian(60);
      const double y = 880 - 620 * along * along + random_.gaussian(70);
      leaves_.push_back({{x, y}, random_.uniform(9.0, 26.0), along * along, random_.uniform(15, 110)});
    }
  }

  const std::vector<Leaf>& leaves() const { return leaves_; }

  void draw(double x_px, cv::Mat& picture) const {
    background_.copyTo(picture);
    std::vector<cv::Point> spine;
    for (double along = 0; along <= 1; along += 0.05) {
      spine.emplace_back(cvRound(250 + 620 * along + x_px * along * along), cvRound(880 - 620 * along * along));
    }
    cv::polylines(picture, spine, false, cv::Scalar(35), 9, cv::LINE_AA);
    for (const Leaf& leaf : leaves_) {
      const cv::Point2d at = leaf.at + cv::Point2d(x_px * leaf.share, 0.1 * x_px * leaf.share);
      const cv::RotatedRect shape(cv::Point2f(at), cv::Size2f(cv::Size2d(leaf.size_px * 2, leaf.size_px)),
                                  static_cast<float>(leaf.gray * 3 + 0.2 * x_px));
      cv::ellipse(picture, shape, cv::Scalar(leaf.gray), cv::FILLED, cv::LINE_AA);
    }
  }

 private:
  cv::RNG random_;
  cv::Mat background_;
  std::vector<Leaf> leaves_;
};

struct Options {
  display::DisplayOptions display;
  double seconds = 1e9;
  bool trouble = false;
  bool settling = false;
  bool with_target = true;
  bool replay = false;
};

class Player final : public PlayerControl {
 public:
  void play() override {
    set([](PlayerState& state) { state.playing = true; });
  }
  void pause() override {
    set([](PlayerState& state) { state.playing = false; });
  }
  void set_speed(double speed) override {
    set([speed](PlayerState& state) { state.speed = speed; });
  }
  void seek(HostTime time) override {
    set([time](PlayerState& state) {
      state.position = std::clamp(time, state.begin, state.end);
      ++state.jumps;
    });
  }
  /// Where to go on, once after each seek.
  std::optional<HostTime> take_seek() {
    const std::scoped_lock lock(mutex_);
    if (std::exchange(state_.jumps_done, state_.jumps) == state_.jumps) return std::nullopt;
    return state_.position;
  }
  PlayerState state() const override {
    const std::scoped_lock lock(mutex_);
    return state_;
  }
  void set_position(HostTime time) {
    set([time](PlayerState& state) {
      if (state.jumps == state.jumps_done) state.position = time;
    });
  }
  void set_range(HostTime begin, HostTime end) {
    set([begin, end](PlayerState& state) {
      state.begin = begin;
      state.end = end;
    });
  }

 private:
  template <class Change>
  void set(Change change) {
    const std::scoped_lock lock(mutex_);
    change(state_);
  }
  mutable std::mutex mutex_;
  PlayerState state_;
};

class Demo {
 public:
  explicit Demo(Options options) : options_(std::move(options)) {
    for (int i = 0; i < 2; ++i) {
      const std::string device = "camera" + std::to_string(i);
      Camera& camera = cameras_[static_cast<std::size_t>(i)];
      camera.device = device;
      camera.target = i == 0 ? "branch" : "twig";
      camera.image = add("/" + device + "/image", SampleKind::frame, device);
      camera.motion = add("/" + device + "/motion", SampleKind::image_motion, device);
      if (options_.with_target) add_target(camera);
    }
    wind_ = add("/sonic/wind", SampleKind::wind, "sonic");
    if (options_.with_target) fused_ = add("/wind/estimate", SampleKind::wind_estimate, "");
    health_ = add("/roseau/health", SampleKind::health, "");
    clocks_ = add("/roseau/clocks", SampleKind::clock_state, "");
    actions_ = add("/roseau/operator", SampleKind::operator_action, "");
  }

  int run() {
    begin_ = now();
    player_.set_range(begin_, begin_ + 600s);
    options_.display.marks = {{begin_ + 95s, "gust"}, {begin_ + 400s, "lull"}};
    display::DisplayServer server(options_.display, streams_,
                                  {[this](const OperatorAction& action) { return on_action(action); }},
                                  options_.replay ? &player_ : nullptr);
    const auto port = server.start();
    if (!port) {
      std::fprintf(stderr, "display_demo: %s\n", port.error().message.c_str());
      return 1;
    }
    std::printf("http://127.0.0.1:%d\n", int{*port});
    std::fflush(stdout);
    server_ = &server;
    constexpr double kStep_s = 1.0 / 60;
    for (std::int64_t step = 0; !stop_requested && static_cast<double>(step) * kStep_s < options_.seconds;) {
      if (const auto place = player_.take_seek()) {
        const auto sought = static_cast<std::int64_t>(to_seconds(*place - begin_) / kStep_s);
        pause_ -= from_seconds(static_cast<double>(sought - step) * kStep_s);
        // Both cameras' pictures come at every other step.
        step = sought - sought % 2;
        server.restart();
        tick(step, static_cast<double>(step) * kStep_s);
      }
      if (options_.replay && !player_.state().playing) {
        std::this_thread::sleep_for(20ms);
        pause_ += 20ms;
        continue;
      }
      std::this_thread::sleep_until(std::chrono::steady_clock::time_point(begin_.time_since_epoch() + pause_) +
                                    from_seconds(static_cast<double>(step) * kStep_s));
      tick(step, static_cast<double>(step) * kStep_s);
      ++step;
    }
    server.stop();
    return 0;
  }

 private:
  struct Camera {
    std::string device;
    std::string target;
    StreamId image = 0;
    StreamId motion = 0;
    std::optional<StreamId> displacement;
    StreamId estimate = 0;
    StreamId identification = 0;
    StreamId calibration = 0;
    StreamId spectrum = 0;
    Branch branch{6.5};
    Scene scene{77};
    FramePool pool{8, std::size_t{kWidth_px} * kHeight_px};
    double x_px = 0;
    double shown_x_px = 0;  // in the picture before
  };

  static HostTime now() { return HostTime(std::chrono::steady_clock::now().time_since_epoch()); }

  StreamId add(const std::string& topic, SampleKind kind, const std::string& device) {
    const StreamRole role = kind == SampleKind::frame ? StreamRole::raw : StreamRole::derived;
    return streams_.add({topic, std::string(to_string(kind)), role, device, {}});
  }

  void add_target(Camera& camera) {
    const std::string base = "/" + camera.device + "/target/" + camera.target;
    camera.estimate = add(base + "/wind", SampleKind::wind_estimate, camera.device);
    camera.identification = add(base + "/identification", SampleKind::identification, camera.device);
    camera.calibration = add(base + "/calibration", SampleKind::wind_calibration, camera.device);
    camera.spectrum = add(base + "/spectrum", SampleKind::force_spectrum, camera.device);
    camera.displacement = add(base + "/displacement", SampleKind::displacement, camera.device);
  }

  Result<void> on_action(const OperatorAction& action) {
    const std::scoped_lock lock(mutex_);
    if (action.kind == OperatorAction::Kind::start_recording) recording_since_ = now();
    if (action.kind == OperatorAction::Kind::trigger && !recording_since_) {
      recording_since_ = now() - kPast;
      triggered_ = now();
    }
    if (action.kind == OperatorAction::Kind::stop_recording) {
      recording_since_.reset();
      triggered_.reset();
    }
    if (action.kind == OperatorAction::Kind::remove_target) {
      return Error{ErrorCode::not_found, "there is no target \"" + action.text + "\""};
    }
    publish(actions_, action, now());
    return {};
  }

  template <class Payload>
  void publish(StreamId stream, Payload payload, HostTime time, Duration lag = 0ns) {
    Sample sample;
    sample.header = {.stream = stream, .sequence = sequence_++, .arrival_time = time, .sample_time = time - lag};
    sample.payload = std::move(payload);
    server_->publish(sample, time);
  }

  void tick(std::int64_t step, double t_s) {
    const HostTime time = begin_ + from_seconds(t_s);
    player_.set_position(time);
    for (Camera& camera : cameras_) camera.x_px = camera.branch.step(t_s, 1.0 / 60) * (&camera == &cameras_[1] ? 0.6 : 1);
    if (step % 3 == 0 && !(options_.trouble && t_s > 6)) publish_wind(t_s, time);
    if (step % 2 == 0) {
      for (Camera& camera : cameras_) publish_camera(camera, step, t_s, time);
    }
    if (step % 120 == 60) {
      for (Camera& camera : cameras_) publish_knowledge(camera, t_s, time);
    }
    if (step % 60 == 0) publish_health(t_s, time);
  }

  void publish_wind(double t_s, HostTime time) {
    const double from_rad = direction_deg(t_s) * kPi / 180;
    const double speed = wind_mps(t_s) + 0.25 * std::sin(37 * t_s) + 0.2 * std::sin(23.3 * t_s);
    // Gill: u positive blowing north, v positive blowing west.
    publish(wind_, WindSample{.u_mps = -speed * std::cos(from_rad), .v_mps = speed * std::sin(from_rad), .w_mps = 0.1}, time);
  }

  void publish_camera(Camera& camera, std::int64_t step, double t_s, HostTime time) {
    Frame frame{.pixels = camera.pool.acquire(), .width = kWidth_px, .height = kHeight_px, .stride = kWidth_px};
    if (!frame.pixels) return;
    cv::Mat picture(kHeight_px, kWidth_px, CV_8U, frame.pixels.writable_bytes().data());
    camera.scene.draw(camera.x_px, picture);
    publish(camera.image, std::move(frame), time);
    if (camera.displacement) publish_motion(camera, step, t_s, time);
    camera.shown_x_px = camera.x_px;
  }

  void publish_motion(Camera& camera, std::int64_t step, double t_s, HostTime time) {
    const ImageRect region{620 + camera.x_px * 0.7, 330 + 0.07 * camera.x_px, 250, 240};
    const bool lost = options_.trouble && t_s > 8;
    ImageMotion motion;
    motion.targets.push_back({camera.target, region, lost ? 0.1F : 0.93F, !lost});
    const double moved_px = camera.x_px - camera.shown_x_px;
    for (const Leaf& leaf : camera.scene.leaves()) {
      const double x = leaf.at.x + camera.x_px * leaf.share;
      const bool inside =
          x > region.x && x < region.x + region.width && leaf.at.y > region.y && leaf.at.y < region.y + region.height;
      if (!inside) continue;
      motion.points.push_back({static_cast<float>(x), static_cast<float>(leaf.at.y), static_cast<float>(moved_px * leaf.share),
                               static_cast<float>(0.1 * moved_px * leaf.share), 0, true});
    }
    for (int i = 0; i < 24; ++i) {
      motion.points.push_back({static_cast<float>(60 + 50 * i), static_cast<float>(950 + 30 * (i % 2)), 0.1F, 0, 255, true});
    }
    publish(camera.motion, std::move(motion), time);
    Displacement displacement{.x = camera.x_px * 0.7,
                              .y = camera.x_px * 0.07 + 0.05 * std::sin(50 * t_s),
                              .region = region,
                              .features = 120,
                              .health = 0.93F,
                              .valid = !lost};
    // Half a second of nothing now and then: the page must show it as a gap.
    if (step % 1200 > 30 || step < 600) publish(*camera.displacement, displacement, time);
    const double estimated = wind_mps(t_s - 0.25) + 0.35 * std::sin(0.9 * t_s) + 0.15 * std::sin(3.7 * t_s);
    WindEstimate estimate{.wind_mps = estimated,
                          .wind_sd_mps = 0.38 + 0.1 * std::sin(0.3 * t_s),
                          .force_per_mass = 3,
                          .force_per_mass_sd = 0.2,
                          .lag_s = 0.25,
                          .accepted = !lost,
                          .settling = options_.settling,
                          .scale_known = true};
    publish(camera.estimate, estimate, time, 250ms);
    if (&camera != cameras_.data()) return;
    estimate.wind_mps -= 0.2;
    estimate.wind_sd_mps *= 0.7;
    publish(fused_, estimate, time, 250ms);
  }

  void publish_knowledge(Camera& camera, double t_s, HostTime time) {
    if (!camera.displacement) return;
    publish(camera.identification,
            Identification{.natural_frequency_hz = kNaturalFrequency_hz,
                           .natural_frequency_sd_hz = 0.006,
                           .damping_ratio = kDampingRatio,
                           .damping_ratio_sd = 0.008,
                           .noise_sd = 0.05,
                           .force_slope = 1.7,
                           .peak_to_floor = 240,
                           .axis = {0.995, 0.0995},
                           .window_s = std::min(t_s, 120.0),
                           .accepted = true},
            time);
    publish(camera.calibration,
            WindCalibration{.reference = "/sonic/wind",
                            .gain = 1,
                            .offset = 0,
                            .exponent = 1.6,
                            .delay_s = 0.02,
                            .direction_deg = 243,
                            .explained = 0.91,
                            .correlation = 0.96,
                            .rms_mps = 0.4,
                            .seconds_used = t_s + 90},
            time);
    publish(camera.spectrum, spectrum(t_s), time);
  }

  static ForceSpectrum spectrum(double t_s) {
    ForceSpectrum spectrum{.trust_low_hz = 0.06F, .trust_high_hz = 3.1F};
    for (int i = 1; i <= 260; ++i) {
      const double f = 0.04 * i;
      const double r = f / kNaturalFrequency_hz;
      const double force = 40 * std::pow(f, -1.7) / (1 + std::pow(f / 4, 4));
      const double gain = 1 / (std::pow(1 - r * r, 2) + std::pow(2 * kDampingRatio * r, 2));
      const double stiffness = std::pow(2 * kPi * kNaturalFrequency_hz, 4);
      const double ripple = std::exp(0.35 * std::sin(13.7 * i + t_s) + 0.3 * std::sin(7.1 * i));
      spectrum.frequency_hz.push_back(static_cast<float>(f));
      spectrum.model_power.push_back(static_cast<float>(force * gain / stiffness));
      spectrum.displacement_power.push_back(static_cast<float>((force * gain / stiffness + 2e-4) * ripple));
      spectrum.force_noise_power.push_back(static_cast<float>(2e-4 * stiffness / gain));
      spectrum.force_power.push_back(static_cast<float>((force + 2e-4 * stiffness / gain) * ripple));
    }
    return spectrum;
  }

  void publish_health(double t_s, HostTime time) {
    const std::scoped_lock lock(mutex_);
    const bool trouble = options_.trouble && t_s > 6;
    const auto frames = static_cast<std::uint64_t>(t_s * 30);
    Health health{.recorder = DeviceState::running, .disk_free_bytes = 212'000'000'000};
    const auto camera = [&](const char* topic, std::uint64_t gaps) {
      health.streams.push_back({topic, {.received = frames, .recorded = frames, .gaps = gaps}, 30.0, 0.01});
    };
    camera("/camera0/image", 0);
    camera("/camera1/image", trouble ? 3 : 0);
    health.streams.push_back({"/sonic/wind",
                              {.received = frames * 2 / 3, .recorded = frames * 2 / 3},
                              trouble ? 0.0 : 20.0,
                              trouble ? t_s - 6 : 0.02});
    health.devices = {
        {"camera0", DeviceState::running, ""}, {"camera1", DeviceState::running, ""}, {"sonic", DeviceState::running, ""}};
    if (trouble) {
      health.devices[2] = {"sonic", DeviceState::reopening,
                           "silent for " + std::to_string(static_cast<int>(t_s) - 6) +
                               " s: check its cable and its power; trying again every 2 s"};
    }
    if (triggered_ && time - *triggered_ > kAfter) {
      triggered_.reset();
      recording_since_.reset();
    }
    if (!recording_since_) health.pre_trigger_s = to_seconds(kPast);
    if (recording_since_) {
      health.recording_phase = triggered_ ? RecordingPhase::post_trigger : RecordingPhase::recording;
      health.recording_cause = triggered_ ? "trigger gust" : "operator";
      if (triggered_) health.recording_ends_s = to_seconds(*triggered_ + kAfter - time);
      health.recording_part = 3;
      health.disk_free_s = trouble ? 400 : 18'600;
      health.copy = {.directory = "/mnt/second", .state = DeviceState::running, .behind_bytes = 12'000'000};
      health.recording_path = "/data/storm-03.mcap";
      health.recording_s = to_seconds(time - *recording_since_);
      health.recorded_bytes = static_cast<std::uint64_t>(health.recording_s * 78e6);
      if (trouble) {
        health.recorder = DeviceState::degraded;
        health.recorder_message = "the disk is slow: 214 MB wait to be written; free space or use a faster disk";
        health.disk_free_bytes = 31'000'000'000;
      }
    }
    publish(health_, health, time);
    for (const char* device : {"camera0", "camera1", "sonic"}) {
      publish(clocks_,
              ClockState{.device = device,
                         .offset_s = 12.5,
                         .offset_sd_s = 8e-5,
                         .frequency_offset_ppm = -11.4,
                         .jitter_s = 2.1e-4,
                         .samples = frames},
              time);
    }
  }

  Options options_;
  StreamTable streams_;
  Player player_;
  std::array<Camera, 2> cameras_;
  StreamId wind_ = 0;
  StreamId fused_ = 0;
  StreamId health_ = 0;
  StreamId clocks_ = 0;
  StreamId actions_ = 0;
  display::DisplayServer* server_ = nullptr;
  HostTime begin_;
  Duration pause_{0};
  std::atomic<std::uint32_t> sequence_{0};
  std::mutex mutex_;
  static constexpr Duration kPast = 10s;   // what a trigger gets of the time before it
  static constexpr Duration kAfter = 20s;  // and after
  std::optional<HostTime> recording_since_;
  std::optional<HostTime> triggered_;
};

Result<Options> parse(int argc, char** argv) {
  Options options;
  options.display.session_name = "display demo";
  options.display.mode = "demo";
  options.display.version = "test";
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  options.display.civil_from_host =
      std::chrono::duration_cast<Duration>(wall) - std::chrono::steady_clock::now().time_since_epoch();
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    const auto value = [&]() -> std::string { return ++i < argc ? argv[i] : ""; };
    if (word == "--port") {
      options.display.port = static_cast<std::uint16_t>(std::stoi(value()));
    } else if (word == "--for") {
      options.seconds = std::stod(value());
    } else if (word == "--web") {
      options.display.web_root = value();
    } else if (word == "--trouble") {
      options.trouble = true;
    } else if (word == "--settling") {
      options.settling = true;
    } else if (word == "--no-target") {
      options.with_target = false;
    } else if (word == "--replay") {
      options.replay = true;
      options.display.mode = "replay";
    } else {
      return Error{ErrorCode::invalid_argument, "unknown option " + std::string(word)};
    }
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  auto options = parse(argc, argv);
  if (!options) {
    std::fprintf(stderr, "display_demo: %s\n", options.error().message.c_str());
    return 2;
  }
  std::signal(SIGINT, [](int) { stop_requested = true; });
  std::signal(SIGTERM, [](int) { stop_requested = true; });
  return Demo(std::move(*options)).run();
}
