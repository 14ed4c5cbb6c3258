// TruthJudge: compares what was tracked and estimated with what the simulation knows. A session carries its truth on topics
// under /truth; without them this keeps silent.
//
//   /truth/camera0/target/branch/displacement   against  /camera0/target/branch/displacement
//   /truth/target/branch/identification         against  /<camera>/target/branch/identification (natural frequency)
//   /truth/wind                                 against  accepted, calibrated wind estimates, as the component along the
//                                                        direction their calibration names
//   /truth/camera0/exposure                     against  the sample times that the frames of camera0 were given, the nearest
//   /truth/sonic/wind                           against  the sample times of /sonic/wind, the nearest
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/stream.h"
#include "daemon/nearest_truth.h"

namespace roseau::daemon {

struct ErrorFigures {
  double rms = 0;
  double p95 = 0;
  double max = 0;
  std::string unit;
  std::size_t count = 0;
};

/// One thread at a time.
class TruthJudge {
 public:
  explicit TruthJudge(const StreamTable& streams) : streams_(streams) {}

  /// Any sample of the analysed stream, in its order.
  void see(const Sample& sample);

  /// By quantity: "displacement_x/camera0/branch", "natural_frequency/camera0/branch", "wind/camera0/branch", "clock/sonic".
  /// Displacements are compared about their means: each side has its own zero.
  std::map<std::string, ErrorFigures> figures() const;

 private:
  struct TimedValue {
    HostTime time;
    double value = 0;
  };
  struct Pair {
    std::vector<TimedValue> truth;      // waiting for their partner
    std::vector<TimedValue> estimates;  // waiting for their partner
    std::vector<double> errors;
    bool about_mean = false;
    std::string unit;
  };
  struct TimedWind {
    HostTime time;
    WindSample wind;
  };

  void see_sample_time(const std::string& topic, const Sample& sample);
  void see_displacement(const std::string& topic, const Sample& sample, const Displacement& displacement);
  void see_identification(const std::string& topic, const Identification& identification);
  void see_truth_wind(const Sample& sample, const WindSample& wind);
  void see_wind_estimate(const std::string& topic, const Sample& sample, const WindEstimate& estimate);
  void pair_up(Pair& pair, HostTime time, double value, bool is_truth);
  std::optional<double> true_wind_at(HostTime time, double direction_deg) const;

  const StreamTable& streams_;
  std::map<std::string, Pair> pairs_;
  std::map<std::string, double> true_frequency_hz_;   // by target name
  std::map<std::string, double> wind_direction_deg_;  // by target, from its calibration
  std::vector<TimedWind> true_wind_;                  // the last seconds
  double true_wind_north_offset_deg_ = 0;
  std::map<std::string, NearestTruth> sample_times_;  // by device, of those that have true times
};

}  // namespace roseau::daemon
