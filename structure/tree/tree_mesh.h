// Triangles of a tree, and how they follow its nodes.
#pragma once

#include <cstdint>
#include <vector>

#include "structure/tree/tree_model.h"

namespace roseau::structure {

struct MeshVertex {
  Vec3 position_m;  // tree frame, at rest
  Vec3 normal;      // unit, outwards
  std::uint32_t node = 0;
  bool turns = false;  // with the node's segment, as leaves do; else it is carried along only
  float shade = 1;     // of its colour
};

struct TreeMesh {
  std::vector<MeshVertex> vertices;
  std::vector<std::uint32_t> indices;  // three per triangle, anticlockwise seen from outside
};

/// A tube along every axis: rings of `sides` points at its nodes (two where the radius jumps), a point at the tip.
TreeMesh bark_mesh(const TreeModel& tree, std::uint32_t sides);

/// Six points and four triangles per leaf.
TreeMesh leaf_mesh(const TreeModel& tree);

/// How far each vertex goes when each node goes by `displacement_m`.
std::vector<Vec3> vertex_displacements_m(const TreeModel& tree, const TreeMesh& mesh, const std::vector<Vec3>& displacement_m);

}  // namespace roseau::structure
