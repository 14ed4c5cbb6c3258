// Reads a Python dictionary of literals, as much as .cameramodel files need: strings, numbers, lists. Everything else that a
// literal may hold is skipped over.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/result.h"

namespace roseau::calib {

struct PythonValue {
  int line = 0;  // where it begins, from 1
  /// Text, one number, a list of numbers; monostate for any other value.
  std::variant<std::monostate, std::string, double, std::vector<double>> value;
};

using PythonDictionary = std::map<std::string, PythonValue, std::less<>>;

/// Errors name the line.
Result<PythonDictionary> parse_python_dictionary(std::string_view text);

}  // namespace roseau::calib
