// Laser-scanned trees as quantitative structure models: a table of cylinders fitted to the point cloud, one row each, as
// TreeQSM and its kin write them. Metres and radians; z up.
//
//   1 radius  2 length  3-5 start x y z  6-8 axis x y z  9 parent row (1-based; 0: the foot)
//   [10 extension  11 branch  12 branch order  13 position in branch  14 added to close a gap]
//
// A branch begins somewhere along its parent cylinder, so that one is split there (a branch that begins within half the
// parent's radius of an end, or of another branch, uses that point). Mended, and counted in the notes:
//   axis of another length than 1      only its direction counts
//   start off the parent's axis        up to the parent's radius + 1 cm: the cylinder is stretched to the axis; beyond that,
//                                      wood of its own radius bridges the gap
//   no length                          left out, and what it bears hangs on its parent
//   no branch orders (under 12 columns)  the thickest cylinder at a parent's end goes on, the others branch off
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "structure/tree/imported_tree.h"

namespace roseau::structure {

/// The table as it stands.
struct QsmTable {
  std::size_t columns = 0;
  std::vector<double> values;      // row by row
  std::vector<std::size_t> lines;  // of each row, for messages: the text's line, or the row counted from 1

  std::size_t rows() const { return columns == 0 ? 0 : values.size() / columns; }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// A tree of a table. Errors (corrupt) name source and row: fewer than 9 columns; values that are not finite, radii not
/// positive; parents that do not exist, form a loop, or are missing for more than one row; more than 500 m from the foot.
Result<ImportedTree> tree_from_cylinders(const QsmTable& table, const std::string& source_name);

/// Numbers between blanks, commas or semicolons; lines that begin with a letter, # or % are passed over.
Result<ImportedTree> read_qsm_text(std::string_view text, const std::string& source_name);

/// A MATLAB file: its one real matrix of at least 9 columns.
Result<ImportedTree> read_qsm_mat(const std::filesystem::path& path);

}  // namespace roseau::structure
