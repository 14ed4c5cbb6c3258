#include "structure/tree/tree_mesh.h"

#include <array>
#include <numbers>
#include <utility>

#include "core/check.h"
#include "core/random.h"
#include "structure/tree/branches.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

constexpr double kRadiusJump = 0.02;  // a step larger than this share gets two rings
constexpr std::uint64_t kShadeStream = 11;

/// Runs along each axis: the foot or the bearer's node first, then the axis' own nodes up to its tip.
std::vector<std::vector<std::uint32_t>> axes(const TreeModel& tree) {
  const auto above = children(tree);
  std::vector<std::vector<std::uint32_t>> runs;
  std::vector<bool> is_in_a_run(tree.nodes.size(), false);
  // The child that goes on: the thickest one of the node's own order.
  const auto next_of = [&](std::uint32_t node) {
    std::uint32_t next = 0;
    for (const std::uint32_t child : above[node]) {
      if (tree.nodes[child].order != tree.nodes[node].order) continue;
      if (next == 0 || tree.nodes[child].start_radius_m > tree.nodes[next].start_radius_m) next = child;
    }
    return next;
  };
  for (std::uint32_t first = 1; first < tree.nodes.size(); ++first) {
    if (is_in_a_run[first]) continue;
    std::vector<std::uint32_t> run{static_cast<std::uint32_t>(tree.nodes[first].parent)};
    for (std::uint32_t node = first; node != 0; node = next_of(node)) {
      is_in_a_run[node] = true;
      run.push_back(node);
    }
    runs.push_back(std::move(run));
  }
  return runs;
}

class Tube {
 public:
  Tube(const TreeModel& tree, std::uint32_t sides, TreeMesh& mesh) : tree_(tree), sides_(sides), mesh_(mesh) {}

  void add(const std::vector<std::uint32_t>& run) {
    side_ = perpendicular(direction(run, 1), {1, 0, 0});
    has_ring_ = false;
    for (std::size_t i = 0; i < run.size(); ++i) add_node(run, i);
    close(run);
  }

 private:
  const TreeNode& node(std::uint32_t i) const { return tree_.nodes[i]; }
  /// Of the segment below the run's i-th node.
  Vec3 direction(const std::vector<std::uint32_t>& run, std::size_t i) const {
    return unit(node(run[i]).position_m - node(run[i - 1]).position_m);
  }
  /// How fast the radius shrinks along it: the normals lean by it.
  double taper(const std::vector<std::uint32_t>& run, std::size_t i) const {
    const TreeNode& end = node(run[i]);
    return (end.start_radius_m - end.end_radius_m) / distance(end.position_m, node(run[i - 1]).position_m);
  }

  void add_node(const std::vector<std::uint32_t>& run, std::size_t i) {
    const bool is_first = i == 0;
    const bool is_last = i + 1 == run.size();
    const Vec3 along = is_first  ? direction(run, 1)
                       : is_last ? direction(run, i)
                                 : unit(direction(run, i) + direction(run, i + 1), direction(run, i));
    side_ = perpendicular(along, side_);
    if (is_first) {
      add_ring(run[i], along, node(run[1]).start_radius_m, taper(run, 1));
      return;
    }
    const double below_m = node(run[i]).end_radius_m;
    const double above_m = is_last ? below_m : node(run[i + 1]).start_radius_m;
    add_ring(run[i], along, below_m, taper(run, i));
    if (std::abs(above_m - below_m) > kRadiusJump * below_m) add_ring(run[i], along, above_m, taper(run, i + 1));
  }

  void add_ring(std::uint32_t node_index, const Vec3& along, double radius_m, double taper) {
    const auto begin = static_cast<std::uint32_t>(mesh_.vertices.size());
    const Vec3 other = cross(along, side_);
    for (std::uint32_t k = 0; k < sides_; ++k) {
      const double angle_rad = 2 * std::numbers::pi * k / sides_;
      const Vec3 outwards = std::cos(angle_rad) * side_ + std::sin(angle_rad) * other;
      mesh_.vertices.push_back({.position_m = node(node_index).position_m + radius_m * outwards,
                                .normal = unit(outwards + taper * along),
                                .node = node_index});
    }
    if (has_ring_) {
      for (std::uint32_t k = 0; k < sides_; ++k) {
        const std::uint32_t next = (k + 1) % sides_;
        add_triangle(ring_ + k, ring_ + next, begin + k);
        add_triangle(ring_ + next, begin + next, begin + k);
      }
    }
    ring_ = begin;
    has_ring_ = true;
  }

