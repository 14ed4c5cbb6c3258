#include "structure/tree/simplify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <queue>

#include "structure/tree/statistics.h"
#include "structure/tree/tree_check.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kLeastShare = 0.7;    // of two segments' length that their chord must keep
constexpr double kBearersPerTwig = 4;  // volume of wood a dropped twig is spread on, in twigs

class Simplifier {
 public:
  Simplifier(const TreeModel& tree, const SimplifyOptions& options);
  Result<Simplified> run();

 private:
  struct Step {
    double cost = 0;  // m^4: volume times distance
    std::uint32_t node = 0;
    bool operator>(const Step& other) const { return cost != other.cost ? cost > other.cost : node > other.node; }
  };
  using Queue = std::priority_queue<Step, std::vector<Step>, std::greater<>>;

  std::uint32_t parent(std::uint32_t node) const { return static_cast<std::uint32_t>(nodes_[node].parent); }
  double segment_length_m(std::uint32_t node) const {
    return distance(nodes_[node].position_m, nodes_[parent(node)].position_m);
  }
  double wood_m3(std::uint32_t node) const {
    return wood_volume_m3(segment_length_m(node), nodes_[node].start_radius_m, nodes_[node].end_radius_m);
  }
  bool is_tip(std::uint32_t node) const { return above_[node].empty(); }
  double deviation_m(std::uint32_t node) const;
  double cost(std::uint32_t node) const;
  void thicken(std::uint32_t node, double factor);
  void merge(std::uint32_t node);
  void drop(std::uint32_t node);
  void remove(std::uint32_t node, std::uint32_t leaves_to);
  void drop_thin_twigs();
  void merge_straight();
  void reach_budget();
  TreeModel result();

  const TreeModel& tree_;
  const SimplifyOptions& options_;
  std::vector<TreeNode> nodes_;
  std::vector<std::vector<std::uint32_t>> above_;
  std::vector<bool> is_gone_;
  std::vector<std::uint32_t> leaves_to_;  // of a node that went: where its leaves hang now
  std::size_t left_;
  Simplified simplified_;
};

Simplifier::Simplifier(const TreeModel& tree, const SimplifyOptions& options)
    : tree_(tree),
      options_(options),
      nodes_(tree.nodes),
      above_(tree.nodes.size()),
      is_gone_(tree.nodes.size(), false),
      leaves_to_(tree.nodes.size()),
      left_(tree.nodes.size()) {
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    leaves_to_[i] = i;
    if (i > 0) above_[parent(i)].push_back(i);
  }
}

/// Of a node from the chord of its two neighbours; never where it has not exactly two of one axis, or where they fold back.
double Simplifier::deviation_m(std::uint32_t node) const {
  if (node == 0 || above_[node].size() != 1) return kNever;
  const std::uint32_t next = above_[node].front();
  if (nodes_[next].order != nodes_[node].order) return kNever;
  const Vec3& below_m = nodes_[parent(node)].position_m;
  const Vec3 chord = nodes_[next].position_m - below_m;
  const double chord_m = norm(chord);
  if (chord_m < kLeastShare * (segment_length_m(node) + segment_length_m(next))) return kNever;
  return norm(cross(nodes_[node].position_m - below_m, chord)) / chord_m;
}

double Simplifier::cost(std::uint32_t node) const {
  if (node == 0 || is_gone_[node]) return kNever;
  if (is_tip(node)) return parent(node) == 0 ? kNever : wood_m3(node) * segment_length_m(node);
  const double off_m = deviation_m(node);
  return off_m == kNever ? kNever : (wood_m3(node) + wood_m3(above_[node].front())) * off_m;
}

void Simplifier::thicken(std::uint32_t node, double factor) {
  nodes_[node].start_radius_m *= factor;
  nodes_[node].end_radius_m *= factor;
}

void Simplifier::remove(std::uint32_t node, std::uint32_t leaves_to) {
  is_gone_[node] = true;
  leaves_to_[node] = leaves_to;
  --left_;
}

