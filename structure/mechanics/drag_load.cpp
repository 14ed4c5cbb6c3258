#include "structure/mechanics/drag_load.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>

#include "structure/mechanics/beam_element.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {
namespace {

struct WeightedPoint {
  double fraction;
  double weight;
};

/// Gauss rule on (0, 1) for the weight a + (b - a) x: exact when the weight multiplies a polynomial of degree three. Its points
/// are the zeros of the quadratic that is orthogonal to 1 and x under that weight.
std::array<WeightedPoint, 2> tapered_gauss_points(double a, double b) {
  const double d = b - a;
  const double m0 = a + d / 2;
  const double m1 = a / 2 + d / 3;
  const double m2 = a / 3 + d / 4;
  const double m3 = a / 4 + d / 5;
  const double determinant = m0 * m2 - m1 * m1;
  const double linear = (m1 * m2 - m0 * m3) / determinant;  // x^2 + linear x + constant
  const double constant = (m1 * m3 - m2 * m2) / determinant;
  const double root = std::sqrt(linear * linear / 4 - constant);
  const double first = -linear / 2 - root;
  const double second = -linear / 2 + root;
  const double second_weight = (m1 - first * m0) / (second - first);
  return {{{first, m0 - second_weight}, {second, second_weight}}};
}

std::optional<Error> complaint(const DragOptions& options) {
  const auto refuse = [](const char* what, double value) {
    return Error{ErrorCode::invalid_argument, fmt::format("{} cannot be {}", what, value)};
  };
  const auto not_below_zero = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!not_below_zero(options.air_density_kg_m3)) return refuse("the air's density", options.air_density_kg_m3);
  if (!(std::isfinite(options.reference_speed_mps) && options.reference_speed_mps > 0)) {
    return refuse("the reference speed of the drag", options.reference_speed_mps);
  }
  for (const double coefficient : {options.wood_coefficient, options.foliage_coefficient}) {
    if (!not_below_zero(coefficient)) return refuse("a drag coefficient", coefficient);
  }
  for (const double exponent : {options.wood_vogel_exponent, options.foliage_vogel_exponent}) {
    if (!(exponent > -2 && exponent <= 0)) return refuse("a Vogel exponent", exponent);
  }
  if (!is_finite(options.foot_in_world_m)) return refuse("a coordinate of the tree's foot", options.foot_in_world_m.x);
  return std::nullopt;
}

/// |v|^(n - 1) at a point, from |v|^2.
template <class Squares>
void speed_factor(double exponent, const Squares& squares, Eigen::Ref<Eigen::ArrayXd> factor) {
  if (exponent == 2) {
    factor = squares.sqrt();
  } else if (exponent == 1) {
    factor.setOnes();
  } else {  // still air: the force is zero all the same, since n > 0; kept from becoming 0 times infinity
    factor = (squares.max(1e-30).log() * (0.5 * (exponent - 1))).exp();
  }
}

/// Adds up points with their weight and the rows of their shapes (x, y, z of each).
class PointList {
 public:
  explicit PointList(Eigen::Index modes, Eigen::Index most_points) : rows_(3 * most_points, modes) {}

  template <class Rows>
  void add(const Vec3& position, double weight, const Rows& rows) {
    rows_.middleRows(static_cast<Eigen::Index>(3 * positions_.size()), 3) = rows;
    positions_.push_back(position);
    weights_.push_back(weight);
  }

  const Eigen::MatrixXd& rows() const { return rows_; }
  const std::vector<Vec3>& positions() const { return positions_; }
  const std::vector<double>& weights() const { return weights_; }

 private:
  Eigen::MatrixXd rows_;
  std::vector<Vec3> positions_;
  std::vector<double> weights_;
};

/// Shapes of one segment's two ends in its own frame: displacements and rotations of parent and child, one column per mode.
Eigen::Matrix<double, 12, Eigen::Dynamic> end_shapes(const ModalModel& model, const Eigen::Matrix3d& axes, std::size_t parent,
                                                     std::size_t child) {
  Eigen::Matrix<double, 12, Eigen::Dynamic> ends(12, model.translations().cols());
  const auto row = [](std::size_t node) { return static_cast<Eigen::Index>(3 * node); };
  ends.middleRows<3>(0) = axes.transpose() * model.translations().middleRows(row(parent), 3);
  ends.middleRows<3>(3) = axes.transpose() * model.rotations().middleRows(row(parent), 3);
  ends.middleRows<3>(6) = axes.transpose() * model.translations().middleRows(row(child), 3);
  ends.middleRows<3>(9) = axes.transpose() * model.rotations().middleRows(row(child), 3);
  return ends;
}

