// What stands in the landscape, each as layers on vertical planes: a barn and a fence far behind, the tree, its branch that
// moves, the sonic on its mast.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry.h"
#include "synthesis/camera/canvas.h"

namespace roseau::synthesis {

Layer draw_barn(double px_per_m, double blur_px);
Layer draw_fence(double px_per_m, double blur_px, std::uint64_t seed);
Layer draw_sonic(const Vec3& position_in_world, double px_per_m, double blur_px);

/// Trunk, boughs and the crown that does not move, far layers first. The moving branch springs from `branch_root_in_world`.
std::vector<Layer> draw_tree(const Vec3& branch_root_in_world, double branch_length_m, double px_per_m, double blur_px,
                             std::uint64_t seed);

/// The branch at rest.
Layer draw_branch(const Vec3& root_in_world, double length_m, double px_per_m, double blur_px, std::uint64_t seed);

/// The part of draw_branch's layer that moves as a whole and holds its leaves: the target, at rest.
PlaneWindow branch_target_window(const Vec3& root_in_world, double length_m);

}  // namespace roseau::synthesis
