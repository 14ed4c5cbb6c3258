#include "structure/tree/gltf.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "structure/tree/tree_check.h"
#include "structure/tree/tree_mesh.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "glTF is little-endian, and so is what we copy into it");

// The numbers of glTF 2.0.
constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"
constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr std::size_t kAlignment = 4;
constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;

/// East, north, up to glTF's axes.
std::array<float, 3> gltf_axes(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.z), static_cast<float>(-v.y)};
}

class Writer {
 public:
  Writer(const TreeModel& tree, const GltfOptions& options, const GltfMotion& motion)
      : tree_(tree), options_(options), motion_(motion) {}

  Result<std::vector<std::byte>> write();

 private:
  template <class T>
  int add_view(const std::vector<T>& values, int target);
  int add_vectors(const std::vector<std::array<float, 3>>& values, bool with_limits);
  int add_scalars(const std::vector<float>& values, bool with_limits);
  int add_shades(const TreeMesh& mesh);
  void add_primitive(const TreeMesh& mesh, const std::string& name, const std::array<double, 3>& colour, bool is_leaf);
  void add_animation();
  Json head() const;

  const TreeModel& tree_;
  const GltfOptions& options_;
  const GltfMotion& motion_;
  std::vector<std::byte> bytes_;
  Json views_ = Json::array();
  Json accessors_ = Json::array();
  Json primitives_ = Json::array();
  Json materials_ = Json::array();
  Json animations_ = Json::array();
};

/// Index of a new buffer view. `target` 0: not for a graphics card's vertices or indices.
template <class T>
int Writer::add_view(const std::vector<T>& values, int target) {
  const std::size_t begin = bytes_.size();
  const std::size_t size = values.size() * sizeof(T);
  bytes_.resize(begin + (size + kAlignment - 1) / kAlignment * kAlignment);
  std::memcpy(bytes_.data() + begin, values.data(), size);
  Json view = {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", size}};
  if (target != 0) view["target"] = target;
  views_.push_back(std::move(view));
  return static_cast<int>(views_.size() - 1);
}

int Writer::add_vectors(const std::vector<std::array<float, 3>>& values, bool with_limits) {
  Json accessor = {
      {"bufferView", add_view(values, kArrayBuffer)}, {"componentType", kFloat}, {"count", values.size()}, {"type", "VEC3"}};
  if (with_limits) {
    std::array<float, 3> low = values.front();
    std::array<float, 3> high = values.front();
    for (const auto& value : values) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], value[k]);
        high[k] = std::max(high[k], value[k]);
      }
    }
    accessor["min"] = low;
    accessor["max"] = high;
  }
  accessors_.push_back(std::move(accessor));
  return static_cast<int>(accessors_.size() - 1);
}

int Writer::add_scalars(const std::vector<float>& values, bool with_limits) {
  Json accessor = {
      {"bufferView", add_view(values, 0)}, {"componentType", kFloat}, {"count", values.size()}, {"type", "SCALAR"}};
  if (with_limits) {
    accessor["min"] = Json::array({values.front()});
    accessor["max"] = Json::array({values.back()});
  }
  accessors_.push_back(std::move(accessor));
  return static_cast<int>(accessors_.size() - 1);
}

int Writer::add_shades(const TreeMesh& mesh) {
  std::vector<std::array<std::uint8_t, 4>> shades;
  for (const MeshVertex& vertex : mesh.vertices) {
    const auto shade = static_cast<std::uint8_t>(std::lround(255 * vertex.shade));
    shades.push_back({shade, shade, shade, 255});
  }
  accessors_.push_back({{"bufferView", add_view(shades, kArrayBuffer)},
                        {"componentType", kUnsignedByte},
                        {"normalized", true},
                        {"count", shades.size()},
                        {"type", "VEC4"}});
  return static_cast<int>(accessors_.size() - 1);
}

void Writer::add_primitive(const TreeMesh& mesh, const std::string& name, const std::array<double, 3>& colour, bool is_leaf) {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  for (const MeshVertex& vertex : mesh.vertices) {
    positions.push_back(gltf_axes(vertex.position_m));
    normals.push_back(gltf_axes(vertex.normal));
  }
  Json attributes = {{"POSITION", add_vectors(positions, true)}, {"NORMAL", add_vectors(normals, false)}};
  if (is_leaf) attributes["COLOR_0"] = add_shades(mesh);
  accessors_.push_back({{"bufferView", add_view(mesh.indices, kElementArrayBuffer)},
                        {"componentType", kUnsignedInt},
                        {"count", mesh.indices.size()},
                        {"type", "SCALAR"}});
  Json primitive = {{"attributes", attributes}, {"indices", accessors_.size() - 1}, {"material", materials_.size()}};
  for (const auto& shape : motion_.shapes_m) {
    std::vector<std::array<float, 3>> moves;
    for (const Vec3& move : vertex_displacements_m(tree_, mesh, shape)) moves.push_back(gltf_axes(move));
    primitive["targets"].push_back({{"POSITION", add_vectors(moves, true)}});
  }
  primitives_.push_back(std::move(primitive));
  materials_.push_back({{"name", name},
                        {"pbrMetallicRoughness",
                         {{"baseColorFactor", {colour[0], colour[1], colour[2], 1.0}},
                          {"metallicFactor", 0.0},
                          {"roughnessFactor", is_leaf ? 0.6 : 0.9}}},
                        {"doubleSided", is_leaf}});
}