PointList wood_points(const TreeModel& tree, const ModalModel& model, const DragOptions& options, double scale) {
  PointList points(model.translations().cols(), static_cast<Eigen::Index>(2 * tree.segment_count()));
  for (std::size_t i = 1; i < tree.nodes.size(); ++i) {
    const TreeNode& node = tree.nodes[i];
    const auto parent = static_cast<std::size_t>(node.parent);
    const Vec3 start = tree.nodes[parent].position_m;
    const Vec3 along = node.position_m - start;
    const double length = norm(along);
    const Eigen::Matrix3d axes = beam_axes({along.x, along.y, along.z});
    const auto ends = end_shapes(model, axes, parent, i);
    for (const auto& point : tapered_gauss_points(2 * node.start_radius_m, 2 * node.end_radius_m)) {
      const Eigen::Matrix<double, 3, 12> shape = axes * beam_shape(length, point.fraction).topRows<3>();
      points.add(options.foot_in_world_m + start + point.fraction * along, scale * point.weight * length, shape * ends);
    }
  }
  return points;
}

PointList foliage_points(const TreeModel& tree, const ModalModel& model, const DragOptions& options, double scale) {
  PointList points(model.translations().cols(), static_cast<Eigen::Index>(tree.nodes.size()));
  const std::vector<double> area_m2 = leaf_area_by_node_m2(tree);
  for (std::size_t i = 1; i < tree.nodes.size(); ++i) {
    if (area_m2[i] == 0) continue;
    points.add(options.foot_in_world_m + tree.nodes[i].position_m, scale * area_m2[i],
               model.translations().middleRows(static_cast<Eigen::Index>(3 * i), 3));
  }
  return points;
}

}  // namespace

Eigen::Matrix3d drag_slope(const Vec3& air_mps, double exponent) {
  const double speed = norm(air_mps);
  if (speed == 0) return (exponent == 1 ? 1.0 : 0.0) * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d along = Eigen::Vector3d(air_mps.x, air_mps.y, air_mps.z) / speed;
  return std::pow(speed, exponent - 1) * (Eigen::Matrix3d::Identity() + (exponent - 1) * along * along.transpose());
}

Result<DragLoad> DragLoad::build(const TreeModel& tree, const ModalModel& model, const DragOptions& options) {
  if (auto error = complaint(options)) return *std::move(error);
  ROSEAU_CHECK(tree.nodes.size() == model.node_count());
  DragLoad load;
  load.mode_count_ = model.translations().cols();
  load.relative_velocity_ = options.relative_velocity;
  const auto scale = [&options](double coefficient, double vogel_exponent) {
    return 0.5 * options.air_density_kg_m3 * coefficient * std::pow(options.reference_speed_mps, -vogel_exponent);
  };
  const auto add = [&load](Group& group, const PointList& list, double exponent) {
    group.exponent = exponent;
    group.first = load.points_.size();
    group.count = list.positions().size();
    load.points_.insert(load.points_.end(), list.positions().begin(), list.positions().end());
    load.fill(group, list.weights(), list.rows());
  };
  const double wood_scale = scale(options.wood_coefficient, options.wood_vogel_exponent);
  const double foliage_scale = scale(options.foliage_coefficient, options.foliage_vogel_exponent);
  add(load.wood_, wood_points(tree, model, options, wood_scale), 2 + options.wood_vogel_exponent);
  add(load.foliage_, foliage_points(tree, model, options, foliage_scale), 2 + options.foliage_vogel_exponent);
  return load;
}

void DragLoad::fill(Group& group, std::span<const double> weight, const Eigen::MatrixXd& rows) const {
  const auto count = static_cast<Eigen::Index>(group.count);
  const Eigen::Index blocks = (count + kBlock - 1) / kBlock;
  group.weight = Eigen::ArrayXd::Zero(blocks * kBlock);
  group.shapes = Eigen::MatrixXd::Zero(kRows, blocks * mode_count_);
  for (Eigen::Index point = 0; point < count; ++point) {
    group.weight[point] = weight[static_cast<std::size_t>(point)];
    auto block = group.shapes.middleCols(point / kBlock * mode_count_, mode_count_);
    for (Eigen::Index axis = 0; axis < 3; ++axis) block.row(axis * kBlock + point % kBlock) = rows.row(3 * point + axis);
  }
}

