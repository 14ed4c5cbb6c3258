// The file is taken apart here strictly by the rules of glTF 2.0; tests/system/gltf puts Khronos's own validator on it.
#include "structure/tree/gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "structure/tree/cantilever.h"
#include "structure/tree/grown_tree.h"
#include "structure/tree/tree_mesh.h"
#include "structure/tree/vector3.h"
#include "tests/support/temporary_folder.h"

namespace roseau::structure {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

/// A .glb taken apart, with every rule checked on the way.
struct Glb {
  Json json;
  std::vector<std::byte> binary;

  explicit Glb(const std::vector<std::byte>& file) {
    const auto word = [&](std::size_t at) {
      std::uint32_t value = 0;
      EXPECT_LE(at + 4, file.size());
      std::memcpy(&value, file.data() + at, 4);
      return value;
    };
    EXPECT_EQ(std::memcmp(file.data(), "glTF", 4), 0);
    EXPECT_EQ(word(4), 2U);
    EXPECT_EQ(word(8), file.size());
    const std::size_t json_size = word(12);
    EXPECT_EQ(std::memcmp(file.data() + 16, "JSON", 4), 0);
    EXPECT_EQ(json_size % 4, 0U);
    json = Json::parse(reinterpret_cast<const char*>(file.data()) + 20,
                       reinterpret_cast<const char*>(file.data()) + 20 + json_size);
    const std::size_t binary_at = 20 + json_size;
    EXPECT_EQ(word(binary_at) % 4, 0U);
    EXPECT_EQ(std::memcmp(file.data() + binary_at + 4, "BIN\0", 4), 0);
    EXPECT_EQ(binary_at + 8 + word(binary_at), file.size());
    binary.assign(file.begin() + static_cast<std::ptrdiff_t>(binary_at + 8), file.end());
    EXPECT_EQ(json["asset"]["version"], "2.0");
    EXPECT_EQ(json["buffers"].size(), 1U);
    EXPECT_EQ(json["buffers"][0]["byteLength"], binary.size());
  }

  template <class T>
  std::vector<T> read(int accessor_index) const {
    const auto& accessor = json["accessors"].at(static_cast<std::size_t>(accessor_index));
    const auto& view = json["bufferViews"].at(accessor["bufferView"].get<std::size_t>());
    const auto count = accessor["count"].get<std::size_t>();
    const auto offset = view["byteOffset"].get<std::size_t>();
    EXPECT_EQ(offset % 4, 0U);
    EXPECT_EQ(view["byteLength"].get<std::size_t>(), count * sizeof(T));
    EXPECT_LE(offset + count * sizeof(T), binary.size());
    std::vector<T> values(count);
    std::memcpy(values.data(), binary.data() + offset, count * sizeof(T));
    return values;
  }
  std::vector<std::array<float, 3>> vectors(int accessor) const {
    EXPECT_EQ(json["accessors"][static_cast<std::size_t>(accessor)]["componentType"], 5126);
    EXPECT_EQ(json["accessors"][static_cast<std::size_t>(accessor)]["type"], "VEC3");
    return read<std::array<float, 3>>(accessor);
  }
};

Vec3 to_vec3(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

Glb written(const TreeModel& tree, const GltfOptions& options = {}, const GltfMotion& motion = {}) {
  const auto file = to_glb(tree, options, motion);
  EXPECT_TRUE(file) << file.error().message;
  return Glb(*file);
}

void expect_sound_primitive(const Glb& glb, const Json& primitive) {
  const auto positions = glb.vectors(primitive["attributes"]["POSITION"]);
  const auto normals = glb.vectors(primitive["attributes"]["NORMAL"]);
  const auto indices = glb.read<std::uint32_t>(primitive["indices"]);
  ASSERT_EQ(normals.size(), positions.size());
  ASSERT_EQ(indices.size() % 3, 0U);
  for (const auto& normal : normals) ASSERT_NEAR(norm(to_vec3(normal)), 1, 1e-5);
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    ASSERT_LT(*std::max_element(indices.begin() + static_cast<std::ptrdiff_t>(i),
                                indices.begin() + static_cast<std::ptrdiff_t>(i) + 3),
              positions.size());
    const Vec3 a = to_vec3(positions[indices[i]]);
    const Vec3 face = cross(to_vec3(positions[indices[i + 1]]) - a, to_vec3(positions[indices[i + 2]]) - a);
    Vec3 smooth;
    for (std::size_t k = 0; k < 3; ++k) smooth = smooth + to_vec3(normals[indices[i + k]]);
    // Anticlockwise from outside; slivers of no area at tight bends say nothing.
    if (norm(face) > 1e-9) {
      ASSERT_GT(dot(face, smooth) / norm(face), -0.2) << "triangle " << i / 3;
    }
  }
  const auto& accessor = glb.json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [low, high] =
        std::minmax_element(positions.begin(), positions.end(), [k](auto& p, auto& q) { return p[k] < q[k]; });
    EXPECT_EQ(accessor["min"][k].get<float>(), (*low)[k]);
    EXPECT_EQ(accessor["max"][k].get<float>(), (*high)[k]);
  }
}

