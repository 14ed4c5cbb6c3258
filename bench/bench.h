// roseau-bench: one case per figure we promise. A case measures, and returns one flat object of figures named with their unit;
// a figure that has a floor or a reference carries it beside ("floor_...", "reference_...").
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"

namespace roseau::bench {

struct Case {
  std::string name;
  std::string what;  // one line for the list of cases
  std::function<Result<nlohmann::ordered_json>()> run;
};

/// Where cases may put large files, that they remove again: --dir, else the system's directory for temporary files.
const std::filesystem::path& work_directory();
/// --seconds, for cases that run as long as they are told.
std::optional<double> work_seconds();

/// Each folder's cases register themselves here; main.cpp calls every one of these.
void add_animation_cases(std::vector<Case>& cases);
void add_chain_cases(std::vector<Case>& cases);
void add_estimation_cases(std::vector<Case>& cases);
void add_image_cases(std::vector<Case>& cases);
void add_mechanics_cases(std::vector<Case>& cases);
void add_pipeline_cases(std::vector<Case>& cases);
void add_reading_cases(std::vector<Case>& cases);
void add_recording_cases(std::vector<Case>& cases);
void add_soak_cases(std::vector<Case>& cases);
void add_synthesis_cases(std::vector<Case>& cases);
void add_tracking_cases(std::vector<Case>& cases);
void add_wind_cases(std::vector<Case>& cases);

}  // namespace roseau::bench
