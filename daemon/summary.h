// Summary: the one JSON object that `run` and `replay` end with (a contract: keys are added, none disappears), and the same
// in words for people.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/stream.h"
#include "daemon/truth_judge.h"

namespace roseau::daemon {

/// Listens to the analysed stream. One thread at a time; read when the run is over.
class ResultCollector {
 public:
  explicit ResultCollector(const StreamTable& streams) : streams_(streams), judge_(streams) {}

  void see(const Sample& sample);

  struct Target {
    Identification last_accepted;
    std::uint64_t identifications = 0;  // accepted
    std::uint64_t estimates = 0;        // accepted wind estimates
    WindCalibration calibration;
  };
  const std::map<std::string, Target>& targets() const { return targets_; }
  std::map<std::string, ErrorFigures> truth() const { return judge_.figures(); }
  /// Of the target whose calibration explains its reference best; null when there is none.
  const WindCalibration* best_calibration() const;

 private:
  const StreamTable& streams_;
  TruthJudge judge_;
  std::map<std::string, Target> targets_;
};

struct RunFacts {
  double duration_s = 0;  // of session time
  double wall_s = 0;      // it took
  std::string recording;  // path; empty: none
  std::string digest;
  std::map<std::string, StreamCounters> streams;  // by topic
  std::vector<ClockState> clocks;
  std::vector<std::pair<std::string, double>> cpu_s;     // by part of the pipeline
  std::map<std::string, std::uint64_t> display_dropped;  // by topic
};

/// Figures that are not known (NaN) are null.
std::string summary_json(const RunFacts& facts, const ResultCollector& results);
std::string summary_text(const RunFacts& facts, const ResultCollector& results);

}  // namespace roseau::daemon
