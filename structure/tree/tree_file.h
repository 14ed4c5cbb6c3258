// A tree from a file of any kind that can be read.
#pragma once

#include <filesystem>
#include <optional>

#include "core/result.h"
#include "structure/tree/imported_tree.h"
#include "structure/tree/mtg.h"

namespace roseau::structure {

struct TreeFileOptions {
  MtgOptions mtg;
  /// A dressing file, whose units take precedence over `mtg`'s.
  std::optional<std::filesystem::path> dressing;
  /// Without one: take that of the same name beside the .mtg file, if there is one.
  bool look_for_dressing = true;
};

/// By the name's ending: .mtg (digitised), .mat (cylinders, MATLAB), anything else: cylinders as text. Errors (not_found, and
/// those of mtg.h and qsm.h) name the file.
Result<ImportedTree> read_tree(const std::filesystem::path& path, const TreeFileOptions& options = {});

}  // namespace roseau::structure
