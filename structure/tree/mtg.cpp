#include "structure/tree/mtg.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <limits>
#include <optional>

#include "structure/tree/import_notes.h"
#include "structure/tree/leaf_placement.h"
#include "structure/tree/mtg_text.h"
#include "structure/tree/radius_repair.h"
#include "structure/tree/tree_check.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

constexpr double kNoLength_m = 1e-6;
constexpr double kFarthest_m = 500;
constexpr double kThickest_m = 10;  // radius
constexpr double kMostLeaves = 500;
constexpr std::uint16_t kHighestOrder = 60'000;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kLeafStream = 1;

enum Feature : std::size_t { kXX, kYY, kZZ, kTopDia, kLeaves };

class Builder {
 public:
  Builder(const MtgText& mtg, const std::string& source_name, const MtgOptions& options)
      : mtg_(mtg), source_name_(source_name), options_(options), places_(mtg.entities.size()) {}

  Result<ImportedTree> build();

 private:
  /// What is known of one entity.
  struct Place {
    bool has_position = false;
    bool bears = false;  // a placed entity branches off it, perhaps by way of others without a position
    Vec3 position_m;
    double radius_m = kUnknown;
    std::int32_t node = -1;          // the one that stands for it; -1: it lies before the foot
    double end_radius_m = kUnknown;  // what the next element on this axis begins with
    bool starts_branch = false;      // a '+' lies between that node and this entity
    std::uint16_t order = 0;
  };

  Error error(std::size_t line, const std::string& what) const {
    return {ErrorCode::corrupt, fmt::format("{}:{}: {}", source_name_, line, what)};
  }
  bool is_element(std::size_t i) const { return mtg_.entities[i].last_part == MtgEntity::kNone; }
  Place* origin(std::size_t i) {
    const auto from = mtg_.entities[i].from;
    return from == MtgEntity::kNone ? nullptr : &places_[static_cast<std::size_t>(from)];
  }

  void read_places();
  Result<void> check_loops() const;
  void mark_bearers();
  void interpolate(std::size_t i);
  Result<void> add_nodes();
  Result<void> place_entity(std::size_t i);
  void count_unplaced(std::size_t i);
  void add_leaves();

  const MtgText& mtg_;
  const std::string& source_name_;
  const MtgOptions& options_;
  std::vector<Place> places_;
  ImportedTree imported_;
  ImportNotes notes_;
};

void Builder::read_places() {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const MtgEntity& entity = mtg_.entities[i];
    Place& place = places_[i];
    const Vec3 read{entity.features[kXX], entity.features[kYY], entity.features[kZZ]};
    place.has_position = is_finite(read);
    place.position_m = options_.length_unit_m * read;
    const bool has_some = !std::isnan(read.x) || !std::isnan(read.y) || !std::isnan(read.z);
    if (has_some && !place.has_position)
      notes_.add("positions with one or two coordinates only, taken for missing", entity.line);
    place.radius_m = options_.diameter_unit_m * entity.features[kTopDia] / 2;
    if (place.radius_m <= 0) {
      notes_.add("diameters of zero or less, taken for missing", entity.line);
      place.radius_m = kUnknown;
    }
    imported_.elements += entity.stands_for;
    imported_.placed_elements += place.has_position ? 1 : 0;
  }
}

/// An entity that has the name of an earlier one further down its axis and stands where that one stands is the same again.
Result<void> Builder::check_loops() const {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const MtgEntity& entity = mtg_.entities[i];
    if (entity.namesake == MtgEntity::kNone || entity.namesake == entity.from) continue;
    const auto namesake = static_cast<std::size_t>(entity.namesake);
    if (!places_[i].has_position || !places_[namesake].has_position) continue;
    if (distance(places_[i].position_m, places_[namesake].position_m) >= kNoLength_m) continue;
    return error(entity.line,
                 fmt::format("{} comes back to itself (line {}): a loop", mtg_.label(entity), mtg_.entities[namesake].line));
  }
  return {};
}

