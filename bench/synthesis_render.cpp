// What a simulated frame costs: the rig must leave the machine to what it tests.
#include <time.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "structure/tree/grown_tree.h"
#include "synthesis/render/backdrop.h"
#include "synthesis/render/frame_renderer.h"
#include "synthesis/render/scene_painter.h"
#include "synthesis/render/sensor.h"

namespace roseau::bench {

namespace {

constexpr int kFrames = 150;
constexpr double kRate_hz = 30;
constexpr double kExposure_s = 0.004;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// CPU of this thread, the mean of many calls with the frame's number.
template <class Call>
double mean_ms(const Call& call) {
  const double start_s = cpu_seconds();
  for (int frame = 0; frame < kFrames; ++frame) call(frame);
  return 1e3 * (cpu_seconds() - start_s) / kFrames;
}

// The default tree with four balls on its southern branches, LED board, sonic; the camera of the demo.
Result<std::shared_ptr<const render::VisibleScene>> demo_scene() {
  Result<structure::TreeModel> tree = structure::grow_tree({});
  if (!tree) return tree.error();
  render::SceneDescription description;
  const std::size_t nodes = tree->nodes.size();
  for (std::size_t ball = 0; ball < render::kMarkerColours.size(); ++ball) {
    description.balls.push_back({.node = static_cast<std::uint32_t>(nodes * (2 * ball + 1) / 8),
                                 .offset_m = {0, -0.08, 0},
                                 .colour = render::kMarkerColours.at(ball)});
  }
  description.tree = std::move(*tree);
  description.led_board = render::LedBoard{.centre_in_world_m = {0, -7, 1.15}};
  description.sonic = render::SonicMast{{2.6, 0.2, 3.0}};
  return render::VisibleScene::create(std::move(description));
}

calib::CameraModel demo_camera(std::uint32_t width, std::uint32_t height) {
  return calib::look_at(width, height, 2.1 * height, {-1.5, -12, 1.7}, {0, 0, 2.85});
}

// Every node sways, so that no element stands still.
void sway(const structure::TreeModel& tree, double time_s, render::SceneMoment& moment) {
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const double z = tree.nodes[i].position_m.z;
    const double sway_m = 0.004 * z * z * std::sin(7 * time_s + 0.3 * z);
    moment.displacement_m[i] = {sway_m, 0.3 * sway_m, 0};
    moment.rotation_rad[i] = {0, 0.5 * sway_m, 0};
  }
  moment.board_time_s = 100 + time_s;
}

Result<void> measure_frames(const std::shared_ptr<const render::VisibleScene>& scene, const calib::CameraModel& camera,
                            PixelFormat format, const std::string& name, nlohmann::ordered_json& figures) {
  const double begin_s = cpu_seconds();
  Result<render::FrameRenderer> renderer = render::FrameRenderer::create(scene, camera, {.format = format});
  if (!renderer) return renderer.error();
  figures["setup_" + name + "_ms"] = 1e3 * (cpu_seconds() - begin_s);
  std::vector<std::byte> pixels(renderer->frame_bytes());
  const render::MomentAt moment_at = [&scene](double t, render::SceneMoment& moment) { sway(scene->tree(), t, moment); };
  renderer->render(0, 0, kExposure_s, moment_at, pixels);
  const double frame_ms = mean_ms([&](int frame) {
    renderer->render(static_cast<std::uint64_t>(frame), frame / kRate_hz, kExposure_s, moment_at, pixels);
  });
  figures["frame_" + name + "_ms"] = frame_ms;
  figures["rate_" + name + "_hz"] = 1e3 / frame_ms;
  return {};
}

// Where a frame's time goes, stage by stage.
void measure_stages(const render::VisibleScene& scene, const calib::CameraModel& camera, PixelFormat format,
                    const std::string& name, nlohmann::ordered_json& figures) {
  const render::InkMaker ink(format);
  const calib::Projection projection(camera);
  render::Picture picture(static_cast<int>(camera.width), static_cast<int>(camera.height), ink.channels());
  render::Backdrop backdrop(scene, projection, ink);
  render::ScenePainter painter(scene, projection, ink);
  render::Coverage coverage(picture.width, picture.height);
  render::Sensor sensor({.format = format}, picture.width, picture.height, ink.channels());
  render::SceneMoment moment = scene.rest();
  std::vector<std::byte> pixels(picture.steps.size());
  figures["backdrop_" + name + "_ms"] = mean_ms([&](int frame) { backdrop.paint(frame / kRate_hz, 1, picture); });
  figures["pose_" + name + "_ms"] = mean_ms([&](int frame) {
    sway(scene.tree(), frame / kRate_hz, moment);
    painter.pose(moment, {.start_ticks = 2e5 + 66.7 * frame, .duration_ticks = 8});
  });
  figures["draw_" + name + "_ms"] = mean_ms([&](int) {
    painter.draw(coverage, picture, {0, 0, picture.width, picture.height});
  });
  figures["sensor_" + name + "_ms"] =
      mean_ms([&](int frame) { sensor.read_out(picture, 1, static_cast<std::uint64_t>(frame), pixels); });
}

Result<nlohmann::ordered_json> render_case() {
  nlohmann::ordered_json figures{{"case", "render"}};
  const double begin_s = cpu_seconds();
  const Result<std::shared_ptr<const render::VisibleScene>> scene = demo_scene();
  if (!scene) return scene.error();
  figures["setup_scene_ms"] = 1e3 * (cpu_seconds() - begin_s);
  figures["segments_count"] = (*scene)->tree().segment_count();
  figures["leaves_count"] = (*scene)->leaves().size();
  const calib::CameraModel small = demo_camera(640, 480);
  const calib::CameraModel large = demo_camera(1280, 1024);
  const std::vector<std::tuple<calib::CameraModel, PixelFormat, std::string>> cameras{
      {small, PixelFormat::bgr8, "640x480_bgr8"},
      {small, PixelFormat::mono8, "640x480_mono8"},
      {large, PixelFormat::mono8, "1280x1024_mono8"},
      {large, PixelFormat::bgr8, "1280x1024_bgr8"}};
  for (const auto& [camera, format, name] : cameras) {
    if (const Result<void> measured = measure_frames(*scene, camera, format, name, figures); !measured) return measured.error();
    measure_stages(**scene, camera, format, name, figures);
  }
  // The demo: two such cameras at 30 Hz. Below 100 they are drawn in real time on one core.
  figures["demo_core_percent"] = 100 * 2 * kRate_hz * figures["frame_640x480_bgr8_ms"].get<double>() * 1e-3;
  return figures;
}

}  // namespace

void add_synthesis_cases(std::vector<Case>& cases) {
  cases.push_back({"render", "CPU per frame of the simulated cameras", render_case});
}

}  // namespace roseau::bench
