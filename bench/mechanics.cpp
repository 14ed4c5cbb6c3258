// A tree's modes beside SciPy's on the same matrices and beside closed forms; and what the wind's push costs by full
// integration and by projection.
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>

#include "bench/bench.h"
#include "bench/estimation_cases.h"
#include "structure/mechanics/drag_load.h"
#include "structure/mechanics/modal_model.h"
#include "structure/mechanics/sway_simulation.h"
#include "structure/mechanics/wind_projection.h"
#include "structure/tree/cantilever.h"
#include "structure/tree/grown_tree.h"
#include "structure/tree/mtg.h"
#include "synthesis/wind/turbulent_wind.h"

namespace roseau::bench {

namespace {

using nlohmann::ordered_json;
using structure::BeamStructure;
using structure::DragLoad;
using structure::ModalModel;
using structure::TreeModel;

constexpr std::size_t kModes = 25;
constexpr int kRounds = 3;  // the best one counts: the others had company on the machine

template <class Work>
double microseconds_per_call(int calls, Work&& work) {
  double best_s = 1e9;
  for (int round = 0; round < kRounds; ++round) {
    const double begin_s = thread_cpu_seconds();
    for (int i = 0; i < calls; ++i) work(i);
    best_s = std::min(best_s, (thread_cpu_seconds() - begin_s) / calls);
  }
  return 1e6 * best_s;
}

// ---- modes --------------------------------------------------------------------------------------------------------------

/// The digitised walnut, where the recordings are at hand; a grown tree otherwise.
Result<TreeModel> bench_tree() {
  const char* set = std::getenv("ROSEAU_DATA");
  const auto data = set != nullptr ? std::filesystem::path(set) : std::filesystem::path(ROSEAU_SOURCE_DIR) / ".." / "shared";
  if (std::ifstream file(data / "data" / "mtg_walnut" / "noylum2.mtg"); file) {
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    auto walnut = structure::read_mtg(text, "noylum2.mtg");
    if (!walnut) return walnut.error();
    walnut->tree.name = "walnut noylum2";
    return std::move(walnut->tree);
  }
  auto grown = structure::grow_tree({});
  if (grown) grown->name = "grown (no noylum2.mtg under ROSEAU_DATA)";
  return grown;
}

void write_sparse(std::ofstream& out, const Eigen::SparseMatrix<double>& matrix) {
  const std::array<std::int64_t, 2> sizes{matrix.rows(), matrix.nonZeros()};
  const auto put = [&out](const auto* values, Eigen::Index count) {
    out.write(reinterpret_cast<const char*>(values), count * static_cast<Eigen::Index>(sizeof(*values)));
  };
  put(sizes.data(), 2);
  put(matrix.outerIndexPtr(), matrix.cols() + 1);
  put(matrix.innerIndexPtr(), matrix.nonZeros());
  put(matrix.valuePtr(), matrix.nonZeros());
}

constexpr const char* kScipyScript = R"(
import json, sys, time
import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import eigsh
def read(f):
    n, entries = np.fromfile(f, np.int64, 2)
    outer = np.fromfile(f, np.int32, n + 1)
    inner = np.fromfile(f, np.int32, entries)
    return csc_matrix((np.fromfile(f, np.float64, entries), inner, outer), shape=(n, n))
with open(sys.argv[1], 'rb') as f:
    K, M = read(f), read(f)
best = 1e9
for _ in range(int(sys.argv[3])):
    cpu = time.process_time()
    values, shapes = eigsh(K, k=int(sys.argv[2]), M=M, sigma=0, which='LM')
    best = min(best, time.process_time() - cpu)
print(json.dumps({'s': best, 'values': sorted(values.tolist())}))
)";

/// SciPy's answer on the same matrices; none where there is no Python with SciPy (group bench of packages.txt).
std::optional<ordered_json> ask_scipy(const BeamStructure& structure) {
  const auto folder = work_directory() / "roseau-bench-modes";
  std::filesystem::create_directories(folder);
  {
    std::ofstream matrices(folder / "matrices", std::ios::binary);
    write_sparse(matrices, structure.stiffness);
    write_sparse(matrices, structure.mass);
    std::ofstream(folder / "modes.py") << kScipyScript;
  }
  std::optional<ordered_json> answer;
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    const std::string command = std::string("OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 ") + python + " '" +
                                (folder / "modes.py").string() + "' '" + (folder / "matrices").string() + "' " +
                                std::to_string(kModes) + " " + std::to_string(kRounds) + " 2>/dev/null";
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string text;
    std::array<char, 4096> part{};
    while (pipe && std::fgets(part.data(), part.size(), pipe.get()) != nullptr) text += part.data();
    answer = ordered_json::parse(text, nullptr, false);
    if (answer->is_object()) break;
    answer.reset();
  }
  std::filesystem::remove_all(folder);
  return answer;
}

