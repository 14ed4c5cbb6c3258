// The whole program on the load it is promised for: two 1280x1024 mono8 cameras at 30/s, 500 features each, a sonic at 20/s,
// recording, estimating, one page connected. Replayed as fast as possible for the real-time factor, then live for drops.

#include <sys/resource.h>

#include <string>

#include "bench/bench.h"
#include "bench/live_client.h"
#include "bench/program.h"

namespace roseau::bench {

namespace {

constexpr const char* kScene = R"(
[[camera]]
width_px = 1280
height_px = 1024
format = "mono8"
focal_length_px = 2000
[[camera]]
width_px = 1280
height_px = 1024
format = "mono8"
focal_length_px = 2000
position_in_world_m = [1.5, -12.0, 1.6]
)";
constexpr const char* kSeconds = "20";
constexpr std::uint16_t kPort = 18420;

double child_cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::uint64_t total(const nlohmann::json& summary, const char* counter) {
  std::uint64_t sum = 0;
  for (const auto& [topic, stream] : summary["streams"].items()) {
    if (!topic.starts_with("/truth")) sum += stream[counter].get<std::uint64_t>();
  }
  return sum;
}

Result<nlohmann::ordered_json> measure() {
  const Workplace place;
  place.write("scene.toml", kScene);
  place.write("live.toml", "[simulation]\nscene = 'scene.toml'\n[estimation]\nimage_plane_direction_deg = 270\n");
  const std::string session = place.file("session.mcap");
  if (auto made = run_program(place, {"simulate", place.file("scene.toml"), "-o", session, "--seconds", kSeconds, "--json"});
      !made) {
    return made.error();
  }
  nlohmann::ordered_json figures;
  figures["case"] = "pipeline";
  {
    const LiveClient viewer(kPort);
    const double before_s = child_cpu_s();
    const auto replay = run_program(
        place, {"replay", session, "--max", "--json", "--port", std::to_string(kPort), "--record", place.file("recordings")});
    if (!replay) return replay.error();
    const double session_s = (*replay)["session"]["duration_s"];
    figures["real_time_factor"] = (*replay)["session"]["speed_ratio"];
    figures["replay_drops_count"] = total(*replay, "dropped");
    figures["replay_cpu_per_session_s"] = (child_cpu_s() - before_s) / session_s;
    for (const auto& [part, cpu_s] : (*replay)["cpu_s"].items()) {
      figures["cpu_of_" + part + "_per_session_s"] = cpu_s.get<double>() / session_s;
    }
    figures["viewer_messages_count"] = viewer.messages();
  }
  place.clear_recordings();
  {
    const LiveClient viewer(kPort);
    const double before_s = child_cpu_s();
    const auto live = run_program(place, {"run", place.file("live.toml"), "--for", kSeconds, "--json", "--port",
                                          std::to_string(kPort), "--record", place.file("recordings")});
    if (!live) return live.error();
    figures["live_drops_count"] = total(*live, "dropped");
    figures["live_gaps_count"] = total(*live, "gaps");
    figures["live_frames_count"] = (*live)["streams"]["/camera0/image"]["received"].get<std::uint64_t>() +
                                   (*live)["streams"]["/camera1/image"]["received"].get<std::uint64_t>();
    figures["live_cpu_with_rendering_per_second_s"] = (child_cpu_s() - before_s) / (*live)["session"]["wall_s"].get<double>();
    figures["live_viewer_messages_count"] = viewer.messages();
  }
  return figures;
}

}  // namespace

void add_pipeline_cases(std::vector<Case>& cases) {
  cases.push_back({"pipeline", "real-time factor and live drops of the whole program, two 1280x1024 cameras", measure});
}

}  // namespace roseau::bench
