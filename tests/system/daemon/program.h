// The real program, run to its end, and what it said.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace roseau::testing {

struct Ran {
  int status = 0;
  std::string out;
  std::string err;
  nlohmann::json json() const {
    auto parsed = nlohmann::json::parse(out, nullptr, false);
    EXPECT_FALSE(parsed.is_discarded()) << "not JSON: " << out << "\n" << err;
    return parsed;
  }
};

class ProgramTest : public ::testing::Test {
 protected:
  static std::vector<std::string> command(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), ROSEAU_PROGRAM);
    return arguments;
  }
  Ran run(std::vector<std::string> arguments) const {
    Process process(command(std::move(arguments)), folder_.path());
    Ran ran;
    ran.status = process.wait();
    ran.out = process.out();
    ran.err = process.err();
    return ran;
  }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  /// A scene with small pictures, so that it is quick.
  std::string small_scene() const {
    const std::string camera = "[[camera]]\nwidth_px = 320\nheight_px = 240\nfocal_length_px = 400\n";
    return folder_.write("scene.toml", camera + camera);
  }
  std::string simulate(const std::string& name, const std::string& seconds) const {
    const auto ran = run({"simulate", small_scene(), "-o", path(name), "--seconds", seconds, "--seed", "7"});
    EXPECT_EQ(ran.status, 0) << ran.err;
    return path(name);
  }
  /// A configuration that runs the small scene live.
  std::string live_config(const std::string& more = "") const {
    small_scene();
    return folder_.write("live.toml", "[simulation]\nscene = 'scene.toml'\n" + more);
  }
  /// The one session file in a folder.
  static std::string session_in(const std::filesystem::path& folder) {
    std::string found;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".mcap") found = entry.path().string();
    }
    EXPECT_FALSE(found.empty()) << "nothing was recorded";
    return found;
  }

  const TemporaryFolder folder_;
};

}  // namespace roseau::testing