/// From the last entity to the first, because what is borne comes after its bearer.
void Builder::mark_bearers() {
  std::vector<bool> leads_to_place(places_.size(), false);
  for (std::size_t i = places_.size(); i-- > 0;) {
    if (places_[i].has_position || places_[i].bears) leads_to_place[i] = true;
    const auto from = mtg_.entities[i].from;
    if (from == MtgEntity::kNone || !leads_to_place[i]) continue;
    const auto bearer = static_cast<std::size_t>(from);
    leads_to_place[bearer] = true;
    if (mtg_.entities[i].relation == '+') places_[bearer].bears = true;
  }
}

/// Places the elements without a position that lie on the axis between this placed one and the placed one before it.
void Builder::interpolate(std::size_t i) {
  std::vector<std::size_t> between;
  for (std::size_t k = i;;) {
    const MtgEntity& entity = mtg_.entities[k];
    if (entity.relation == '+' || entity.from == MtgEntity::kNone) return;
    k = static_cast<std::size_t>(entity.from);
    if (places_[k].has_position) {
      const Vec3 step = places_[i].position_m - places_[k].position_m;
      for (std::size_t j = 0; j < between.size(); ++j) {
        Place& place = places_[between[j]];
        if (!place.bears) continue;
        const double share = static_cast<double>(between.size() - j) / static_cast<double>(between.size() + 1);
        place.position_m = places_[k].position_m + share * step;
        place.has_position = true;
        notes_.add("elements without a position that bear branches, placed between their neighbours",
                   mtg_.entities[between[j]].line);
      }
      return;
    }
    if (is_element(k)) between.push_back(k);
  }
}

void Builder::count_unplaced(std::size_t i) {
  if (is_element(i)) notes_.add("elements without a position, left out", mtg_.entities[i].line);
}

/// Finds or makes the node that stands for one entity.
Result<void> Builder::place_entity(std::size_t i) {
  const MtgEntity& entity = mtg_.entities[i];
  Place& place = places_[i];
  const Place* from = origin(i);
  const bool branches = entity.relation == '+';
  place.order = from == nullptr ? std::uint16_t{0} : from->order;
  if (branches && place.order < kHighestOrder) ++place.order;
  place.starts_branch = branches || (from != nullptr && from->starts_branch);
  place.node = from != nullptr ? from->node : -1;
  place.end_radius_m = !std::isnan(place.radius_m)    ? place.radius_m
                       : from != nullptr && !branches ? from->end_radius_m
                                                      : kUnknown;
  if (!place.has_position) {
    count_unplaced(i);
    return {};
  }
  if (place.radius_m > kThickest_m) {
    return error(entity.line,
                 fmt::format("{} is {:.3g} m thick: is the diameter's unit right?", mtg_.label(entity), 2 * place.radius_m));
  }
  auto& nodes = imported_.tree.nodes;
  if (nodes.empty()) {
    imported_.foot_in_source_m = place.position_m;
    if (is_element(i)) notes_.add("no base is given: the first element's upper end is the foot", entity.line);
    nodes.push_back({.end_radius_m = place.radius_m});
    place.node = 0;
    place.starts_branch = false;
    return {};
  }
  if (place.node < 0) {
    notes_.add("elements whose bearers have no position, hung on the foot", entity.line);
    place.node = 0;
    place.starts_branch = true;
  }
  const Vec3 position_m = place.position_m - imported_.foot_in_source_m;
  if (!(norm(position_m) <= kFarthest_m)) {
    return error(entity.line, fmt::format("{} is {:.3g} m from the foot: is the length's unit right?", mtg_.label(entity),
                                          norm(position_m)));
  }
  if (distance(position_m, nodes[static_cast<std::size_t>(place.node)].position_m) < kNoLength_m) {
    notes_.add("elements of no length, joined with the one they stand on", entity.line);
    return {};
  }
  const double start_m = place.starts_branch || from == nullptr ? place.radius_m : from->end_radius_m;
  nodes.push_back({.position_m = position_m,
                   .parent = place.node,
                   .start_radius_m = start_m,
                   .end_radius_m = place.radius_m,
                   .order = place.order});
  place.node = static_cast<std::int32_t>(nodes.size() - 1);
  place.starts_branch = false;
  return {};
}

