// WindRegion: where and how long a wind is wanted, which decides how large a field has to be made.
#pragma once

#include <optional>
#include <vector>

#include "core/geometry.h"

namespace roseau::synthesis {

struct WindRegion {
  struct Box {
    Vec3 low_in_world_m;
    Vec3 high_in_world_m;
  };
  std::optional<Box> crown;
  std::vector<Vec3> instruments_in_world_m;  // exact: nothing is interpolated at these places
  double duration_s = 0;                     // 0: not known
};

}  // namespace roseau::synthesis
