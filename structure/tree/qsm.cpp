#include "structure/tree/qsm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "structure/tree/import_notes.h"
#include "structure/tree/tree_check.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
constexpr double kNoLength_m = 1e-6;
constexpr double kFarthest_m = 500;
constexpr double kStretch_m = 0.01;     // beyond the parent's radius
constexpr double kLeastSplit_m = 0.01;  // no piece of a split cylinder is shorter
constexpr double kUnitTolerance = 1e-3;
constexpr std::uint16_t kHighestOrder = 60'000;

enum Column : std::size_t { kRadius, kLength, kStart, kAxis = 5, kParent = 8, kOrder = 11, kOrderColumns = 12, kFewest = 9 };

struct Cylinder {
  Vec3 start_m;
  Vec3 direction;
  double length_m = 0;
  double radius_m = 0;
  std::size_t parent = kNone;
  std::uint16_t order = 0;
  std::vector<std::size_t> branches;  // rows that name this one as parent

  Vec3 end_m() const { return start_m + length_m * direction; }
};

class Builder {
 public:
  Builder(const QsmTable& table, const std::string& source_name) : table_(table), source_name_(source_name) {}
  Result<ImportedTree> build();

 private:
  /// A point of a cylinder's axis that has a node.
  struct Stop {
    double along_m = 0;
    std::uint32_t node = 0;
  };

  Error error(std::size_t row, const std::string& what) const {
    return {ErrorCode::corrupt, fmt::format("{}:{}: {}", source_name_, table_.lines[row], what)};
  }
  Result<void> read_row(std::size_t row);
  Result<void> find_foot();
  Result<void> put_in_order();
  void set_orders();
  void skip_missing_lengths();
  void derive_orders();
  Result<void> add_cylinder(std::size_t row);
  std::uint32_t add_node(std::uint32_t parent, const Vec3& position_m, const Cylinder& cylinder);
  std::vector<double> splits(const Cylinder& cylinder) const;
  std::uint32_t attach(std::size_t row);

  const QsmTable& table_;
  const std::string& source_name_;
  std::vector<Cylinder> cylinders_;
  std::vector<std::size_t> order_;        // rows, parents first
  std::vector<std::vector<Stop>> stops_;  // per row, from the lower to the upper end
  std::size_t foot_ = kNone;
  ImportedTree imported_;
  ImportNotes notes_;
};

Result<void> Builder::read_row(std::size_t row) {
  for (std::size_t column = 0; column < kFewest; ++column) {
    if (!std::isfinite(table_.at(row, column))) return error(row, fmt::format("column {} is not finite", column + 1));
  }
  const auto vector = [&](std::size_t column) {
    return Vec3{table_.at(row, column), table_.at(row, column + 1), table_.at(row, column + 2)};
  };
  Cylinder& cylinder = cylinders_[row];
  cylinder.radius_m = table_.at(row, kRadius);
  cylinder.length_m = table_.at(row, kLength);
  cylinder.start_m = vector(kStart);
  const Vec3 axis = vector(kAxis);
  const double parent = table_.at(row, kParent);
  if (cylinder.radius_m <= 0) return error(row, "the radius is not positive");
  if (parent != std::floor(parent) || parent < 0 || parent > static_cast<double>(cylinders_.size())) {
    return error(row, fmt::format("parent {} is no row of this table of cylinders", parent));
  }
  if (parent > 0) cylinder.parent = static_cast<std::size_t>(parent) - 1;
  if (cylinder.length_m < kNoLength_m || norm(axis) < kNoLength_m) {
    cylinder.length_m = 0;
    notes_.add("cylinders of no length or direction, left out", table_.lines[row]);
  } else if (std::abs(norm(axis) - 1) > kUnitTolerance) {
    notes_.add("axes of another length than 1, of which only the direction counts", table_.lines[row]);
  }
  cylinder.direction = unit(axis);
  return {};
}