TEST(Gltf, GrownTreeIsSoundInEveryPart) {
  const auto tree = grow_tree({.seed = 6, .leaf_count = 500});
  const Glb glb = written(*tree);
  const auto& mesh = glb.json["meshes"][0];
  ASSERT_EQ(mesh["primitives"].size(), 2U);
  for (const auto& primitive : mesh["primitives"]) expect_sound_primitive(glb, primitive);
  EXPECT_EQ(glb.json["materials"][0]["name"], "bark");
  EXPECT_EQ(glb.json["materials"][1]["doubleSided"], true);
  EXPECT_FALSE(glb.json.contains("animations"));
  EXPECT_EQ(glb.read<std::uint32_t>(mesh["primitives"][1]["indices"]).size(), 500U * 12);
  // y is up: the tree is as high as it is told to be, and its foot at zero.
  const auto& bark = glb.json["accessors"][mesh["primitives"][0]["attributes"]["POSITION"].get<std::size_t>()];
  EXPECT_NEAR(bark["max"][1].get<double>(), 5.5, 0.03);
  EXPECT_NEAR(bark["min"][1].get<double>(), 0, 0.03);
}

TEST(Gltf, TubeOfAConeHasItsSurfaceAndLeansItsNormals) {
  const auto cone =
      cantilever({.length_m = 1, .start_radius_m = 0.2, .end_radius_m = 0.1, .segment_count = 4, .direction = {0, 1, 0}});
  const Glb glb = written(*cone, {.sides = 12});
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  expect_sound_primitive(glb, primitive);
  const auto positions = glb.vectors(primitive["attributes"]["POSITION"]);
  const auto normals = glb.vectors(primitive["attributes"]["NORMAL"]);
  ASSERT_EQ(positions.size(), 5U * 12 + 1);
  for (std::size_t i = 0; i < 60; ++i) {
    // North is -z.
    const double along = -positions[i][2];
    EXPECT_NEAR(std::hypot(positions[i][0], positions[i][1]), 0.2 - 0.1 * along, 1e-6);
    EXPECT_NEAR(-normals[i][2], 0.1 / std::hypot(1, 0.1), 1e-6);
  }
}

TEST(Gltf, JumpOfTheRadiusHasTwoRings) {
  auto pole = *cantilever({.segment_count = 2});
  EXPECT_EQ(bark_mesh(pole, 8).vertices.size(), 3U * 8 + 1);
  pole.nodes[2].start_radius_m = pole.nodes[2].end_radius_m = 0.01;
  EXPECT_EQ(bark_mesh(pole, 8).vertices.size(), 4U * 8 + 1);
}

