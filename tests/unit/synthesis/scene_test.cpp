#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "synthesis/scene.h"
#include "synthesis/scene_fields.h"

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

// Every value of a scene, by its key: "camera 1.rate_hz".
class Collector final : public SceneFields {
 public:
  explicit Collector(std::map<std::string, std::string>& values, std::string place = {})
      : values_(values), place_(std::move(place)) {}

  void number(std::string_view key, double& value, double, double) override { set(key, std::to_string(value * 1e6)); }
  void whole(std::string_view key, std::int64_t& value, std::int64_t, std::int64_t) override {
    set(key, std::to_string(value));
  }
  void flag(std::string_view key, bool& value) override { set(key, value ? "true" : "false"); }
  void text(std::string_view key, std::string& value) override { set(key, value); }
  void word(std::string_view key, std::string& value, std::span<const std::string_view>) override { set(key, value); }
  void point(std::string_view key, Vec3& value) override {
    set(key, std::to_string(value.x) + " " + std::to_string(value.y) + " " + std::to_string(value.z));
  }
  void numbers(std::string_view key, std::vector<double>& values) override {
    std::string all;
    for (const double value : values) all += std::to_string(value) + " ";
    set(key, all);
  }
  void require(bool, std::string_view, const std::string&) override {}
  void section(std::string_view name, const std::function<void(SceneFields&)>& describe) override {
    Collector inside(values_, place_ + std::string(name) + ".");
    describe(inside);
  }

 protected:
  std::size_t list_size(std::string_view, std::size_t present, std::size_t, std::size_t) override { return present; }
  void item(std::string_view name, std::size_t index, const std::function<void(SceneFields&)>& describe) override {
    section(std::string(name) + " " + std::to_string(index), describe);
  }

 private:
  void set(std::string_view key, std::string value) {
    EXPECT_TRUE(values_.emplace(place_ + std::string(key), std::move(value)).second) << key << " is described twice";
  }
  std::map<std::string, std::string>& values_;
  std::string place_;
};

const Scene& demo_scene() {
  static const Scene scene;
  return scene;
}

std::map<std::string, std::string> values(const Scene& described) {
  Scene scene = described;
  std::map<std::string, std::string> all;
  Collector collector(all);
  describe(scene, collector);
  return all;
}

void expect_same(const Scene& a, const Scene& b) { EXPECT_EQ(values(a), values(b)); }

