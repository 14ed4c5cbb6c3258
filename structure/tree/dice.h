// Random numbers drawn one after another from one stream.
#pragma once

#include <cstdint>

#include "core/geometry.h"
#include "core/random.h"

namespace roseau::structure {

class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t stream) : random_(seed, stream) {}
  double uniform(double low, double high) { return random_.uniform(next_++, low, high); }
  /// Anywhere in the cube from -1 to 1.
  Vec3 cube() {
    const double x = uniform(-1, 1);
    const double y = uniform(-1, 1);
    return {x, y, uniform(-1, 1)};
  }

 private:
  RandomStream random_;
  std::uint64_t next_ = 0;
};

}  // namespace roseau::structure
