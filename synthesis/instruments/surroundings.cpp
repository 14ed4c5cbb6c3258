#include "synthesis/instruments/surroundings.h"

#include <array>

namespace roseau::synthesis {

namespace {
// Gauss and Legendre's points and weights on 0 .. 1: exact for polynomials of the ninth degree.
struct Point {
  double place;
  double weight;
};
constexpr std::array kPoints = {Point{0.04691007703066800, 0.11846344252809454},
                                Point{0.23076534494715845, 0.23931433524968324}, Point{0.5, 0.28444444444444444},
                                Point{0.76923465505284155, 0.23931433524968324},
                                Point{0.95308992296933200, 0.11846344252809454}};
}  // namespace

Vec3 Surroundings::path_mean_wind_mps(const Vec3& from, const Vec3& to, double time_s) const {
  Vec3 mean;
  for (const Point& point : kPoints) {
    const Vec3 place{from.x + point.place * (to.x - from.x), from.y + point.place * (to.y - from.y),
                     from.z + point.place * (to.z - from.z)};
    const Vec3 wind = wind_mps(place, time_s);
    mean = {mean.x + point.weight * wind.x, mean.y + point.weight * wind.y, mean.z + point.weight * wind.z};
  }
  return mean;
}

}  // namespace roseau::synthesis