void DragLoad::modal_force(std::span<const Vec3> air_mps, const Eigen::VectorXd& q_dot, Eigen::VectorXd& force) {
  ROSEAU_CHECK(air_mps.size() == points_.size() && q_dot.size() == mode_count_);
  force.setZero(mode_count_);
  add_force(wood_, air_mps, q_dot, force);
  add_force(foliage_, air_mps, q_dot, force);
}

void DragLoad::add_force(const Group& group, std::span<const Vec3> air_mps, const Eigen::VectorXd& q_dot,
                         Eigen::VectorXd& force) {
  for (Eigen::Index first = 0; first < group.weight.size(); first += kBlock) {
    const auto shapes = group.shapes.middleCols(first / kBlock * mode_count_, mode_count_);
    const auto count = std::min<Eigen::Index>(kBlock, static_cast<Eigen::Index>(group.count) - first);
    relative_.setZero();
    for (Eigen::Index i = 0; i < count; ++i) {
      const Vec3& air = air_mps[group.first + static_cast<std::size_t>(first + i)];
      relative_[i] = air.x;
      relative_[kBlock + i] = air.y;
      relative_[2 * kBlock + i] = air.z;
    }
    if (relative_velocity_) relative_.noalias() -= shapes * q_dot;
    auto x = relative_.head<kBlock>().array();
    auto y = relative_.segment<kBlock>(kBlock).array();
    auto z = relative_.tail<kBlock>().array();
    factor_ = x.square() + y.square() + z.square();
    speed_factor(group.exponent, factor_, factor_);
    factor_ *= group.weight.segment<kBlock>(first);
    x *= factor_;
    y *= factor_;
    z *= factor_;
    for (Eigen::Index mode = 0; mode < mode_count_; ++mode) force[mode] += shapes.col(mode).dot(relative_);
  }
}

void DragLoad::add_damping(const Group& group, std::span<const Vec3> air_mps, Eigen::MatrixXd& damping) const {
  Eigen::MatrixXd rows(3, mode_count_);
  for (Eigen::Index point = 0; point < static_cast<Eigen::Index>(group.count); ++point) {
    const auto block = group.shapes.middleCols(point / kBlock * mode_count_, mode_count_);
    for (Eigen::Index axis = 0; axis < 3; ++axis) rows.row(axis) = block.row(axis * kBlock + point % kBlock);
    const Vec3& air = air_mps[group.first + static_cast<std::size_t>(point)];
    const Eigen::Matrix3d slope = group.weight[point] * drag_slope(air, group.exponent);
    damping.noalias() += rows.transpose() * (slope * rows);
  }
}

Eigen::MatrixXd DragLoad::damping_matrix(std::span<const Vec3> mean_air_mps) const {
  ROSEAU_CHECK(mean_air_mps.size() == points_.size());
  Eigen::MatrixXd damping = Eigen::MatrixXd::Zero(mode_count_, mode_count_);
  if (!relative_velocity_) return damping;
  add_damping(wood_, mean_air_mps, damping);
  add_damping(foliage_, mean_air_mps, damping);
  return damping;
}

Eigen::MatrixXd DragLoad::damping_matrix(const Vec3& uniform_air_mps) const {
  return damping_matrix(std::vector<Vec3>(points_.size(), uniform_air_mps));
}

DragLoad::Part DragLoad::integrate(const Group& group) const {
  Part part{.exponent = group.exponent,
            .push = Eigen::Matrix3Xd::Zero(3, mode_count_),
            .damping = Eigen::MatrixXd::Zero(9, mode_count_)};
  Vec3 moment;
  for (Eigen::Index point = 0; point < static_cast<Eigen::Index>(group.count); ++point) {
    const double weight = group.weight[point];
    const auto block = group.shapes.middleCols(point / kBlock * mode_count_, mode_count_);
    for (Eigen::Index mode = 0; mode < mode_count_; ++mode) {
      const Eigen::Vector3d shape(block(point % kBlock, mode), block(kBlock + point % kBlock, mode),
                                  block(2 * kBlock + point % kBlock, mode));
      part.push.col(mode) += weight * shape;
      const Eigen::Matrix3d tensor = weight * shape * shape.transpose();
      part.damping.col(mode) += tensor.reshaped();
    }
    part.weight += weight;
    moment = moment + weight * points_[group.first + static_cast<std::size_t>(point)];
  }
  if (part.weight > 0) part.centre_in_world = (1 / part.weight) * moment;
  return part;
}

}  // namespace roseau::structure
