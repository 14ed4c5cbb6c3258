#include "bench/program.h"

#include <unistd.h>

#include <fstream>

#include "bench/bench.h"
#include "tests/support/process.h"

namespace roseau::bench {

Workplace::Workplace() : path_(work_directory() / ("roseau-bench-" + std::to_string(getpid()))) {
  std::filesystem::create_directories(path_ / "recordings");
}

Workplace::~Workplace() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

void Workplace::write(const std::string& name, const std::string& text) const { std::ofstream(path_ / name) << text; }

void Workplace::clear_recordings() const {
  std::filesystem::remove_all(path_ / "recordings");
  std::filesystem::create_directories(path_ / "recordings");
}

std::string program_path() { return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "roseau").string(); }

Result<nlohmann::json> run_program(const Workplace& place, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program_path());
  testing::Process process(arguments, place.path());
  const int status = process.wait(std::chrono::seconds(600));
  auto json = nlohmann::json::parse(process.out(), nullptr, false);
  if (status != 0 || json.is_discarded()) {
    return Error{ErrorCode::io, arguments[1] + " ended with status " + std::to_string(status) + ": " + process.err()};
  }
  return json;
}

}  // namespace roseau::bench