/// Largest relative error of the first three bending frequencies of a round pole of `elements` against the closed form.
Result<double> pole_error(std::size_t elements) {
  constexpr std::array kRoots{1.8751040687119611, 4.6940911329741746, 7.8547574382376126};
  const auto pole = structure::cantilever({.length_m = 2, .segment_count = elements});
  if (!pole) return pole.error();
  const auto model = ModalModel::build(*pole, {}, {.mode_count = 6});
  if (!model) return model.error();
  double worst = 0;
  for (std::size_t i = 0; i < kRoots.size(); ++i) {
    const double truth = kRoots[i] * kRoots[i] / 4 * std::sqrt(1e10 * 0.02 * 0.02 / 4 / 1000) / (2 * std::numbers::pi);
    worst = std::max(worst, std::abs(model->natural_frequency_hz(2 * i) / truth - 1));
  }
  return worst;
}

Result<void> add_closed_forms(ordered_json& figures) {
  std::array<double, 3> errors{};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const auto error = pole_error(std::size_t{10} << i);
    if (!error) return error.error();
    errors[i] = *error;
  }
  figures["cantilever_20_elements_error_ratio"] = errors[1];
  figures["cantilever_convergence_order"] = std::log2(errors[0] / errors[1]);
  return {};
}

Result<ordered_json> modes() {
  const auto tree = bench_tree();
  if (!tree) return tree.error();
  const auto structure = structure::assemble_beams(*tree, {});
  if (!structure) return structure.error();
  const auto found = structure::first_modes(*structure, {.mode_count = kModes});
  if (!found) return found.error();
  const double assembly_s =
      1e-6 * microseconds_per_call(1, [&tree](int) { static_cast<void>(structure::assemble_beams(*tree, {})); });
  const double search_s = 1e-6 * microseconds_per_call(1, [&structure](int) {
                            static_cast<void>(structure::first_modes(*structure, {.mode_count = kModes}));
                          });
  const auto hz = [&found](Eigen::Index mode) { return std::sqrt(found->stiffness_per_s2[mode]) / (2 * std::numbers::pi); };
  ordered_json figures{{"case", "modes"},
                       {"tree", tree->name},
                       {"nodes", tree->nodes.size()},
                       {"modes", kModes},
                       {"first_frequency_hz", hz(0)},
                       {"last_frequency_hz", hz(kModes - 1)},
                       {"largest_residual_ratio", found->largest_residual},
                       {"assembly_s", assembly_s},
                       {"modes_s", search_s}};
  if (const auto scipy = ask_scipy(*structure)) {
    const auto values = (*scipy)["values"].get<std::vector<double>>();
    double worst = 0;
    for (std::size_t i = 0; i < kModes; ++i) {
      const double difference = std::sqrt(found->stiffness_per_s2[static_cast<Eigen::Index>(i)] / values[i]) - 1;
      worst = std::max(worst, std::abs(difference));
    }
    figures["reference_modes_s"] = (*scipy)["s"];
    figures["frequency_difference_ratio"] = worst;
  } else {
    figures["reference"] = "absent: no python3 with SciPy";
  }
  if (auto added = add_closed_forms(figures); !added) return added.error();
  return figures;
}

// ---- projection ---------------------------------------------------------------------------------------------------------

class ShearedWind : public WindField {
 public:
  explicit ShearedWind(double exponent) : exponent_(exponent) {}
  Vec3 velocity_mps(const Vec3& point, double time_s) const override {
    const double gust = 1 + 0.3 * std::sin(1.7 * time_s);
    return {5 * gust * std::pow(std::max(point.z, 0.1) / 3, exponent_), 1.5 * std::cos(0.9 * time_s), 0};
  }

 private:
  double exponent_;
};