  /// A blunt point: half a radius beyond the last node.
  void close(const std::vector<std::uint32_t>& run) {
    const Vec3 along = direction(run, run.size() - 1);
    const TreeNode& tip = node(run.back());
    const auto point = static_cast<std::uint32_t>(mesh_.vertices.size());
    mesh_.vertices.push_back(
        {.position_m = tip.position_m + (0.5 * tip.end_radius_m) * along, .normal = along, .node = run.back()});
    for (std::uint32_t k = 0; k < sides_; ++k) add_triangle(ring_ + k, ring_ + (k + 1) % sides_, point);
  }

  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) { mesh_.indices.insert(mesh_.indices.end(), {a, b, c}); }

  const TreeModel& tree_;
  const std::uint32_t sides_;
  TreeMesh& mesh_;
  Vec3 side_;
  std::uint32_t ring_ = 0;  // first vertex of the last ring
  bool has_ring_ = false;
};

}  // namespace

TreeMesh bark_mesh(const TreeModel& tree, std::uint32_t sides) {
  TreeMesh mesh;
  Tube tube(tree, sides, mesh);
  for (const auto& run : axes(tree)) tube.add(run);
  return mesh;
}

TreeMesh leaf_mesh(const TreeModel& tree) {
  // Along the blade, and half its width there: close to an ellipse with a point.
  constexpr std::array<std::pair<double, double>, 6> kOutline{
      {{0, 0}, {0.35, -0.48}, {0.35, 0.48}, {0.72, -0.38}, {0.72, 0.38}, {1, 0}}};
  constexpr std::array<std::uint32_t, 12> kTriangles{0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5};
  const RandomStream shades(1, kShadeStream);
  TreeMesh mesh;
  mesh.vertices.reserve(kOutline.size() * tree.leaves.size());
  mesh.indices.reserve(kTriangles.size() * tree.leaves.size());
  for (std::size_t i = 0; i < tree.leaves.size(); ++i) {
    const Leaf& leaf = tree.leaves[i];
    const Vec3 across = cross(leaf.normal, leaf.direction);
    const auto begin = static_cast<std::uint32_t>(mesh.vertices.size());
    const auto shade = static_cast<float>(shades.uniform(i, 0.75, 1));
    for (const auto& [along, aside] : kOutline) {
      mesh.vertices.push_back(
          {.position_m = leaf.base_m + (along * leaf.length_m) * leaf.direction + (aside * leaf.width_m) * across,
           .normal = leaf.normal,
           .node = leaf.node,
           .turns = true,
           .shade = shade});
    }
    for (const std::uint32_t corner : kTriangles) mesh.indices.push_back(begin + corner);
  }
  return mesh;
}

std::vector<Vec3> vertex_displacements_m(const TreeModel& tree, const TreeMesh& mesh, const std::vector<Vec3>& displacement_m) {
  ROSEAU_CHECK(displacement_m.size() == tree.nodes.size());
  std::vector<Vec3> moved;
  moved.reserve(mesh.vertices.size());
  for (const MeshVertex& vertex : mesh.vertices) {
    const TreeNode& node = tree.nodes[vertex.node];
    Vec3 move_m = displacement_m[vertex.node];
    if (vertex.turns && vertex.node > 0) {
      const auto parent = static_cast<std::size_t>(node.parent);
      const Vec3 segment = node.position_m - tree.nodes[parent].position_m;
      const Vec3 turn = (1 / dot(segment, segment)) * cross(segment, move_m - displacement_m[parent]);
      move_m = move_m + cross(turn, vertex.position_m - node.position_m);
    }
    moved.push_back(move_m);
  }
  return moved;
}

}  // namespace roseau::structure