Result<void> Builder::find_foot() {
  for (std::size_t row = 0; row < cylinders_.size(); ++row) {
    if (cylinders_[row].parent != kNone) continue;
    if (foot_ != kNone) {
      return error(row, fmt::format("has no parent, like row {}: the tree is in pieces", table_.lines[foot_]));
    }
    foot_ = row;
  }
  if (foot_ == kNone) return error(0, "every cylinder has a parent: a loop; the foot's must be 0");
  if (cylinders_[foot_].length_m == 0) return error(foot_, "the lowest cylinder has no length");
  return {};
}

/// Parents first, whatever the order of the rows. A row that is never reached from the foot hangs on a loop.
Result<void> Builder::put_in_order() {
  for (std::size_t row = 0; row < cylinders_.size(); ++row) {
    if (cylinders_[row].parent != kNone) cylinders_[cylinders_[row].parent].branches.push_back(row);
  }
  order_.push_back(foot_);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const auto& branches = cylinders_[order_[i]].branches;
    order_.insert(order_.end(), branches.begin(), branches.end());
  }
  if (order_.size() == cylinders_.size()) return {};
  std::vector<bool> reached(cylinders_.size(), false);
  for (const std::size_t row : order_) reached[row] = true;
  const auto lost = static_cast<std::size_t>(std::find(reached.begin(), reached.end(), false) - reached.begin());
  return error(lost, "its parents form a loop");
}

/// What a cylinder of no length bears goes to its parent.
void Builder::skip_missing_lengths() {
  for (const std::size_t row : order_) {
    Cylinder& cylinder = cylinders_[row];
    while (cylinder.parent != kNone && cylinders_[cylinder.parent].length_m == 0) {
      cylinder.parent = cylinders_[cylinder.parent].parent;
    }
  }
  std::erase_if(order_, [this](std::size_t row) { return cylinders_[row].length_m == 0; });
  for (Cylinder& cylinder : cylinders_) cylinder.branches.clear();
  for (const std::size_t row : order_) {
    if (cylinders_[row].parent != kNone) cylinders_[cylinders_[row].parent].branches.push_back(row);
  }
}

void Builder::derive_orders() {
  for (const std::size_t row : order_) {
    const Cylinder& cylinder = cylinders_[row];
    std::size_t next = kNone;
    for (const std::size_t branch : cylinder.branches) {
      const double along_m = dot(cylinders_[branch].start_m - cylinder.start_m, cylinder.direction);
      if (along_m < 0.9 * cylinder.length_m) continue;
      if (next == kNone || cylinders_[branch].radius_m > cylinders_[next].radius_m) next = branch;
    }
    for (const std::size_t branch : cylinder.branches) {
      const bool branches_off = branch != next && cylinder.order < kHighestOrder;
      cylinders_[branch].order = static_cast<std::uint16_t>(cylinder.order + (branches_off ? 1 : 0));
    }
  }
}

void Builder::set_orders() {
  const auto given = [this](std::size_t row) { return table_.at(row, kOrder); };
  const bool are_given = table_.columns >= kOrderColumns && std::all_of(order_.begin(), order_.end(), [&](std::size_t row) {
                           return given(row) >= 0 && given(row) <= kHighestOrder && given(row) == std::floor(given(row));
                         });
  if (!are_given) {
    notes_.add("no branch orders, found from the thickness", 0);
    return derive_orders();
  }
  for (const std::size_t row : order_) cylinders_[row].order = static_cast<std::uint16_t>(given(row));
}

std::uint32_t Builder::add_node(std::uint32_t parent, const Vec3& position_m, const Cylinder& cylinder) {
  imported_.tree.nodes.push_back({.position_m = position_m - imported_.foot_in_source_m,
                                  .parent = static_cast<std::int32_t>(parent),
                                  .start_radius_m = cylinder.radius_m,
                                  .end_radius_m = cylinder.radius_m,
                                  .order = cylinder.order});
  return static_cast<std::uint32_t>(imported_.tree.nodes.size() - 1);
}

