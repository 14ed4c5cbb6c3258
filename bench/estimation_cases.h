// The estimation folder's cases; registered together in estimation_identify.cpp.
#pragma once

#include <nlohmann/json.hpp>

#include "core/result.h"

namespace roseau::bench {

Result<nlohmann::ordered_json> run_identify();
Result<nlohmann::ordered_json> run_online();

}  // namespace roseau::bench
