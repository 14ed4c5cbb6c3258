// roseau-bench CASE [--json] [--dir DIR] [--seconds S]
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "bench/bench.h"

namespace {

std::filesystem::path work_directory_of_run = std::filesystem::temp_directory_path();
std::optional<double> seconds_of_run;

void print_for_people(const nlohmann::ordered_json& figures) {
  for (const auto& [name, value] : figures.items()) std::printf("%-48s %s\n", name.c_str(), value.dump().c_str());
}

void list(const std::vector<roseau::bench::Case>& cases) {
  std::fprintf(stderr, "usage: roseau-bench CASE [--json] [--dir DIR] [--seconds S]\ncases:\n");
  for (const auto& one : cases) std::fprintf(stderr, "  %-12s %s\n", one.name.c_str(), one.what.c_str());
}

}  // namespace

const std::filesystem::path& roseau::bench::work_directory() { return work_directory_of_run; }

std::optional<double> roseau::bench::work_seconds() { return seconds_of_run; }

int main(int argc, char** argv) {
  std::vector<roseau::bench::Case> cases;
  roseau::bench::add_animation_cases(cases);
  roseau::bench::add_chain_cases(cases);
  roseau::bench::add_estimation_cases(cases);
  roseau::bench::add_image_cases(cases);
  roseau::bench::add_mechanics_cases(cases);
  roseau::bench::add_pipeline_cases(cases);
  roseau::bench::add_reading_cases(cases);
  roseau::bench::add_recording_cases(cases);
  roseau::bench::add_soak_cases(cases);
  roseau::bench::add_synthesis_cases(cases);
  roseau::bench::add_tracking_cases(cases);
  roseau::bench::add_wind_cases(cases);

  std::string wanted;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--json") {
      json = true;
    } else if (argument == "--dir" && i + 1 < argc) {
      work_directory_of_run = argv[++i];
    } else if (argument == "--seconds" && i + 1 < argc) {
      seconds_of_run = std::atof(argv[++i]);
    } else if (wanted.empty() && !argument.starts_with("-")) {
      wanted = argument;
    } else {
      list(cases);
      return 2;
    }
  }
  for (const auto& one : cases) {
    if (one.name != wanted) continue;
    auto figures = one.run();
    if (!figures) {
      std::fprintf(stderr, "roseau-bench %s: %s\n", wanted.c_str(), figures.error().message.c_str());
      return 1;
    }
    if (json) {
      std::printf("%s\n", figures->dump().c_str());
    } else {
      print_for_people(*figures);
    }
    return 0;
  }
  list(cases);
  return 2;
}
