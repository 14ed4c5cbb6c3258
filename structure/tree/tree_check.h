// What every TreeModel keeps to. Importers and generators end with it, so that whoever takes a tree need not look again.
#pragma once

#include "core/result.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

/// At least one segment; the first node at the origin, without a parent; every other one after its parent; positions finite;
/// lengths and radii positive; each leaf on a node of the tree, with positive size and unit vectors at right angles.
/// Error (corrupt): names the tree and the first node or leaf that breaks a rule.
Result<void> check(const TreeModel& tree);

}  // namespace roseau::structure
