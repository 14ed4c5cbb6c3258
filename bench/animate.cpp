// The modal animation against the frame rates that the plant thesis measured on its graphics card (Tables 6.1 and 6.2): the
// whole frame (wind at every tree, modal forces, oscillators, displacement of every node), without drawing, on two threads.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include "bench/bench.h"
#include "core/random.h"
#include "structure/animation/aligned_floats.h"
#include "structure/animation/forest.h"
#include "structure/animation/forest_kernels.h"
#include "structure/animation/gust_wind.h"
#include "structure/animation/tree_animation.h"
#include "structure/tree/grown_tree.h"
#include "structure/tree/mtg.h"

namespace roseau::bench {

namespace {

using structure::Forest;
using structure::LargeAmplitudeCorrection;
using structure::ModalBasis;

constexpr unsigned kThreads = 2;
constexpr double kRoundSeconds = 0.015;
constexpr int kRoundsWithoutGain = 15;  // the best round counts, as the others had company on the machine: enough were tried
constexpr int kMostRounds = 80;
constexpr double kStepSeconds = 1.0 / 60;

struct Cell {
  std::size_t trees;
  std::size_t nodes;
  std::size_t modes;
  double reference_fps;  // GeForce 8800 GTS, rendering off (Table 6.1) and on, every node updated (Table 6.2)
  std::string name;
};

std::vector<Cell> cells() {
  std::vector<Cell> all;
  const auto table61 = [&](std::size_t trees, std::size_t nodes, double fps) {
    all.push_back({trees, nodes, 25, fps, "k" + std::to_string(trees) + "_n" + std::to_string(nodes)});
  };
  table61(100, 1000, 712);
  table61(100, 2000, 385);
  table61(100, 8000, 103);
  table61(1000, 100, 690);
  table61(1000, 500, 169);
  table61(1000, 1000, 87);
  table61(1000, 2000, 43);
  table61(1000, 8000, 11);
  table61(8000, 20, 426);
  table61(8000, 100, 102);
  table61(8000, 500, 21);
  table61(8000, 1000, 11);
  const auto table62 = [&](std::size_t modes, const std::vector<double>& fps) {
    const std::vector<std::size_t> trees{500, 1000, 2000, 4000};
    for (std::size_t i = 0; i < trees.size(); ++i) {
      all.push_back({trees[i], 3437, modes, fps[i], "m" + std::to_string(modes) + "_k" + std::to_string(trees[i])});
    }
  };
  table62(5, {73, 39, 19, 10});
  table62(15, {57, 29, 14, 7});
  table62(25, {43, 22, 11, 6});
  return all;
}

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Seconds per call in the best of several rounds.
double best_seconds(const std::function<void()>& work) {
  work();
  const double once_s = std::max(seconds_of(work), 1e-7);
  const int calls = std::max(1, static_cast<int>(kRoundSeconds / once_s));
  double best_s = once_s;
  for (int round = 0, last_gain = 0; round < kMostRounds && round - last_gain < kRoundsWithoutGain; ++round) {
    const double round_s = seconds_of([&] {
      for (int i = 0; i < calls; ++i) work();
    });
    if (round_s / calls < 0.99 * best_s) last_gain = round;
    best_s = std::min(best_s, round_s / calls);
  }
  return best_s;
}

double on_both_threads(const std::function<void(unsigned)>& work) {
  return best_seconds([&] {
    std::jthread other([&] { work(1); });
    work(0);
  });
}

double multiply_add_flops() {
  constexpr std::uint64_t kRepetitions = 400000;
  std::uint64_t operations = 0;
  const double seconds = on_both_threads([&](unsigned thread) {
    float sink = 1;
    const auto done = structure::burn_multiply_adds(kRepetitions, &sink);
    if (thread == 0) operations = done;
  });
  return kThreads * static_cast<double>(operations) / seconds;
}

// Writing the output alone, in whichever way is faster.
double write_seconds(std::size_t floats) {
  structure::AlignedFloats data(floats);
  const std::size_t half = floats / 2 / structure::kRowStep * structure::kRowStep;
  const std::size_t calls = std::max<std::size_t>(1, 25'000'000 / floats);  // so that starting a thread does not count
  double best_s = 1e9;
  for (const bool streaming : {false, true}) {
    best_s = std::min(best_s, on_both_threads([&](unsigned thread) {
                                for (std::size_t i = 0; i < calls; ++i) {
                                  structure::fill_memory(data.data() + thread * half, half, 1, streaming);
                                }
                              }) / static_cast<double>(calls));
  }
  return best_s;
}

ModalBasis random_basis(std::size_t nodes, std::size_t modes) {
  const auto columns = static_cast<Eigen::Index>(modes);
  ModalBasis basis{.shapes = Eigen::MatrixXd(static_cast<Eigen::Index>(3 * nodes), columns),
                   .natural_frequency_hz = Eigen::VectorXd::LinSpaced(columns, 0.4, 6),
                   .damping_coefficient_per_s = Eigen::VectorXd::Constant(columns, 0.3),
                   .wind_projection = Eigen::Matrix3Xd(3, columns)};
  const RandomStream numbers(1, 1);
  std::uint64_t next = 0;
  for (double& value : basis.shapes.reshaped()) value = numbers.uniform(next++, -1, 1);
  for (double& value : basis.wind_projection.reshaped()) value = numbers.uniform(next++, -0.01, 0.01);
  return basis;
}

LargeAmplitudeCorrection random_correction(const ModalBasis& basis) {
  return {.b = Eigen::VectorXd::Constant(basis.shapes.cols(), 0.5),
          .v = basis.shapes,
          .w = 0.1 * basis.shapes,
          .residual = Eigen::VectorXd::Zero(basis.shapes.cols())};
}

std::vector<structure::TreeInstance> stand(std::size_t count) {
  std::vector<structure::TreeInstance> trees(count);
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  for (std::size_t k = 0; k < count; ++k) {
    const double half_turn = 0.37 * static_cast<double>(k);
    const std::size_t row = k / side;
    trees[k] = {.position_in_world_m = {5 * static_cast<double>(k % side), 5 * static_cast<double>(row), 0},
                .world_from_tree = {std::cos(half_turn), 0, 0, std::sin(half_turn)}};
  }
  return trees;
}

Result<double> frame_seconds(const ModalBasis& basis, const LargeAmplitudeCorrection* correction, std::size_t trees) {
  const structure::ForestOptions options{.threads = kThreads};
  auto forest = correction != nullptr ? Forest::make(basis, *correction, stand(trees), options)
                                      : Forest::make(basis, stand(trees), options);
  if (!forest) return forest.error();
  const auto wind = structure::GustWind::with_intensity({6, 2, 0}, 0.3);
  double time_s = 0;
  return best_seconds([&] { forest->advance(kStepSeconds, wind, time_s += kStepSeconds); });
}

Result<void> measure(const Cell& cell, double flops, nlohmann::ordered_json& figures, double& least, double& least_corrected) {
  const double write_s = write_seconds(cell.trees * 3 * cell.nodes);
  const ModalBasis basis = random_basis(cell.nodes, cell.modes);
  const LargeAmplitudeCorrection correction = random_correction(basis);
  figures["reference_fps_" + cell.name] = cell.reference_fps;
  for (const bool corrected : {false, true}) {
    const auto frame_s = frame_seconds(basis, corrected ? &correction : nullptr, cell.trees);
    if (!frame_s) return frame_s.error();
    const std::string name = cell.name + (corrected ? "_corrected" : "");
    const double product = 2.0 * static_cast<double>(cell.trees * 3 * cell.nodes * cell.modes) * (corrected ? 2 : 1);
    const double ratio = 1 / *frame_s / cell.reference_fps;
    figures["fps_" + name] = 1 / *frame_s;
    figures["ratio_" + name] = ratio;
    figures["frame_" + name + "_us"] = *frame_s * 1e6;
    figures["floor_frame_" + name + "_us"] = std::max(write_s, product / flops) * 1e6;
    (corrected ? least_corrected : least) = std::min(corrected ? least_corrected : least, ratio);
  }
  return {};
}

// The alternatives to this way, in the cell of 1000 trees of 500 nodes: the product by Eigen (built for every PC, as it does
// not choose at run time), and the arctangents alone of a correction with a b for every node and mode.
void measure_alternatives(nlohmann::ordered_json& figures) {
  constexpr Eigen::Index kTrees = 1000;
  constexpr Eigen::Index kNodes = 500;
  constexpr Eigen::Index kModes = 25;
  const Eigen::MatrixXf shapes = random_basis(kNodes, kModes).shapes.cast<float>();
  const Eigen::MatrixXf q = Eigen::MatrixXf::Constant(kModes, kTrees, 0.3F);
  Eigen::MatrixXf out(3 * kNodes, kTrees);
  figures["eigen_product_k1000_n500_us"] = 1e6 * on_both_threads([&](unsigned thread) {
                                             out.middleCols(thread * kTrees / 2, kTrees / 2).noalias() =
                                                 shapes * q.middleCols(thread * kTrees / 2, kTrees / 2);
                                           });

  const std::vector<structure::ModeStep> steps(kModes, structure::ModeStep{.b = 0.5F});
  figures["arctangents_per_node_k1000_n500_us"] =
      1e6 * on_both_threads([&](unsigned) {
        structure::AlignedFloats amplitudes(kModes * structure::kTile);
        structure::AlignedFloats functions(2 * kModes * structure::kTile);
        std::fill_n(amplitudes.data(), amplitudes.size(), 0.3F);
        for (std::size_t tile = 0; tile < kTrees * kNodes / structure::kTile / kThreads; ++tile) {
          structure::correct_modes(steps.data(), kModes, amplitudes.data(), functions.data());
        }
      });
}

// The walnut of the thesis, where the recordings are at hand; else a grown tree.
Result<structure::TreeModel> real_tree() {
  const char* set = std::getenv("ROSEAU_DATA");
  const auto data = set != nullptr ? std::filesystem::path(set) : std::filesystem::path(ROSEAU_SOURCE_DIR) / ".." / "shared";
  std::ifstream file(data / "data" / "mtg_walnut" / "noylum2.mtg");
  if (!file) return structure::grow_tree({});
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  auto walnut = structure::read_mtg(text, "noylum2.mtg");
  if (!walnut) return walnut.error();
  walnut->tree.name = "walnut noylum2";
  return std::move(walnut->tree);
}

// How far segments are from their lengths, in percent, when one mode after the other moves its farthest node by a share of the
// range: the mean over the modes of the length-weighted root mean square over segments.
Result<void> measure_lengths(const structure::Skeleton& bones, const Eigen::MatrixXd& shapes, double range_m,
                             nlohmann::ordered_json& figures) {
  std::vector<double> range;
  for (const auto& shape : shapes.colwise()) range.push_back(structure::amplitude_for(shape, range_m));
  Result<LargeAmplitudeCorrection> shared = LargeAmplitudeCorrection{};
  Result<structure::NodeWiseCorrection> node_wise = structure::NodeWiseCorrection{};
  figures["range_m"] = range_m;
  figures["fit_s"] = seconds_of([&] { shared = structure::fit_correction(bones, shapes, range); });
  figures["node_wise_fit_s"] = seconds_of([&] { node_wise = structure::fit_node_wise_correction(bones, shapes, range); });
  if (!shared) return shared.error();
  if (!node_wise) return node_wise.error();
  figures["fit_residual_percent"] = 100 * shared->residual.mean();
  figures["node_wise_fit_residual_percent"] = 100 * node_wise->residual.mean();
  for (const int percent : {25, 50, 75, 100}) {
    double linear = 0;
    double corrected = 0;
    double with_node_b = 0;
    for (Eigen::Index i = 0; i < shapes.cols(); ++i) {
      Eigen::VectorXd q = Eigen::VectorXd::Zero(shapes.cols());
      q[i] = 0.01 * percent * range[static_cast<std::size_t>(i)];
      linear += structure::length_error(bones, shapes * q).rms;
      corrected += structure::length_error(bones, shared->displacement_m(q)).rms;
      with_node_b += structure::length_error(bones, node_wise->displacement_m(q)).rms;
    }
    const std::string at = "_at_" + std::to_string(percent) + "_percent_of_range_percent";
    const double scale = 100.0 / static_cast<double>(shapes.cols());
    figures["length_error_linear" + at] = scale * linear;
    figures["length_error_corrected" + at] = scale * corrected;
    figures["length_error_node_wise" + at] = scale * with_node_b;
  }
  return {};
}

// The same for all modes at once, bent by a steady wind from the west.
void measure_lengths_in_wind(const structure::Skeleton& bones, const ModalBasis& basis,
                             const LargeAmplitudeCorrection& correction, nlohmann::ordered_json& figures) {
  for (const int wind_mps : {5, 10, 15}) {
    const Eigen::ArrayXd force = wind_mps * wind_mps * basis.wind_projection.row(0).transpose().array();
    const Eigen::VectorXd q = force / (2 * std::numbers::pi * basis.natural_frequency_hz.array()).square();
    const Eigen::VectorXd linear = basis.shapes * q;
    const std::string in = "_in_" + std::to_string(wind_mps) + "mps";
    figures["farthest_motion" + in + "_m"] = linear.cwiseAbs().maxCoeff();
    figures["length_error_linear" + in + "_percent"] = 100 * structure::length_error(bones, linear).rms;
    figures["length_error_corrected" + in + "_percent"] =
        100 * structure::length_error(bones, correction.displacement_m(q)).rms;
  }
}

// A real tree's modes: what the correction keeps, and that a frame takes as long as with random numbers.
Result<void> measure_real_tree(nlohmann::ordered_json& figures) {
  constexpr std::size_t kTrees = 1000;
  constexpr Eigen::Index kComparedModes = 8;  // a fit per node takes long
  const auto tree = real_tree();
  if (!tree) return tree.error();
  const auto model = structure::ModalModel::build(*tree, {}, {.mode_count = 25});
  if (!model) return model.error();
  const auto load = structure::DragLoad::build(*tree, *model, {});
  if (!load) return load.error();
  const auto basis = structure::modal_basis(*model, *load, {6, 2, 0});
  if (!basis) return basis.error();
  figures["tree"] = tree->name;
  figures["tree_nodes"] = tree->nodes.size();

  const auto bones = structure::skeleton(*tree);
  if (auto measured = measure_lengths(bones, basis->shapes.leftCols(kComparedModes), 1, figures); !measured) return measured;
  const auto correction = structure::fit_correction(bones, basis->shapes, structure::amplitudes_in_wind(*basis, 15));
  if (!correction) return correction.error();
  measure_lengths_in_wind(bones, *basis, *correction, figures);
  for (const bool corrected : {false, true}) {
    const auto frame_s = frame_seconds(*basis, corrected ? &*correction : nullptr, kTrees);
    if (!frame_s) return frame_s.error();
    figures[corrected ? "fps_tree_k1000_corrected" : "fps_tree_k1000"] = 1 / *frame_s;
  }
  return {};
}

Result<nlohmann::ordered_json> animate() {
  nlohmann::ordered_json figures{{"case", "animate"}, {"instruction_set", structure::instruction_set()}, {"threads", kThreads}};
  const double flops = multiply_add_flops();
  figures["multiply_add_gflops"] = flops * 1e-9;
  figures["least_ratio"] = 0;
  figures["least_ratio_corrected"] = 0;
  double least = 1e9;
  double least_corrected = 1e9;
  for (const Cell& cell : cells()) {
    if (auto measured = measure(cell, flops, figures, least, least_corrected); !measured) return measured.error();
  }
  measure_alternatives(figures);
  if (auto measured = measure_real_tree(figures); !measured) return measured.error();
  figures["least_ratio"] = least;
  figures["least_ratio_corrected"] = least_corrected;
  return figures;
}

}  // namespace

void add_animation_cases(std::vector<Case>& cases) {
  cases.push_back({"animate", "frame rates of forests by modal animation, beside the thesis's", animate});
}

}  // namespace roseau::bench