TEST(Scene, TheShippedFilesAreTheScenesInCode) {
  const auto demo = scene_from_toml(shipped("demo.toml"), "demo.toml");
  ASSERT_TRUE(demo) << demo.error().message;
  expect_same(*demo, demo_scene());
  const auto large = scene_from_toml(shipped("large_cameras.toml"), "large_cameras.toml");
  ASSERT_TRUE(large) << large.error().message;
  expect_same(*large, large_camera_scene());
  EXPECT_TRUE(check(demo_scene()));
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
  EXPECT_GT(lines.size(), 120U);
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
  const std::map<std::string, std::string> others = {{"format", "\"mono8\""},      {"lens", "\"opencv4\""},
                                                     {"stamps", "\"device\""},     {"load", "\"projection\""},
                                                     {"kind", "\"cantilever\""},   {"stepping", "\"semi_implicit\""},
                                                     {"spectrum", "\"kaimal\""},   {"profile", "\"logarithmic\""},
                                                     {"unit", "\"inch\""},         {"items", "\"2,4,1\""},
                                                     {"name", "\"crown\""},        {"rate_hz", "16"},
                                                     {"station_count", "3"},       {"file", "\"\""},
                                                     {"topic", "\"/sonic/wind\""}, {"branching_orders", "2"}};
  for (const Line& line : key_lines(text)) {
    std::string changed = line.value;
    if (line.key == "file" || line.value == "[]") continue;  // say nothing by themselves
    if (const auto other = others.find(line.key); other != others.end()) {
      changed = other->second;
    } else if (line.value == "true" || line.value == "false") {
      changed = line.value == "true" ? "false" : "true";
    } else if (line.value.starts_with('[')) {
      changed.insert(changed.size() - 1, "1");  // the last number's decimals
    } else if (line.value.find('.') != std::string::npos) {
      changed = std::to_string(std::stod(line.value) * 1.01 + 1e-5);
    } else {
      changed = std::to_string(std::stoll(line.value) + 1);
    }
    std::string edited = text;
    edited.replace(line.begin, line.key.size() + 3 + line.value.size(), line.key + " = " + changed);
    const auto scene = scene_from_toml(edited, "s.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    const auto before = values(demo_scene());
    const auto after = values(*scene);
    ASSERT_EQ(before.size(), after.size());
    int differing = 0;
    for (const auto& [key, value] : after) differing += before.at(key) != value ? 1 : 0;
    EXPECT_EQ(differing, 1) << line.key << " = " << changed;
  }
}

TEST(Scene, TheDemosFileNamesEveryKey) {
  const auto scene = scene_from_toml(shipped("demo.toml"), "demo.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  std::set<std::string> named;
  for (const Line& line : key_lines(shipped("demo.toml"))) named.insert(line.key);
  for (const auto& [key, value] : values(demo_scene())) {
    EXPECT_TRUE(named.contains(key.substr(key.rfind('.') + 1))) << key << " is not in config/scenes/demo.toml";
  }
}

TEST(Scene, EveryShippedSceneIsOne) {
  std::size_t scenes = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(ROSEAU_SOURCE_DIR) / "config" / "scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const auto scene = scene_from_toml(shipped(entry.path().filename()), entry.path().filename());
    EXPECT_TRUE(scene) << scene.error().message;
    ++scenes;
  }
  EXPECT_GE(scenes, 9U);
}

TEST(Scene, AnEmptyFileIsTheDemo) {
  const auto scene = scene_from_toml("", "s.toml");
  ASSERT_TRUE(scene);
  expect_same(*scene, demo_scene());
}

TEST(Scene, NonsenseIsNamedWithItsLine) {
  const auto message = [](const std::string& text) {
    const auto scene = scene_from_toml(text, "s.toml");
    return scene ? std::string("accepted") : scene.error().message;
  };
  EXPECT_THAT(message("[drag]\nair_density_kg_m3 = -1\n"), HasSubstr("s.toml:2: 'drag.air_density_kg_m3' must be between"));
  EXPECT_THAT(message("[wind]\n\nmean_speed_mps = -4\n"), HasSubstr("s.toml:3: 'wind.mean_speed_mps' must be between"));
  EXPECT_THAT(message("[sonic]\nrate_hz = 7\n"), HasSubstr("must be one of a WindMaster's"));
  EXPECT_THAT(message("[sonic]\nbaud = 9600\n"), HasSubstr("s.toml:2: 'sonic.baud' must be at least 10600"));
  EXPECT_THAT(message("[[camera]]\n[[camera]]\nformat = 'yuyv'\n"), HasSubstr("s.toml:3:"));
  EXPECT_THAT(message("[[camera]]\nformat = 'mono16'\n"), HasSubstr("must be one of bgr8, rgb8, mono8"));
  EXPECT_THAT(message("[[camera]]\nwidth_px = 5\n"), HasSubstr("s.toml:2:"));
  EXPECT_THAT(message("[[camera]]\nposition_in_world_m = [0, 20, 1]\n"), HasSubstr("to the north of the camera"));
  EXPECT_THAT(message("[[camera]]\nexposure_duration_s = 0.1\n"), HasSubstr("longer than the time between two frames"));
  EXPECT_THAT(message("[[camera]]\nline_delay_s = 0.001\n"), HasSubstr("rows take longer"));
  EXPECT_THAT(message("[[camera]]\ndistortion = [0.1]\n"), HasSubstr("at most 0 numbers for lens pinhole"));
  EXPECT_THAT(message("[tree]\nkind = 'file'\n"), HasSubstr("must be given when kind is"));
  EXPECT_THAT(message("[tree]\nfile = 'oak.mtg'\n"), HasSubstr("must be given when kind is"));
  EXPECT_THAT(message("[[pull]]\nstart_s = 9\n"), HasSubstr("after start_s"));
  EXPECT_THAT(message("[[target]]\n[[target]]\n"), HasSubstr("another target's"));
  EXPECT_THAT(message("[balls]\nnear_in_world_m = [1, 2]\n"), HasSubstr("three numbers"));
  EXPECT_THAT(message("[bar_rig]\nvolume_low_in_world_m = [3, 0, 0]\n"), HasSubstr("volume_low_in_world_m in each"));
  EXPECT_THAT(message("[led_board]\ncable_pulls_s = [3, 2]\n"), HasSubstr("ascending"));
  EXPECT_THAT(message("[[wind.gust]]\nshape = 'square'\n"), HasSubstr("one_minus_cos, ramp"));
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