void Simplifier::merge(std::uint32_t node) {
  const std::uint32_t next = above_[node].front();
  const double wanted_m3 = wood_m3(node) + wood_m3(next);
  nodes_[next].parent = nodes_[node].parent;
  nodes_[next].start_radius_m = nodes_[node].start_radius_m;
  thicken(next, std::sqrt(wanted_m3 / wood_m3(next)));
  std::replace(above_[parent(node)].begin(), above_[parent(node)].end(), node, next);
  remove(node, next);
  ++simplified_.merged_nodes;
}

void Simplifier::drop(std::uint32_t node) {
  const double twig_m3 = wood_m3(node);
  const std::uint32_t bearer = parent(node);
  std::vector<std::uint32_t> bearers;
  double bearers_m3 = 0;
  for (std::uint32_t i = bearer; i != 0 && bearers_m3 < kBearersPerTwig * twig_m3; i = parent(i)) {
    bearers.push_back(i);
    bearers_m3 += wood_m3(i);
  }
  for (const std::uint32_t i : bearers) thicken(i, std::sqrt(1 + twig_m3 / bearers_m3));
  std::erase(above_[bearer], node);
  remove(node, bearer);
  ++simplified_.dropped_twigs;
}

/// From the tips inwards: what a dropped twig leaves bare may be a twig itself.
void Simplifier::drop_thin_twigs() {
  for (auto i = static_cast<std::uint32_t>(nodes_.size()); i-- > 1;) {
    const double radius_m = (nodes_[i].start_radius_m + nodes_[i].end_radius_m) / 2;
    if (is_tip(i) && parent(i) != 0 && radius_m < options_.drop_below_radius_m) drop(i);
  }
}

void Simplifier::merge_straight() {
  for (std::uint32_t i = 1; i < nodes_.size(); ++i) {
    if (!is_gone_[i] && deviation_m(i) < options_.merge_within_m) merge(i);
  }
}

void Simplifier::reach_budget() {
  Queue queue;
  const auto offer = [&](std::uint32_t node) {
    const double now = cost(node);
    if (now < kNever) queue.push({now, node});
  };
  for (std::uint32_t i = 1; i < nodes_.size(); ++i) offer(i);
  while (left_ > options_.node_budget && !queue.empty()) {
    const Step step = queue.top();
    queue.pop();
    const double now = cost(step.node);
    if (now == kNever) continue;
    // Wood has come to it since it was offered: its turn may be later.
    if (now > step.cost && !queue.empty() && now > queue.top().cost) {
      queue.push({now, step.node});
      continue;
    }
    const std::uint32_t below = parent(step.node);
    const std::uint32_t above = is_tip(step.node) ? 0 : above_[step.node].front();
    if (above == 0) {
      drop(step.node);
    } else {
      merge(step.node);
    }
    offer(below);
    if (above != 0) offer(above);
  }
}

TreeModel Simplifier::result() {
  TreeModel smaller{.name = tree_.name};
  std::vector<std::uint32_t> index(nodes_.size(), 0);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (is_gone_[i]) continue;
    index[i] = static_cast<std::uint32_t>(smaller.nodes.size());
    smaller.nodes.push_back(nodes_[i]);
    if (i > 0) smaller.nodes.back().parent = static_cast<std::int32_t>(index[parent(i)]);
  }
  smaller.leaves = tree_.leaves;
  for (Leaf& leaf : smaller.leaves) {
    while (is_gone_[leaf.node]) leaf.node = leaves_to_[leaf.node];
    leaf.node = index[leaf.node];
  }
  return smaller;
}

Result<Simplified> Simplifier::run() {
  drop_thin_twigs();
  merge_straight();
  reach_budget();
  if (left_ > options_.node_budget) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("{}: cannot be simplified to {} nodes, only to {}", tree_.name, options_.node_budget, left_)};
  }
  simplified_.tree = result();
  if (auto checked = check(simplified_.tree); !checked) return checked.error();
  return std::move(simplified_);
}

}  // namespace

Result<Simplified> simplify(const TreeModel& tree, const SimplifyOptions& options) {
  const auto is_length = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!is_length(options.drop_below_radius_m) || !is_length(options.merge_within_m) || options.node_budget < 2) {
    return Error{ErrorCode::invalid_argument,
                 tree.name + ": simplify: lengths must not be negative, and a tree has at least 2 nodes"};
  }
  if (auto checked = check(tree); !checked) return checked.error();
  return Simplifier(tree, options).run();
}

}  // namespace roseau::structure
