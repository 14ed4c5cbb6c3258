// tree: reads or grows one, and says what it is.

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "structure/mechanics/modal_model.h"
#include "structure/tree/branches.h"
#include "structure/tree/gltf.h"
#include "structure/tree/grown_tree.h"
#include "structure/tree/simplify.h"
#include "structure/tree/statistics.h"
#include "structure/tree/tree_file.h"

namespace roseau::daemon {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kBranchesShown = 5;

Result<structure::ImportedTree> load(const TreeArguments& arguments) {
  if (arguments.grow) {
    auto tree = structure::grow_tree({.seed = arguments.seed.value_or(1)});
    if (!tree) return tree.error();
    return structure::ImportedTree{.tree = std::move(*tree)};
  }
  structure::TreeFileOptions options;
  options.mtg.leaf_seed = arguments.seed.value_or(options.mtg.leaf_seed);
  options.mtg.length_unit_m = arguments.length_unit_m.value_or(options.mtg.length_unit_m);
  options.mtg.diameter_unit_m = arguments.diameter_unit_m.value_or(options.mtg.diameter_unit_m);
  options.mtg.leaf_count_column = arguments.leaf_column.value_or(options.mtg.leaf_count_column);
  // Units said on the command line are not overruled by a file that happens to lie beside the tree.
  const bool said = arguments.length_unit_m || arguments.diameter_unit_m;
  options.dressing = arguments.dressing;
  options.look_for_dressing = !said;
  return structure::read_tree(*arguments.file, options);
}

Json statistics_json(const structure::TreeStatistics& figures) {
  Json orders = Json::array();
  for (const auto& order : figures.orders) {
    orders.push_back(
        {{"axes", order.axes}, {"segments", order.segments}, {"length_m", order.length_m}, {"wood_m3", order.wood_m3}});
  }
  return {{"nodes", figures.nodes},
          {"segments", figures.segments},
          {"tips", figures.tips},
          {"height_m", figures.height_m},
          {"lowest_m", figures.lowest_m},
          {"extent_east_m", figures.extent_east_m},
          {"extent_north_m", figures.extent_north_m},
          {"wood_length_m", figures.wood_length_m},
          {"wood_m3", figures.wood_m3},
          {"foot_radius_m", figures.foot_radius_m},
          {"radius_at_1_3_m", figures.radius_at_1_3_m},
          {"thinnest_radius_m", figures.thinnest_radius_m},
          {"leaves", figures.leaves},
          {"leaf_area_m2", figures.leaf_area_m2},
          {"orders", orders}};
}

Json branches_json(const structure::TreeModel& tree) {
  Json all = Json::array();
  const auto branches = structure::main_branches(tree);
  for (std::size_t i = 0; i < std::min(kBranchesShown, branches.size()); ++i) {
    const auto& branch = branches[i];
    const Vec3& tip_m = tree.nodes[branch.tip].position_m;
    all.push_back({{"node", branch.first},
                   {"tip", branch.tip},
                   {"tip_m", {tip_m.x, tip_m.y, tip_m.z}},
                   {"segments", branch.segments},
                   {"reach_m", branch.reach_m},
                   {"wood_m3", branch.wood_m3},
                   {"leaf_area_m2", branch.leaf_area_m2}});
  }
  return all;
}

std::string statistics_text(const structure::TreeStatistics& figures) {
  std::string text = fmt::format("  {:.2f} m high, crown {:.1f} x {:.1f} m (east x north)\n", figures.height_m,
                                 figures.extent_east_m, figures.extent_north_m);
  text += fmt::format("  trunk {:.1f} cm thick at the foot", 200 * figures.foot_radius_m);
  if (figures.radius_at_1_3_m > 0) text += fmt::format(", {:.1f} cm at 1.3 m", 200 * figures.radius_at_1_3_m);
  text += fmt::format("; thinnest twig {:.1f} mm\n", 2000 * figures.thinnest_radius_m);
  text += fmt::format("  {} nodes, {} tips; {:.1f} m of wood, {:.4g} m3\n", figures.nodes, figures.tips, figures.wood_length_m,
                      figures.wood_m3);
  text += fmt::format("  {} leaves, {:.1f} m2\n", figures.leaves, figures.leaf_area_m2);
  text += fmt::format("  {:>5} {:>8} {:>9} {:>10} {:>11}\n", "order", "axes", "segments", "length m", "wood m3");
  for (std::size_t i = 0; i < figures.orders.size(); ++i) {
    const auto& order = figures.orders[i];
    text +=
        fmt::format("  {:>5} {:>8} {:>9} {:>10.2f} {:>11.6f}\n", i, order.axes, order.segments, order.length_m, order.wood_m3);
  }
  return text;
}

std::string notes_text(const structure::ImportedTree& imported) {
  if (imported.elements == 0) return "";
  std::string text = fmt::format("  {} elements in the file, {} with a place\n", imported.elements, imported.placed_elements);
  for (const auto& note : imported.notes) {
    text += fmt::format("  {:>6} x {}", note.count, note.what);
    text += note.first_line > 0 ? fmt::format(" (first: line {})\n", note.first_line) : "\n";
  }
  return text;
}

Json notes_json(const structure::ImportedTree& imported) {
  Json all = Json::array();
  for (const auto& note : imported.notes) {
    all.push_back({{"what", note.what}, {"count", note.count}, {"first_line", note.first_line}});
  }
  return all;
}

/// Where a mode moves most, and which way all of the tree moves in it.
struct ModeFigures {
  double natural_frequency_hz = 0;
  std::size_t node = 0;   // that moves most
  double height_m = 0;    // of that node
  Eigen::Vector3d share;  // east, north, up: of the sum of all nodes' squared displacements
};

std::vector<ModeFigures> figures_of(const structure::ModalModel& model, const structure::TreeModel& tree) {
  std::vector<ModeFigures> all;
  for (std::size_t mode = 0; mode < model.mode_count(); ++mode) {
    const auto shape = model.translations().col(static_cast<Eigen::Index>(mode)).reshaped(3, Eigen::AutoSize);
    Eigen::Index node = 0;
    shape.colwise().squaredNorm().maxCoeff(&node);
    const auto index = static_cast<std::size_t>(node);
    all.push_back({model.natural_frequency_hz(mode), index, tree.nodes[index].position_m.z,
                   shape.rowwise().squaredNorm() / shape.squaredNorm()});
  }
  return all;
}

/// Adds the modes to what is printed.
Result<void> add_modes(const TreeArguments& arguments, const structure::TreeModel& tree, Json& json, std::string& text) {
  structure::Material material;
  material.density_kg_m3 = arguments.density_kg_m3.value_or(material.density_kg_m3);
  material.young_modulus_pa = arguments.young_modulus_pa.value_or(material.young_modulus_pa);
  material.leaf_mass_per_area_kg_m2 = arguments.leaf_mass_per_area_kg_m2.value_or(material.leaf_mass_per_area_kg_m2);
  const auto model = structure::ModalModel::build(tree, {.material = material}, {.mode_count = *arguments.modes});
  if (!model) return model.error();
  text += fmt::format("  modes, with {:.3g} Pa and {:g} kg/m3: {:.1f} kg of wood and leaves\n", material.young_modulus_pa,
                      material.density_kg_m3, model->total_mass_kg());
  text += fmt::format("  {:>5} {:>10} {:>12} {:>9} {:>6} {:>6} {:>6}\n", "mode", "Hz", "most at node", "height m", "east",
                      "north", "up");
  Json list = Json::array();
  for (const ModeFigures& mode : figures_of(*model, tree)) {
    text +=
        fmt::format("  {:>5} {:>10.4f} {:>12} {:>9.2f} {:>5.0f}% {:>5.0f}% {:>5.0f}%\n", list.size(), mode.natural_frequency_hz,
                    mode.node, mode.height_m, 100 * mode.share.x(), 100 * mode.share.y(), 100 * mode.share.z());
    list.push_back({{"natural_frequency_hz", mode.natural_frequency_hz},
                    {"node", mode.node},
                    {"height_m", mode.height_m},
                    {"share_east", mode.share.x()},
                    {"share_north", mode.share.y()},
                    {"share_up", mode.share.z()}});
  }
  json["material"] = {{"young_modulus_pa", material.young_modulus_pa},
                      {"density_kg_m3", material.density_kg_m3},
                      {"leaf_mass_per_area_kg_m2", material.leaf_mass_per_area_kg_m2}};
  json["mass_kg"] = model->total_mass_kg();
  json["modes"] = std::move(list);
  return {};
}

}  // namespace