void Writer::add_animation() {
  if (motion_.times_s.empty()) return;
  const int times = add_scalars({motion_.times_s.begin(), motion_.times_s.end()}, true);
  const int weights = add_scalars({motion_.weights.begin(), motion_.weights.end()}, false);
  const Json sampler = {{"input", times}, {"output", weights}, {"interpolation", "LINEAR"}};
  const Json channel = {{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}};
  animations_.push_back({{"name", "motion"}, {"samplers", Json::array({sampler})}, {"channels", Json::array({channel})}});
}

Json Writer::head() const {
  Json mesh = {{"name", tree_.name}, {"primitives", primitives_}};
  if (!motion_.shapes_m.empty()) {
    mesh["weights"] = std::vector<double>(motion_.shapes_m.size(), 0.0);
    if (!motion_.shape_names.empty()) mesh["extras"] = {{"targetNames", motion_.shape_names}};
  }
  const Json scene = {{"nodes", Json::array({0})}};
  const Json node = {{"name", tree_.name}, {"mesh", 0}};
  const Json buffer = {{"byteLength", bytes_.size()}};
  Json json = {{"asset", {{"version", "2.0"}, {"generator", "roseau"}}},
               {"scene", 0},
               {"scenes", Json::array({scene})},
               {"nodes", Json::array({node})},
               {"meshes", Json::array({mesh})},
               {"materials", materials_},
               {"accessors", accessors_},
               {"bufferViews", views_},
               {"buffers", Json::array({buffer})}};
  if (!animations_.empty()) json["animations"] = animations_;
  return json;
}

void append_u32(std::vector<std::byte>& bytes, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  const auto* raw = reinterpret_cast<const std::byte*>(&word);
  bytes.insert(bytes.end(), raw, raw + sizeof(word));
}

Result<std::vector<std::byte>> Writer::write() {
  add_primitive(bark_mesh(tree_, options_.sides), "bark", options_.bark_colour, false);
  if (options_.leaves && !tree_.leaves.empty()) add_primitive(leaf_mesh(tree_), "leaves", options_.leaf_colour, true);
  add_animation();
  // A name in another encoding must not stop the export.
  std::string text = head().dump(-1, ' ', false, Json::error_handler_t::replace);
  text.resize((text.size() + kAlignment - 1) / kAlignment * kAlignment, ' ');
  const std::size_t total = kHeaderBytes + 2 * kChunkHeaderBytes + text.size() + bytes_.size();
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    return Error{ErrorCode::unsupported,
                 tree_.name + ": a .glb file holds at most 4 GB; simplify the tree or use fewer shapes"};
  }
  std::vector<std::byte> file;
  file.reserve(total);
  append_u32(file, kMagic);
  append_u32(file, 2);
  append_u32(file, total);
  append_u32(file, text.size());
  append_u32(file, kJsonChunk);
  const auto* characters = reinterpret_cast<const std::byte*>(text.data());
  file.insert(file.end(), characters, characters + text.size());
  append_u32(file, bytes_.size());
  append_u32(file, kBinChunk);
  file.insert(file.end(), bytes_.begin(), bytes_.end());
  return file;
}

const char* fault(const TreeModel& tree, const GltfOptions& options, const GltfMotion& motion) {
  if (options.sides < 3 || options.sides > 64) return "a tube takes 3 to 64 sides";
  for (const auto& colour : {options.bark_colour, options.leaf_colour}) {
    for (const double share : colour) {
      if (!(share >= 0 && share <= 1)) return "colours lie between 0 and 1";
    }
  }
  for (const auto& shape : motion.shapes_m) {
    if (shape.size() != tree.nodes.size()) return "a shape has not one displacement for each node";
    for (const Vec3& displacement_m : shape) {
      if (!is_finite(displacement_m)) return "a shape's displacement is not finite";
    }
  }
  const std::size_t shapes = motion.shapes_m.size();
  if (!motion.shape_names.empty() && motion.shape_names.size() != shapes) return "there are not as many names as shapes";
  if (motion.weights.size() != motion.times_s.size() * shapes) return "there are not as many weights as times x shapes";
  if (!motion.times_s.empty() && shapes == 0) return "times without shapes";
  double last_s = -1;
  for (const double time_s : motion.times_s) {
    if (!(time_s >= 0) || !std::isfinite(time_s) || static_cast<float>(time_s) <= static_cast<float>(last_s)) {
      return "the times do not ascend from 0";
    }
    last_s = time_s;
  }
  for (const double weight : motion.weights) {
    if (!std::isfinite(weight)) return "a weight is not finite";
  }
  return nullptr;
}

}  // namespace

Result<std::vector<std::byte>> to_glb(const TreeModel& tree, const GltfOptions& options, const GltfMotion& motion) {
  if (auto checked = check(tree); !checked) return checked.error();
  if (const char* what = fault(tree, options, motion)) {
    return Error{ErrorCode::invalid_argument, tree.name + ": glTF: " + what};
  }
  return Writer(tree, options, motion).write();
}

Result<void> write_glb(const std::filesystem::path& path, const TreeModel& tree, const GltfOptions& options,
                       const GltfMotion& motion) {
  const auto file = to_glb(tree, options, motion);
  if (!file) return file.error();
  const std::filesystem::path unfinished = path.string() + ".part";
  {
    std::ofstream stream(unfinished, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(file->data()), static_cast<std::streamsize>(file->size()));
    if (!stream.flush())
      return Error{ErrorCode::io, unfinished.string() + ": cannot be written; is the folder there, and room?"};
  }
  std::error_code failure;
  std::filesystem::rename(unfinished, path, failure);
  if (failure) return Error{ErrorCode::io, path.string() + ": cannot be written: " + failure.message()};
  return {};
}

}  // namespace roseau::structure
