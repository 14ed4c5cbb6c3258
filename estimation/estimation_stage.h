// EstimationStage: the ordered stream in, estimates out. On line and off line, live and replayed: the same code.
//
//   in    /camera0/target/branch/displacement, /displacement/<name> (imported series); not /truth/...
//         a stream of wind: the reference (topic from the options, else the first that is not truth)
//         operator actions: a target added or removed begins anew
//   out   .../identification, .../spectrum (every hop), .../wind (every displacement sample, at its own sample time, `lag`
//         later), .../calibration: the displacement's topic with its last word replaced; for /displacement/<name> that word
//         is appended
//         /wind/estimate: all targets together
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/stage.h"
#include "core/stream.h"
#include "core/wind_geometry.h"
#include "estimation/options.h"
#include "estimation/target_estimator.h"
#include "estimation/wind_fusion.h"

namespace roseau::estimation {

/// Topic of a target's result ("wind", "identification", ...) from the topic of its displacement.
std::string result_topic(std::string_view displacement_topic, std::string_view result);

/// True for the topics that are estimated from.
bool is_displacement_topic(std::string_view topic);

class EstimationStage : public Stage {
 public:
  /// `streams` must outlive the stage; the results' streams are added to it.
  EstimationStage(StreamTable& streams, EstimationOptions options);
  EstimationStage(const EstimationStage&) = delete;
  EstimationStage& operator=(const EstimationStage&) = delete;

  void process(const Sample& input, SampleSink& out) override;

  /// Appends everything that process() has built up: a stage that loads it goes on with the same bits. Options are not part
  /// of it.
  void save(std::vector<std::byte>& out) const;
  /// Replaces the state. Error (corrupt): the bytes are not a state of this version; the stage is then empty.
  Result<void> load(std::span<const std::byte> in);

  struct TargetCalibration {
    std::string topic;  // of the displacement
    CalibrationFit fit;
  };
  /// Calibration of every target on all data so far, with 95 % confidence intervals: for a report at the end.
  std::vector<TargetCalibration> calibrations(int bootstrap_replicates = 200) const;
  /// Empty while there is no reference.
  const std::string& reference_topic() const { return reference_topic_; }

 private:
  struct Output {
    StreamId stream = 0;
    std::uint32_t sequence = 0;
  };
  struct Target {
    explicit Target(const EstimationOptions& options) : estimator(options) {}
    std::optional<TargetEstimator> estimator;  // never empty; optional so that it can be made anew
    Output identification;
    Output spectrum;
    Output wind;
    Output calibration;
  };

  void take_wind(const Sample& input, const WindSample& wind);
  void take_displacement(const Sample& input, const Displacement& displacement, SampleSink& out);
  void take_action(const OperatorAction& action);
  Target& target(const std::string& topic);
  Output add_output(const std::string& topic, SampleKind kind, const std::string& device, const std::string& source);
  void emit(Output& output, const Sample& input, HostTime sample_time, Payload payload, SampleSink& out) const;
  void clear();

  StreamTable& streams_;
  const EstimationOptions options_;
  std::string reference_topic_;
  GridSeries reference_;
  std::map<std::string, Target, std::less<>> targets_;  // by displacement topic
  WindFusion fusion_;
  Output fused_;
  bool has_fused_ = false;
};

}  // namespace roseau::estimation
