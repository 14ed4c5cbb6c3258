// From a tree and its mechanics to what the animation takes.
#pragma once

#include "core/geometry.h"
#include "core/result.h"
#include "structure/animation/large_amplitude.h"
#include "structure/animation/modal_basis.h"
#include "structure/mechanics/drag_load.h"
#include "structure/mechanics/modal_model.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

Skeleton skeleton(const TreeModel& tree);

/// The model's modes with the wind projection of `load`, both of the same tree. `mean_wind_mps` is the wind, in the tree's
/// frame, that the forest will mostly see:
/// - its aerodynamic damping is added to the modes' own (none in still air, or where the load has no relative velocity);
/// - wood or leaves that yield to the wind (a Vogel exponent) push as the square law that agrees at its speed.
/// Error (invalid_argument): a Vogel exponent without a wind.
Result<ModalBasis> modal_basis(const ModalModel& model, const DragLoad& load, const Vec3& mean_wind_mps);

}  // namespace roseau::structure
