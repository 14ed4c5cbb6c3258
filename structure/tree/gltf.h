// Trees for other people's programs: binary glTF 2.0 (.glb), which Blender, three.js and most viewers open.
//
// One mesh of two parts, bark and leaves. Bark: a tube along every axis with smooth normals; leaves: flat blades of four
// triangles, seen from both sides. glTF's axes: y up, so that east, up, south are its x, y, z. Metres.
//
// Motion: shapes (displacement of every node, such as modes of vibration) become morph targets, and samples of their weights
// over time become an animation. Leaves turn with their segment, to first order in the displacement.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

struct GltfMotion {
  std::vector<std::string> shape_names;     // one per shape, or none
  std::vector<std::vector<Vec3>> shapes_m;  // per shape, of each node, for a weight of 1
  std::vector<double> times_s;              // ascending, from 0 or later
  std::vector<double> weights;              // shape by shape within time by time: times x shapes
};

struct GltfOptions {
  std::uint32_t sides = 10;  // of a tube: 3 .. 64
  bool leaves = true;
  std::array<double, 3> bark_colour{0.115, 0.080, 0.055};  // linear RGB, 0 .. 1
  std::array<double, 3> leaf_colour{0.085, 0.190, 0.030};  // single leaves are up to 25 % darker
};

/// The file's bytes. `tree` keeps the rules of tree_check.h. Errors (invalid_argument): motion that does not fit the tree,
/// times that do not ascend; (unsupported) more than 4 GB.
Result<std::vector<std::byte>> to_glb(const TreeModel& tree, const GltfOptions& options = {}, const GltfMotion& motion = {});

/// The same, into a file (written beside it and renamed). Error (io) names the file.
Result<void> write_glb(const std::filesystem::path& path, const TreeModel& tree, const GltfOptions& options = {},
                       const GltfMotion& motion = {});

}  // namespace roseau::structure