int tree_command(const TreeArguments& arguments) {
  auto imported = load(arguments);
  if (!imported) return failed(imported.error());
  structure::TreeModel& tree = imported->tree;
  Json json = {{"name", tree.name}};
  std::string text = tree.name + "\n" + notes_text(*imported);
  if (!arguments.grow) {
    const Vec3& foot_m = imported->foot_in_source_m;
    json["source"] = {{"path", arguments.file->string()},
                      {"elements", imported->elements},
                      {"placed_elements", imported->placed_elements},
                      {"foot_m", {foot_m.x, foot_m.y, foot_m.z}},
                      {"notes", notes_json(*imported)}};
  }
  if (arguments.simplify) {
    auto simplified = structure::simplify(tree, {.node_budget = *arguments.simplify});
    if (!simplified) return failed(simplified.error());
    json["simplified"] = {{"merged_nodes", simplified->merged_nodes}, {"dropped_twigs", simplified->dropped_twigs}};
    text +=
        fmt::format("  simplified: {} nodes merged, {} twigs dropped\n", simplified->merged_nodes, simplified->dropped_twigs);
    tree = std::move(simplified->tree);
  }
  const auto figures = structure::statistics(tree);
  json["statistics"] = statistics_json(figures);
  json["branches"] = branches_json(tree);
  text += statistics_text(figures);
  if (arguments.modes) {
    if (auto added = add_modes(arguments, tree, json, text); !added) return failed(added.error());
  }
  if (arguments.gltf) {
    if (auto written = structure::write_glb(*arguments.gltf, tree); !written) return failed(written.error());
    json["gltf"] = arguments.gltf->string();
    text += fmt::format("  written to {}\n", arguments.gltf->string());
  }
  fmt::print("{}", arguments.json ? json.dump(2) + "\n" : text);
  return kExitOk;
}

}  // namespace roseau::daemon