Result<void> Builder::add_nodes() {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (auto placed = place_entity(i); !placed) return placed;
  }
  if (imported_.tree.nodes.empty()) return Error{ErrorCode::corrupt, source_name_ + ": no element has a position"};
  if (imported_.tree.nodes.size() < 2) {
    return Error{ErrorCode::corrupt, source_name_ + ": describes a single point; a tree needs at least one segment"};
  }
  const auto repaired = fill_missing_radii(imported_.tree, options_.tip_radius_m);
  for (std::size_t k = 0; k < repaired.from_branches; ++k) notes_.add("ends without a diameter, thick as what they bear", 0);
  for (std::size_t k = 0; k < repaired.tips; ++k) notes_.add("tips without a diameter, thin as the option says", 0);
  return {};
}

void Builder::add_leaves() {
  if (!mtg_.has_column[kLeaves]) return;
  const LeafShape shape{options_.leaf_length_m, options_.leaf_width_m, 0.25 * options_.leaf_length_m};
  Dice dice(options_.leaf_seed, kLeafStream);
  std::uint32_t placed = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const double count = mtg_.entities[i].features[kLeaves];
    if (std::isnan(count) || count == 0) continue;
    if (count < 0) {
      notes_.add("leaf counts below zero, taken for missing", mtg_.entities[i].line);
    } else if (count > kMostLeaves) {
      notes_.add("leaf counts above 500, left out", mtg_.entities[i].line);
    } else if (places_[i].node <= 0) {
      notes_.add("leaf counts of elements without wood, left out", mtg_.entities[i].line);
    } else {
      const auto whole = static_cast<std::uint32_t>(count);
      for (std::uint32_t k = 0; k < whole; ++k) {
        const double along = (k + dice.uniform(0.1, 0.9)) / whole;
        imported_.tree.leaves.push_back(
            place_leaf(imported_.tree, static_cast<std::uint32_t>(places_[i].node), along, placed++, shape, dice));
      }
    }
  }
}

Result<ImportedTree> Builder::build() {
  read_places();
  if (auto checked = check_loops(); !checked) return checked.error();
  mark_bearers();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (places_[i].has_position) interpolate(i);
  }
  imported_.tree.name = source_name_;
  if (auto added = add_nodes(); !added) return added.error();
  add_leaves();
  imported_.notes = notes_.take();
  imported_.notes.insert(imported_.notes.end(), mtg_.notes.begin(), mtg_.notes.end());
  if (auto checked = check(imported_.tree); !checked) return checked.error();
  return std::move(imported_);
}

Result<void> check_options(const MtgOptions& o) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (positive(o.length_unit_m) && positive(o.diameter_unit_m) && positive(o.tip_radius_m) && positive(o.leaf_length_m) &&
      positive(o.leaf_width_m)) {
    return {};
  }
  return Error{ErrorCode::invalid_argument, "MTG: units, tip radius and leaf size must be positive"};
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const auto begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

}  // namespace

Result<void> apply_dressing(std::string_view text, const std::string& source_name, MtgOptions& options) {
  const double base_m = options.length_unit_m;
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const auto end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    ++line_number;
    const auto equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string_view key = trimmed(line.substr(0, equals));
    if (key != "LengthUnit" && key != "DiameterUnit") continue;
    const std::string_view digits = trimmed(line.substr(equals + 1, line.find('#', equals) - equals - 1));
    double steps = 0;
    const auto [stop, status] = std::from_chars(digits.data(), digits.data() + digits.size(), steps);
    if (status != std::errc() || stop != digits.data() + digits.size() || !std::isfinite(steps) || steps <= 0) {
      return Error{ErrorCode::corrupt, fmt::format("{}:{}: {} must be a positive number", source_name, line_number, key)};
    }
    (key == "LengthUnit" ? options.length_unit_m : options.diameter_unit_m) = base_m / steps;
  }
  return {};
}

Result<ImportedTree> read_mtg(std::string_view text, const std::string& source_name, const MtgOptions& options) {
  if (auto checked = check_options(options); !checked) return checked.error();
  const auto mtg = parse_mtg(text, source_name, {"XX", "YY", "ZZ", "TopDia", options.leaf_count_column});
  if (!mtg) return mtg.error();
  if (!mtg->has_column[kXX] || !mtg->has_column[kYY] || !mtg->has_column[kZZ]) {
    return Error{ErrorCode::unsupported, source_name + ": has no columns XX, YY and ZZ: the tree was not digitised in space"};
  }
  return Builder(*mtg, source_name, options).build();
}

}  // namespace roseau::structure
