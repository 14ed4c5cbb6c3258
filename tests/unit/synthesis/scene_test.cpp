#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "synthesis/scene.h"

namespace roseau::synthesis {
namespace {

using ::testing::HasSubstr;

std::string shipped(const std::string& name) {
  const std::filesystem::path path = std::filesystem::path(ROSEAU_SOURCE_DIR) / "config" / "scenes" / name;
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// Every value of a scene in a row.
std::vector<double> values(const Scene& scene) {
  std::vector<double> all;
  const auto add = [&all](std::initializer_list<double> more) { all.insert(all.end(), more); };
  const auto add_point = [&add](const Vec3& point) { add({point.x, point.y, point.z}); };
  const auto add_timing = [&add](const DeviceTiming& timing) {
    add({timing.frequency_offset_ppm, timing.start_offset_s, timing.latency_s, timing.jitter_s});
  };
  const TurbulentWindOptions& wind = scene.wind;
  add({static_cast<double>(scene.seed), wind.mean_speed_mps, wind.direction_from_deg, wind.turbulence_intensity,
       wind.across_sd_ratio, wind.vertical_sd_ratio, wind.length_scale_m, wind.across_length_scale_m, wind.lateral_decay,
       wind.reference_height_m, wind.profile_exponent});
  const BranchScene& branch = scene.branch;
  add({branch.natural_frequency_hz, branch.damping_ratio, branch.drag_exponent, branch.mean_deflection_m, branch.length_m});
  add_point(branch.root_in_world_m);
  for (const CameraScene& camera : scene.cameras) {
    add({static_cast<double>(camera.width_px), static_cast<double>(camera.height_px), static_cast<double>(camera.format),
         camera.focal_length_px, camera.rate_hz, camera.exposure_duration_s, static_cast<double>(camera.exposure_taps),
         camera.read_noise_counts, camera.shot_noise_gain});
    add_point(camera.position_in_world_m);
    add_point(camera.look_at_in_world_m);
    add_timing(camera.timing);
  }
  const SonicScene& sonic = scene.sonic;
  add_point(sonic.position_in_world_m);
  add({sonic.north_offset_deg, sonic.rate_hz, sonic.baud, sonic.noise_mps, sonic.air_temperature_celsius,
       sonic.temperature_noise_celsius, sonic.split_probability});
  add_timing(sonic.timing);
  add({scene.truth.enabled ? 1.0 : 0.0, scene.truth.wind_rate_hz});
  return all;
}

void expect_same(const Scene& a, const Scene& b) { EXPECT_EQ(values(a), values(b)); }

TEST(Scene, TheShippedFilesAreTheScenesInCode) {
  const auto demo = scene_from_toml(shipped("demo.toml"), "demo.toml");
  ASSERT_TRUE(demo) << demo.error().message;
  expect_same(*demo, Scene{});
  const auto large = scene_from_toml(shipped("large_cameras.toml"), "large_cameras.toml");
  ASSERT_TRUE(large) << large.error().message;
  expect_same(*large, large_camera_scene());
  EXPECT_TRUE(check(Scene{}));
  EXPECT_TRUE(check(large_camera_scene()));
}

struct Line {
  std::size_t begin = 0;  // in the file
  std::string key;
  std::string value;
};

std::vector<Line> key_lines(const std::string& text) {
  std::vector<Line> lines;
  for (std::size_t begin = 0; begin < text.size(); begin = text.find('\n', begin) + 1) {
    const std::string line = text.substr(begin, text.find('\n', begin) - begin);
    const std::size_t equals = line.find(" = ");
    if (line.starts_with('#') || equals == std::string::npos) continue;
    std::string value = line.substr(equals + 3);
    value = value.substr(0, value.find('#'));
    value.erase(value.find_last_not_of(' ') + 1);
    lines.push_back({begin, line.substr(0, equals), value});
  }
  return lines;
}

TEST(Scene, AMisspeltKeyIsAnErrorWhicheverItIs) {
  const std::string text = shipped("demo.toml");
  const auto lines = key_lines(text);
  EXPECT_GT(lines.size(), 45U);
  for (const Line& line : lines) {
    std::string misspelt = text;
    misspelt.replace(line.begin, line.key.size(), line.key + "x");
    const auto scene = scene_from_toml(misspelt, "s.toml");
    ASSERT_FALSE(scene) << line.key;
    EXPECT_THAT(scene.error().message, HasSubstr("'" + line.key + "x'"));
  }
}

TEST(Scene, EachKeyGoesWhereItBelongs) {
  const std::string text = shipped("demo.toml");
  const std::map<std::string, std::string> others = {{"format", "\"mono8\""}, {"enabled", "false"}, {"exposure_taps", "4"},
                                                     {"width_px", "320"},     {"height_px", "240"}, {"seed", "7"},
                                                     {"rate_hz", "16"},       {"baud", "57600"}};
  for (const Line& line : key_lines(text)) {
    std::string changed = line.value;
    if (const auto other = others.find(line.key); other != others.end()) {
      changed = other->second;
    } else if (line.value.starts_with('[')) {
      changed.insert(changed.size() - 1, "1");  // the last number's decimals
    } else {
      changed = std::to_string(std::stod(line.value) * 1.01 + 1e-4);
    }
    std::string edited = text;
    edited.replace(line.begin, line.key.size() + 3 + line.value.size(), line.key + " = " + changed);
    const auto scene = scene_from_toml(edited, "s.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    const auto before = values(Scene{});
    const auto after = values(*scene);
    int differing = 0;
    for (std::size_t i = 0; i < before.size(); ++i) differing += before[i] != after[i] ? 1 : 0;
    EXPECT_EQ(differing, 1) << line.key << " = " << changed;
  }
}

TEST(Scene, AnEmptyFileIsTheDemo) {
  const auto scene = scene_from_toml("", "s.toml");
  ASSERT_TRUE(scene);
  expect_same(*scene, Scene{});
}

TEST(Scene, NonsenseIsNamedWithItsLine) {
  const auto message = [](const std::string& text) {
    const auto scene = scene_from_toml(text, "s.toml");
    return scene ? std::string("accepted") : scene.error().message;
  };
  EXPECT_THAT(message("[branch]\ndamping_ratio = 0\n"), HasSubstr("s.toml:2: 'branch.damping_ratio' must be between"));
  EXPECT_THAT(message("[wind]\n\nmean_speed_mps = -4\n"), HasSubstr("s.toml:3: 'wind.mean_speed_mps' must be between"));
  EXPECT_THAT(message("[sonic]\nrate_hz = 7\n"), HasSubstr("must be one of a WindMaster's"));
  EXPECT_THAT(message("[sonic]\nbaud = 9600\n"), HasSubstr("s.toml:2: 'sonic.baud' must be at least 10600"));
  EXPECT_THAT(message("[[camera]]\n[[camera]]\nformat = 'yuyv'\n"), HasSubstr("s.toml:3:"));
  EXPECT_THAT(message("[[camera]]\nformat = 'mono16'\n"), HasSubstr("must be one of bgr8, rgb8, mono8"));
  EXPECT_THAT(message("[[camera]]\nwidth_px = 5\n"), HasSubstr("s.toml:2:"));
  EXPECT_THAT(message("[[camera]]\nposition_in_world_m = [0, 0, 1]\n"), HasSubstr("at least 1 m south of the branch"));
  EXPECT_THAT(message("[[camera]]\nexposure_duration_s = 0.1\n"), HasSubstr("'camera"));
  EXPECT_THAT(message("[truth]\nwind_rate_hz = 0\n"), HasSubstr("s.toml:2:"));
  EXPECT_THAT(message("seed = -1\n"), HasSubstr("s.toml:1:"));
}

TEST(Scene, NonsenseMadeInCodeIsNamedToo) {
  Scene scene;
  scene.cameras[1].rate_hz = 0;
  const auto checked = check(scene);
  ASSERT_FALSE(checked);
  EXPECT_THAT(checked.error().message, HasSubstr("camera 1: rate_hz must be between"));
  scene.cameras.clear();
  EXPECT_FALSE(check(scene));
}

}  // namespace
}  // namespace roseau::synthesis
