// Checking a session file to the last byte, for `roseau verify`: every checksum of the format, the order of the inputs, the
// counts against what the file says of itself, and every message of a known kind.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"

namespace roseau::recorder {

struct Verification {
  std::uint64_t bytes = 0;
  std::uint64_t messages = 0;
  std::uint64_t attachments = 0;
  bool is_complete = false;  // read to the closing magic
  /// What is wrong, in words that say where and what is lost. The first hundred; `problem_count` counts all.
  std::vector<std::string> problems;
  std::uint64_t problem_count = 0;
};

/// `progress` is called now and then with the share done. An Error only when the file cannot be opened at all.
Result<Verification> verify_session(const std::filesystem::path& path, const std::function<void(double)>& progress = {});

}  // namespace roseau::recorder
