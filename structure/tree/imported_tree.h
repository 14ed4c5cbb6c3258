// What the readers of digitised and scanned trees hand back: the tree, and what they had to mend to get it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "structure/tree/tree_model.h"

namespace roseau::structure {

/// Something in the source that is not as it should be, or is not said there, and what was done about it.
struct ImportNote {
  std::string what;  // "elements of no length, joined with the one they stand on"
  std::size_t count = 0;
  std::size_t first_line = 0;  // of the file, or row of the table; 0: of no line in particular
};

struct ImportedTree {
  TreeModel tree;
  std::size_t elements = 0;         // that the source describes
  std::size_t placed_elements = 0;  // of these, with a position
  Vec3 foot_in_source_m;            // where the foot stood before it was shifted to the origin
  std::vector<ImportNote> notes;    // in a fixed order, each with a count above 0
};

}  // namespace roseau::structure
