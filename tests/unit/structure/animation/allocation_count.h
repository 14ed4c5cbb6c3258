#pragma once

#include <cstddef>

namespace roseau::structure {

/// How often this program has called new so far.
std::size_t allocation_count();

}  // namespace roseau::structure