/// Where along this cylinder its branches need a node.
std::vector<double> Builder::splits(const Cylinder& cylinder) const {
  std::vector<double> wanted;
  for (const std::size_t branch : cylinder.branches) {
    wanted.push_back(dot(cylinders_[branch].start_m - cylinder.start_m, cylinder.direction));
  }
  std::sort(wanted.begin(), wanted.end());
  const double apart_m = std::max(kLeastSplit_m, cylinder.radius_m / 2);
  std::vector<double> chosen;
  for (const double along_m : wanted) {
    const double below_m = chosen.empty() ? 0 : chosen.back();
    if (along_m - below_m >= apart_m && cylinder.length_m - along_m >= apart_m) chosen.push_back(along_m);
  }
  return chosen;
}

/// The node of its parent's axis where a cylinder begins, by way of a bridge where it begins far away.
std::uint32_t Builder::attach(std::size_t row) {
  const Cylinder& cylinder = cylinders_[row];
  const Cylinder& parent = cylinders_[cylinder.parent];
  const double along_m = dot(cylinder.start_m - parent.start_m, parent.direction);
  const auto& stops = stops_[cylinder.parent];
  const auto nearest = std::min_element(stops.begin(), stops.end(), [along_m](const Stop& a, const Stop& b) {
    return std::abs(a.along_m - along_m) < std::abs(b.along_m - along_m);
  });
  const Vec3 from_m = imported_.tree.nodes[nearest->node].position_m + imported_.foot_in_source_m;
  const double gap_m = distance(from_m, cylinder.start_m);
  if (gap_m <= parent.radius_m + kStretch_m) {
    if (gap_m > kStretch_m) notes_.add("starts off the parent's axis, stretched to it", table_.lines[row]);
    return nearest->node;
  }
  notes_.add("gaps to the parent, bridged with wood", table_.lines[row]);
  return add_node(nearest->node, cylinder.start_m, cylinder);
}

Result<void> Builder::add_cylinder(std::size_t row) {
  const Cylinder& cylinder = cylinders_[row];
  std::uint32_t node = row == foot_ ? 0 : attach(row);
  stops_[row].push_back({0, node});
  for (const double along_m : splits(cylinder)) {
    node = add_node(node, cylinder.start_m + along_m * cylinder.direction, cylinder);
    stops_[row].push_back({along_m, node});
  }
  const auto& nodes = imported_.tree.nodes;
  const Vec3 end_m = cylinder.end_m() - imported_.foot_in_source_m;
  if (!(norm(end_m) <= kFarthest_m))
    return error(row, fmt::format("is {:.3g} m from the foot: are these metres?", norm(end_m)));
  if (distance(nodes[node].position_m, end_m) < kNoLength_m) {
    notes_.add("cylinders that end where they are attached, left out", table_.lines[row]);
    return {};
  }
  stops_[row].push_back({cylinder.length_m, add_node(node, cylinder.end_m(), cylinder)});
  return {};
}

Result<ImportedTree> Builder::build() {
  const std::size_t rows = table_.rows();
  if (rows == 0) return Error{ErrorCode::corrupt, source_name_ + ": holds no cylinder"};
  if (table_.columns < kFewest) {
    return Error{ErrorCode::corrupt,
                 fmt::format("{}: has {} columns; a table of cylinders has at least 9", source_name_, table_.columns)};
  }
  cylinders_.resize(rows);
  stops_.resize(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    if (auto read = read_row(row); !read) return read.error();
  }
  if (auto found = find_foot(); !found) return found.error();
  if (auto ordered = put_in_order(); !ordered) return ordered.error();
  imported_.elements = rows;
  skip_missing_lengths();
  imported_.placed_elements = order_.size();
  set_orders();
  imported_.tree.name = source_name_;
  imported_.foot_in_source_m = cylinders_[foot_].start_m;
  imported_.tree.nodes.push_back({.start_radius_m = cylinders_[foot_].radius_m, .end_radius_m = cylinders_[foot_].radius_m});
  for (const std::size_t row : order_) {
    if (auto added = add_cylinder(row); !added) return added.error();
  }
  imported_.notes = notes_.take();
  if (auto checked = check(imported_.tree); !checked) return checked.error();
  return std::move(imported_);
}

}  // namespace

Result<ImportedTree> tree_from_cylinders(const QsmTable& table, const std::string& source_name) {
  return Builder(table, source_name).build();
}

}  // namespace roseau::structure
