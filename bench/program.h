// Running the real program from a case, in a folder that goes with the case.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/result.h"

namespace roseau::bench {

/// Everything a case writes, removed at its end.
class Workplace {
 public:
  Workplace();
  ~Workplace();
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  void write(const std::string& name, const std::string& text) const;
  /// An empty folder "recordings".
  void clear_recordings() const;

 private:
  std::filesystem::path path_;
};

/// `roseau` of the same build.
std::string program_path();

/// `roseau` with these arguments, of the same build; what it printed with --json. Error: its status and what it said.
Result<nlohmann::json> run_program(const Workplace& place, std::vector<std::string> arguments);

}  // namespace roseau::bench
