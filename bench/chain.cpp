// chain: the whole way from mechanics to an estimate, as the real programs go it: a pole with closed forms in turbulent wind,
// filmed, recorded, tracked, identified, inverted; calibrated against the sonic on the first 300 s, then held, and judged on
// the rest against the wind at the pole. In 0 to 1 Hz, as docs/estimation.md has it.
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <vector>

#include "bench/bench.h"
#include "bench/program.h"
#include "recorder/format/indexed_reader.h"
#include "schema/conversion.h"
#include "synthesis/scene.h"
#include "tests/support/sway_simulation.h"

namespace roseau::bench {

namespace {

constexpr const char* kScene = ROSEAU_SOURCE_DIR "/config/scenes/cantilever.toml";
constexpr const char* kSeconds = "600";
constexpr double kCalibrated_s = 300;
constexpr double kBand_hz = 1;
constexpr double kEdge_s = 15;  // the band filter's ends are not scored
// Nothing in so narrow a view stands still to see the camera by; it stands firm.
constexpr const char* kConfig = R"(
[tracking]
subtract_background = false
[estimation]
image_plane_direction_deg = 270
window_s = 240
lag_s = 0.25
calibration_final_after_s = 270
)";

/// One topic's samples by their sample time in nanoseconds.
template <class T>
Result<std::map<std::int64_t, T>> read_topic(mcap::IndexedReader& reader, const std::string& topic, SampleKind kind) {
  const mcap::Channel* channel = reader.channel_of_topic(topic);
  if (channel == nullptr) return Error{ErrorCode::not_found, topic + " is not in the recording"};
  std::map<std::int64_t, T> samples;
  const StreamTable no_streams;
  auto messages = reader.messages({.channels = {{channel->id}}});
  while (true) {
    const auto message = messages.next();
    if (!message) return message.error();
    if (!*message) return samples;
    const auto sample = schema::parse(kind, (*message)->message.data, {}, no_streams);
    if (!sample) return sample.error();
    samples[to_ns(sample->header.sample_time)] = std::get<T>(sample->payload);
  }
}

struct Series {
  std::vector<double> estimate;
  std::vector<double> truth;
  double period_s = 0;
};

/// What was estimated after the calibration stood, with the truth about the same frames.
Result<Series> judged(mcap::IndexedReader& reader) {
  const auto estimates = read_topic<WindEstimate>(reader, "/camera0/target/tip/wind", SampleKind::wind_estimate);
  if (!estimates) return estimates.error();
  const auto truths = read_topic<WindEstimate>(reader, "/truth/camera0/target/tip/force", SampleKind::wind_estimate);
  if (!truths) return truths.error();
  Series series;
  const std::int64_t begin_ns = truths->begin()->first;
  std::int64_t last_ns = 0;
  for (const auto& [time_ns, estimate] : *estimates) {
    const auto truth = truths->find(time_ns);
    if (truth == truths->end() || static_cast<double>(time_ns - begin_ns) * 1e-9 < kCalibrated_s) continue;
    if (last_ns != 0 && series.period_s == 0) series.period_s = static_cast<double>(time_ns - last_ns) * 1e-9;
    last_ns = time_ns;
    series.estimate.push_back(estimate.wind_mps);
    series.truth.push_back(truth->second.wind_mps);
  }
  if (series.estimate.size() < 1000) return Error{ErrorCode::truncated, "too few estimates in the recording"};
  return series;
}

/// First natural frequency of a uniform pole with a mass at its tip, clamped at its foot: root of
/// 1 + cos b cosh b + (m / (mu L)) b (cos b sinh b - sin b cosh b) = 0, f = b^2 / (2 pi L^2) sqrt(E I / mu)   (Blevins 1979).
double closed_form_hz(const synthesis::Scene& scene) {
  const auto& pole = scene.tree.cantilever;
  const double length_m = pole.length_m;
  const double radius_m = pole.start_radius_m;
  const double young_pa = scene.mechanics.young_modulus_gpa * 1e9;
  const double density_kg_m3 = scene.mechanics.wood_density_kg_m3;
  const double board_area_m2 = pole.board_length_m * pole.board_width_m * std::numbers::pi / 4;  // leaves are ellipses
  const double leaf_mass_kg_m2 = scene.mechanics.leaf_mass_kg_m2;
  const double mass_per_m = density_kg_m3 * std::numbers::pi * radius_m * radius_m;
  const double stiffness = young_pa * std::numbers::pi * std::pow(radius_m, 4) / 4;
  const double ratio = leaf_mass_kg_m2 * board_area_m2 / (mass_per_m * length_m);
  const auto equation = [ratio](double b) {
    return 1 + std::cos(b) * std::cosh(b) + ratio * b * (std::cos(b) * std::sinh(b) - std::sin(b) * std::cosh(b));
  };
  double low = 0.5;
  double high = 1.9;
  for (int i = 0; i < 100; ++i) (equation((low + high) / 2) > 0 ? low : high) = (low + high) / 2;
  return low * low / (2 * std::numbers::pi * length_m * length_m) * std::sqrt(stiffness / mass_per_m);
}

Result<nlohmann::ordered_json> chain() {
  std::ifstream file(kScene);
  const auto scene = synthesis::scene_from_toml(std::string(std::istreambuf_iterator<char>(file), {}), kScene);
  if (!scene) return scene.error();
  const Workplace place;
  place.write("chain.toml", kConfig);
  const std::string session = place.file("chain.mcap");
  if (auto made = run_program(place, {"simulate", kScene, "-o", session, "--seconds", kSeconds, "--json"}); !made)
    return made.error();
  const auto replay = run_program(place, {"replay", session, "--max", "--headless", "--json", "--config",
                                          place.file("chain.toml"), "--record", place.file("recordings")});
  if (!replay) return replay.error();
  auto reader = mcap::IndexedReader::open(std::filesystem::path((*replay)["session"]["recording"].get<std::string>()));
  if (!reader) return reader.error();
  const auto series = judged(**reader);
  if (!series) return series.error();
  const auto truth = read_topic<Identification>(**reader, "/truth/target/tip/identification", SampleKind::identification);
  if (!truth) return truth.error();
  const auto displacements =
      read_topic<Displacement>(**reader, "/truth/camera0/target/tip/displacement", SampleKind::displacement);
  if (!displacements) return displacements.error();
  double mean_px = 0;
  for (const auto& [time_ns, moved] : *displacements) mean_px += moved.x / static_cast<double>(displacements->size());

  const auto in_band = [&series](const std::vector<double>& values) {
    auto filtered = testing::zero_phase_low_pass(values, series->period_s, kBand_hz);
    const auto edge = static_cast<std::ptrdiff_t>(kEdge_s / series->period_s);
    return std::vector<double>(filtered.begin() + edge, filtered.end() - edge);
  };
  const auto estimate = in_band(series->estimate);
  const auto wind = in_band(series->truth);
  const auto& target = (*replay)["targets"]["camera0/tip"];
  const double found_hz = target["natural_frequency_hz"].get<double>();
  const double model_hz = truth->begin()->second.natural_frequency_hz;
  return nlohmann::ordered_json{
      {"case", "chain"},
      {"natural_frequency_hz", found_hz},
      {"reference_natural_frequency_hz", closed_form_hz(*scene)},
      {"model_natural_frequency_hz", model_hz},
      {"natural_frequency_error_percent", 100 * (found_hz / closed_form_hz(*scene) - 1)},
      {"floor_natural_frequency_sd_percent", 100 * target["natural_frequency_sd_hz"].get<double>() / found_hz},
      {"damping_ratio", target["damping_ratio"]},
      {"reference_damping_ratio", truth->begin()->second.damping_ratio},
      {"mean_deflection_px", mean_px},
      {"judged_s", static_cast<double>(series->estimate.size()) * series->period_s},
      {"band_1p0_lag_0p25_correlation", testing::correlation(estimate, wind)},
      {"band_1p0_lag_0p25_rms_mps", testing::rms_difference(estimate, wind)}};
}

}  // namespace

void add_chain_cases(std::vector<Case>& cases) {
  cases.push_back(
      {"chain", "a pole in the wind: simulated, filmed, tracked and inverted; against closed forms and true wind", chain});
}

}  // namespace roseau::bench
