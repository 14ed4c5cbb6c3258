// What a simulated frame costs: the rig must leave the machine to what it tests.
#include <time.h>

#include <array>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "synthesis/camera/frame_renderer.h"
#include "synthesis/rig/world.h"

namespace roseau::bench {

namespace {

constexpr int kFrames = 200;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// CPU of this thread per frame with the branch moving as it does in the scene, and once to set up.
void measure(const synthesis::Scene& scene, const std::string& name, nlohmann::ordered_json& figures) {
  const double begin_s = cpu_seconds();
  synthesis::FrameRenderer renderer(scene, 0);
  const double ready_s = cpu_seconds();
  synthesis::BranchMotion branch = synthesis::World(scene).branch_motion();
  std::vector<std::byte> pixels(renderer.frame_bytes());
  const double start_s = cpu_seconds();
  for (int frame = 0; frame < kFrames; ++frame) {
    const std::array deflection_m{branch.deflection_m(frame / scene.cameras[0].rate_hz)};
    renderer.render(deflection_m, static_cast<std::uint64_t>(frame), pixels);
  }
  figures["frame_" + name + "_ms"] = 1e3 * (cpu_seconds() - start_s) / kFrames;
  figures["setup_" + name + "_ms"] = 1e3 * (ready_s - begin_s);
}

Result<nlohmann::ordered_json> render() {
  nlohmann::ordered_json figures{{"case", "render"}};
  synthesis::Scene small;
  synthesis::Scene large = synthesis::large_camera_scene();
  measure(small, "640x480_bgr8", figures);
  small.cameras[0].format = PixelFormat::mono8;
  measure(small, "640x480_mono8", figures);
  measure(large, "1280x1024_mono8", figures);
  large.cameras[0].format = PixelFormat::bgr8;
  measure(large, "1280x1024_bgr8", figures);
  return figures;
}

}  // namespace

void add_synthesis_cases(std::vector<Case>& cases) {
  cases.push_back({"render", "CPU per frame of the simulated cameras", render});
}

}  // namespace roseau::bench
