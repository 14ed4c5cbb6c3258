// Samples as rows of a table, one table per kind of sample. Pure.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/sample.h"

namespace roseau::recorder {

using Field = std::variant<double, std::int64_t, std::string>;

struct Column {
  std::string name;         // with its unit: "u_mps"
  std::string unit;         // for units attributes: "m s-1"; "1" without one, empty for text
  std::string description;  // for people
};

/// What comes behind time, sequence and status.
const std::vector<Column>& columns_of(SampleKind kind);

/// The rows of one sample: one, or one for each thing that it holds.
std::vector<std::vector<Field>> rows_of(const Sample& sample);

}  // namespace roseau::recorder
