// Real recordings live outside the project, under ROSEAU_DATA (default: ../shared beside the checkout). Tests that need them
// skip, saying so, where they are absent.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace roseau::testing {

inline std::filesystem::path data_root() {
  if (const char* set = std::getenv("ROSEAU_DATA"); set != nullptr && *set != '\0') return set;
  return std::filesystem::path(ROSEAU_SOURCE_DIR) / ".." / "shared";
}

}  // namespace roseau::testing

// `const auto path = ...; ` in the test's own scope, because only there can the test be skipped.
// NOLINTBEGIN(bugprone-macro-parentheses): a variable's name cannot stand in parentheses
#define ROSEAU_REQUIRE_DATA(variable, relative)                                                      \
  const std::filesystem::path variable = ::roseau::testing::data_root() / (relative);                \
  if (!std::filesystem::exists(variable)) {                                                          \
    GTEST_SKIP() << "real recording absent: " << variable << " (set ROSEAU_DATA to where they are)"; \
  }
// NOLINTEND(bugprone-macro-parentheses)
