// soak: the simulated rig recorded for hours in parts, the oldest deleted: nothing dropped, memory flat, files as large as
// foreseen. How long: --seconds (120 if not given). The course of memory and disk goes to soak.csv in --dir.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "bench/bench.h"
#include "bench/program.h"
#include "tests/support/process.h"

namespace roseau::bench {

namespace {

constexpr std::uint64_t kMiB = 1U << 20U;
constexpr std::uint64_t kPart_mib = 1024;
constexpr std::uint64_t kKept_gib = 4;
constexpr std::chrono::seconds kInterval{5};
// Pools, rings and caches fill in the first minute; after that nothing may grow.
constexpr double kWarm_s = 60;

struct Moment {
  double time_s = 0;
  double rss_mib = 0;
  std::uint64_t recorded_bytes = 0;  // in the folder now
};

double rss_mib(int pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024;
  }
  return 0;
}

std::vector<std::uint64_t> part_sizes(const std::filesystem::path& folder) {
  std::vector<std::pair<std::filesystem::path, std::uint64_t>> parts;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ".mcap") parts.emplace_back(entry.path(), entry.file_size(ignored));
  }
  std::ranges::sort(parts);
  std::vector<std::uint64_t> sizes;
  for (const auto& [path, size] : parts) sizes.push_back(size);
  return sizes;
}

/// Least squares over what came after warming up.
double growth_mib_per_hour(const std::vector<Moment>& course) {
  double n = 0;
  double t = 0;
  double y = 0;
  double tt = 0;
  double ty = 0;
  for (const Moment& moment : course) {
    if (moment.time_s < kWarm_s) continue;
    n += 1;
    t += moment.time_s;
    y += moment.rss_mib;
    tt += moment.time_s * moment.time_s;
    ty += moment.time_s * moment.rss_mib;
  }
  const double spread = n * tt - t * t;
  return spread > 0 ? 3600 * (n * ty - t * y) / spread : 0;
}

std::vector<Moment> watch(testing::Process& program, const std::filesystem::path& folder) {
  std::vector<Moment> course;
  std::ofstream table(work_directory() / "soak.csv");
  table << "time_s,rss_mib,recorded_bytes\n";
  const auto begin = std::chrono::steady_clock::now();
  while (program.running()) {
    Moment moment{.time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
                  .rss_mib = rss_mib(program.pid())};
    for (const std::uint64_t size : part_sizes(folder)) moment.recorded_bytes += size;
    table << moment.time_s << ',' << moment.rss_mib << ',' << moment.recorded_bytes << '\n' << std::flush;
    course.push_back(moment);
    for (auto waited = std::chrono::milliseconds(0); waited < kInterval && program.running();) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      waited += std::chrono::milliseconds(100);
    }
  }
  return course;
}

struct Totals {
  std::uint64_t frames = 0;
  std::uint64_t dropped = 0;
  std::uint64_t gaps = 0;
};

Totals totals(const nlohmann::json& summary) {
  Totals totals;
  for (const auto& [topic, counts] : summary["streams"].items()) {
    if (topic.ends_with("/image")) totals.frames += counts["recorded"].get<std::uint64_t>();
    totals.dropped += counts["dropped"].get<std::uint64_t>();
    totals.gaps += counts["gaps"].get<std::uint64_t>();
  }
  return totals;
}

Result<nlohmann::ordered_json> run() {
  const double seconds = work_seconds().value_or(120);
  const Workplace place;
  place.write("soak.toml", "name = 'soak'\n[simulation]\nscene = '" ROSEAU_SOURCE_DIR
                           "/config/scenes/demo.toml'\n[recording]\n"
                           "at_start = true\ndirectory = 'recordings'\nsplit_mib = " +
                               std::to_string(kPart_mib) +
                               "\nwhen_full = 'oldest'\nkeep_at_most_gib = " + std::to_string(kKept_gib) + "\n");
  testing::Process program({program_path(), "run", place.file("soak.toml"), "--headless", "--json", "--for",
                            std::to_string(static_cast<int>(seconds))},
                           place.path());
  const auto course = watch(program, place.path() / "recordings");
  const int status = program.wait();
  const auto summary = nlohmann::json::parse(program.out(), nullptr, false);
  if (status != 0 || summary.is_discarded()) {
    return Error{ErrorCode::io, "run ended with status " + std::to_string(status) + ": " + program.err()};
  }
  const auto sizes = part_sizes(place.path() / "recordings");
  if (sizes.size() < 2) return Error{ErrorCode::invalid_argument, "too short for two parts: give more --seconds"};
  const auto [least, most] = std::minmax_element(sizes.begin(), sizes.end() - 1);  // the last one is cut short
  const auto warm = std::ranges::find_if(course, [](const Moment& moment) { return moment.time_s >= kWarm_s; });
  const Totals sums = totals(summary);
  std::uint64_t most_kept = 0;
  for (const Moment& moment : course) most_kept = std::max(most_kept, moment.recorded_bytes);
  return nlohmann::ordered_json{
      {"case", "soak"},
      {"duration_s", summary["session"]["duration_s"]},
      {"frames_count", sums.frames},
      {"dropped_count", sums.dropped},
      {"gaps_count", sums.gaps},
      {"rss_warm_mib", warm == course.end() ? course.back().rss_mib : warm->rss_mib},
      {"rss_end_mib", course.size() < 2 ? 0 : course[course.size() - 2].rss_mib},
      {"rss_growth_mib_per_hour", growth_mib_per_hour(course)},
      {"smallest_part_mib", static_cast<double>(*least) / kMiB},
      {"largest_part_mib", static_cast<double>(*most) / kMiB},
      {"reference_part_mib", kPart_mib},
      {"most_kept_gib", static_cast<double>(most_kept) / (1024 * kMiB)},
      {"reference_most_kept_gib", kKept_gib},
      {"cpu_s_per_s", summary["cpu_s"]["process"].get<double>() / summary["session"]["duration_s"].get<double>()},
  };
}

}  // namespace

void add_soak_cases(std::vector<Case>& cases) {
  cases.push_back({"soak", "the rig recorded in parts for --seconds: drops, memory, file sizes", run});
}

}  // namespace roseau::bench