/// Costs nothing: what is measured is the tree.
class ConstantWind : public WindField {
 public:
  Vec3 velocity_mps(const Vec3& /*point*/, double /*time_s*/) const override { return {5, 1, 0}; }
  void velocities_mps(std::span<const Vec3> /*points*/, double /*time_s*/, std::span<Vec3> out) const override {
    std::ranges::fill(out, Vec3{5, 1, 0});
  }
};

/// A crown of about 500 nodes.
Result<TreeModel> tree_of_500_nodes() {
  structure::GrownTreeOptions options;
  for (options.main_branch_count = 18; options.main_branch_count > 1; --options.main_branch_count) {
    auto tree = structure::grow_tree(options);
    if (!tree || tree->nodes.size() <= 500) return tree;
  }
  return structure::grow_tree(options);
}

Result<void> add_differences(DragLoad& load, const TreeModel& tree, ordered_json& figures) {
  std::vector<double> times_s(400);
  for (std::size_t i = 0; i < times_s.size(); ++i) times_s[i] = 0.25 * static_cast<double>(i);
  const auto difference = [&](const WindField& wind) {
    return structure::compare_projection(load, wind, times_s).relative_rms;
  };
  figures["difference_uniform_ratio"] = difference(ShearedWind(0));
  figures["difference_sheared_ratio"] = difference(ShearedWind(0.3));
  synthesis::WindRegion region{.crown = synthesis::WindRegion::Box{}};
  for (const auto& node : tree.nodes) {
    auto& [low, high] = *region.crown;
    low = {std::min(low.x, node.position_m.x), std::min(low.y, node.position_m.y), 0};
    high = {std::max(high.x, node.position_m.x), std::max(high.y, node.position_m.y), std::max(high.z, node.position_m.z)};
  }
  const auto turbulence = synthesis::TurbulentWind::make({.profile_exponent = 0.3}, 1, region);
  if (!turbulence) return turbulence.error();
  figures["difference_turbulent_ratio"] = difference(**turbulence);
  return {};
}

Result<ordered_json> projection() {
  const auto tree = tree_of_500_nodes();
  if (!tree) return tree.error();
  const auto model = ModalModel::build(*tree, {}, {.mode_count = kModes});
  if (!model) return model.error();
  auto load = DragLoad::build(*tree, *model, {});
  if (!load) return load.error();
  const structure::WindProjection basis(*load);
  ordered_json figures{
      {"case", "projection"}, {"nodes", tree->nodes.size()}, {"points", load->points_in_world().size()}, {"modes", kModes}};

  const ShearedWind wind(0.3);
  std::vector<Vec3> air_mps(load->points_in_world().size());
  wind.velocities_mps(load->points_in_world(), 0, air_mps);
  const Eigen::VectorXd q_dot = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(kModes), 0.01);
  Eigen::VectorXd force;
  figures["full_us"] = microseconds_per_call(2000, [&](int) { load->modal_force(air_mps, q_dot, force); });
  auto streamlined = DragLoad::build(*tree, *model, {.foliage_vogel_exponent = -0.6});
  if (!streamlined) return streamlined.error();
  figures["full_vogel_us"] = microseconds_per_call(2000, [&](int) { streamlined->modal_force(air_mps, q_dot, force); });
  figures["projection_us"] = microseconds_per_call(20'000, [&](int) { basis.modal_force(air_mps[0], force); });

  const ConstantWind constant;
  auto sway = structure::SwaySimulation::make(*model, *load, constant, {});
  if (!sway) return sway.error();
  figures["step_full_us"] = microseconds_per_call(1000, [&](int) { sway->advance(); });
  structure::SwayOptions options;
  options.load = structure::SwayOptions::Load::projection;
  auto projected = structure::SwaySimulation::make(*model, *load, constant, options);
  if (!projected) return projected.error();
  figures["step_projection_us"] = microseconds_per_call(10'000, [&](int) { projected->advance(); });
  if (auto added = add_differences(*load, *tree, figures); !added) return added.error();
  return figures;
}

}  // namespace

void add_mechanics_cases(std::vector<Case>& cases) {
  cases.push_back({"modes", "a digitised walnut's 25 modes, beside SciPy's and closed forms", modes});
  cases.push_back({"projection", "the wind's push by full integration and by projection: cost and difference", projection});
}

}  // namespace roseau::bench