TEST(Gltf, ShapesBecomeTargetsAndWeightsAnAnimation) {
  const auto pole = cantilever({.length_m = 2, .segment_count = 4, .board_leaves = 1});
  GltfMotion motion{.shape_names = {"sway", "lift"}, .times_s = {0, 0.5, 1}, .weights = {0, 0, 1, 0.5, 0, 1}};
  motion.shapes_m.resize(2);
  for (const auto& node : pole->nodes) {
    motion.shapes_m[0].push_back({0.1 * node.position_m.z, 0, 0});  // leans east, all of one piece
    motion.shapes_m[1].push_back({0, 0, 0.3});
  }
  const Glb glb = written(*pole, {}, motion);
  const auto& mesh = glb.json["meshes"][0];
  EXPECT_EQ(mesh["weights"].size(), 2U);
  EXPECT_EQ(mesh["extras"]["targetNames"][1], "lift");
  for (const auto& primitive : mesh["primitives"]) {
    ASSERT_EQ(primitive["targets"].size(), 2U);
    const auto positions = glb.vectors(primitive["attributes"]["POSITION"]);
    const auto sway = glb.vectors(primitive["targets"][0]["POSITION"]);
    const auto lift = glb.vectors(primitive["targets"][1]["POSITION"]);
    ASSERT_EQ(sway.size(), positions.size());
    const bool is_leaf = primitive["material"] == 1;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      // A leaf turns with its pole; bark is carried along by its nodes.
      if (is_leaf) {
        EXPECT_NEAR(sway[i][0], 0.1 * positions[i][1], 1e-6);
        EXPECT_NEAR(sway[i][1], -0.1 * positions[i][0], 1e-6);
      }
      EXPECT_NEAR(lift[i][1], 0.3, 1e-6);
    }
  }
  ASSERT_EQ(glb.json["animations"].size(), 1U);
  const auto& animation = glb.json["animations"][0];
  EXPECT_EQ(animation["channels"][0]["target"]["path"], "weights");
  EXPECT_EQ(glb.read<float>(animation["samplers"][0]["input"]), (std::vector<float>{0, 0.5, 1}));
  EXPECT_EQ(glb.read<float>(animation["samplers"][0]["output"]), (std::vector<float>{0, 0, 1, 0.5, 0, 1}));
}

TEST(Gltf, OddNamesAndBareTreesDoNotMatter) {
  auto pole = *cantilever({});
  pole.name = "caf\xE9 \"\n";
  const Glb glb = written(pole);
  EXPECT_EQ(glb.json["meshes"][0]["primitives"].size(), 1U);
}

TEST(Gltf, RefusesMotionThatDoesNotFit) {
  const auto pole = *cantilever({.segment_count = 1});
  const auto refused = [&](const GltfOptions& options, const GltfMotion& motion, const char* what) {
    const auto file = to_glb(pole, options, motion);
    ASSERT_FALSE(file) << what;
    EXPECT_THAT(file.error().message, HasSubstr(what));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused({.sides = 2}, {}, "3 to 64 sides");
  refused({.leaf_colour = {0, 2, 0}}, {}, "colours");
  refused({}, {.shapes_m = {{{}, {}, {}}}}, "one displacement for each node");
  refused({}, {.shapes_m = {{{}, {nan, 0, 0}}}}, "not finite");
  refused({}, {.shape_names = {"a", "b"}, .shapes_m = {{{}, {}}}}, "as many names");
  refused({}, {.shapes_m = {{{}, {}}}, .times_s = {0, 1}, .weights = {0}}, "as many weights");
  refused({}, {.times_s = {0}}, "times without shapes");
  refused({}, {.shapes_m = {{{}, {}}}, .times_s = {1, 1}, .weights = {0, 0}}, "ascend");
  refused({}, {.shapes_m = {{{}, {}}}, .times_s = {0, 1}, .weights = {0, nan}}, "weight is not finite");
}

TEST(Gltf, FileIsWrittenWholeOrNotAtAll) {
  const testing::TemporaryFolder folder;
  const auto pole = *cantilever({});
  ASSERT_TRUE(write_glb(folder.path() / "pole.glb", pole));
  EXPECT_EQ(std::filesystem::file_size(folder.path() / "pole.glb"), to_glb(pole)->size());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "pole.glb.part"));
  const auto failed = write_glb(folder.path() / "absent" / "pole.glb", pole);
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().message, HasSubstr("absent"));
}

}  // namespace
}  // namespace roseau::structure
