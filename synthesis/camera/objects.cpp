#include "synthesis/camera/objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "synthesis/camera/branch_shape.h"

namespace roseau::synthesis {

namespace {
constexpr double kBarnY = 42;
constexpr double kFenceY = 9;
constexpr double kUnderground = -0.1;  // where trunks and posts begin

// Random streams of the drawings.
enum : std::uint64_t { kFenceStream = 201, kBoughStream, kBackLeavesStream, kFrontLeavesStream, kBranchStream };

constexpr Colour kBark{0.30, 0.23, 0.17};
constexpr Colour kBarkLit{0.52, 0.43, 0.33};
constexpr Colour kBarkDark{0.17, 0.13, 0.10};
constexpr Colour kLeafShadow{0.10, 0.19, 0.07};
constexpr Colour kLeafMiddle{0.27, 0.44, 0.14};
constexpr Colour kLeafLit{0.62, 0.75, 0.28};

void rectangle(Canvas& canvas, double left, double bottom, double right, double top, const Colour& colour) {
  canvas.polygon(std::array<Vec2, 4>{Vec2{left, bottom}, {right, bottom}, {right, top}, {left, top}}, colour);
}

// A point that a stem goes through, and how thick the stem is there.
struct Knot {
  Vec2 at;
  double width = 0;
};

constexpr int kCurvePieces = 10;  // between two knots

// A smooth curve through the knots (Catmull-Rom), ends included.
std::vector<Knot> smooth_curve(std::span<const Knot> knots) {
  const auto at = [&knots](std::ptrdiff_t i) {
    return knots[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, std::ssize(knots) - 1))];
  };
  std::vector<Knot> curve;
  for (std::ptrdiff_t i = 0; i + 1 < std::ssize(knots); ++i) {
    for (int piece = 0; piece < kCurvePieces; ++piece) {
      const double s = piece / static_cast<double>(kCurvePieces);
      const double weights[] = {s * (-0.5 + s * (1 - 0.5 * s)), 1 + s * s * (-2.5 + 1.5 * s), s * (0.5 + s * (2 - 1.5 * s)),
                                s * s * (-0.5 + 0.5 * s)};
      Knot knot;
      for (std::ptrdiff_t k = 0; k < 4; ++k) {
        knot.at.x += weights[k] * at(i - 1 + k).at.x;
        knot.at.y += weights[k] * at(i - 1 + k).at.y;
        knot.width += weights[k] * at(i - 1 + k).width;
      }
      curve.push_back(knot);
    }
  }
  curve.push_back(knots.back());
  return curve;
}

// A piece of round wood along a smooth curve, from one knot to another: dark rim, body, a flank lit by the sun (left), grooves
// in the bark. The first end is cut straight, so that two pieces of the same curve join without a seam.
void stem(Canvas& canvas, Dice& dice, std::span<const Knot> knots, std::size_t first, std::size_t last) {
  const std::vector<Knot> whole = smooth_curve(knots);
  const std::span curve = std::span(whole).subspan(first * kCurvePieces, (last - first) * kCurvePieces + 1);
  // One coat after the other over the whole length, so that no joint shows. Offset and width are shares of the stem's width.
  const auto coat = [&](double offset, double share, const Colour& colour) {
    for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
      const Knot& from = curve[i];
      const Knot& to = curve[i + 1];
      canvas.stroke({from.at.x + offset * from.width, from.at.y}, {to.at.x + offset * to.width, to.at.y}, share * from.width,
                    share * to.width, colour);
    }
  };
  coat(0, 1, kBarkDark);
  coat(-0.03, 0.88, mix(kBarkDark, kBark, 0.6));
  coat(-0.08, 0.72, kBark);
  coat(-0.14, 0.52, mix(kBark, kBarkLit, 0.5));
  coat(-0.19, 0.30, kBarkLit);
  for (std::size_t i = 0; i + 2 < curve.size(); ++i) {
    const auto grooves = static_cast<int>(90 * curve[i].width);
    for (int groove = 0; groove < grooves; ++groove) {
      const double across = dice.between(-0.44, 0.44);
      const double begin = dice.between(0, 1);
      const double end = begin + dice.between(0.2, 0.9);
      const auto at = [&](double share) {
        return Vec2{curve[i].at.x + share * (curve[i + 1].at.x - curve[i].at.x) + across * curve[i].width,
                    curve[i].at.y + share * (curve[i + 1].at.y - curve[i].at.y)};
      };
      canvas.stroke(at(begin), at(end), 0.045 * curve[i].width, 0.015 * curve[i].width,
                    mix(kBarkDark, kBarkLit, dice.between(0, across < 0.1 ? 1.0 : 0.45)));
    }
  }
}

// A leaf with its lit and its shaded half and a midrib.
void leaf(Canvas& canvas, Vec2 base, double angle, double length, double width, const Colour& colour) {
  constexpr double kOutline[][2] = {{0, 0}, {0.18, 0.62}, {0.42, 1}, {0.70, 0.72}, {1, 0}};
  const Vec2 axis{std::cos(angle), std::sin(angle)};
  const auto at = [&](double along, double across) {
    return Vec2{base.x + length * along * axis.x - width / 2 * across * axis.y,
                base.y + length * along * axis.y + width / 2 * across * axis.x};
  };
  std::vector<Vec2> left;
  std::vector<Vec2> right;
  for (const auto& point : kOutline) {
    left.push_back(at(point[0], point[1]));
    right.push_back(at(point[0], -point[1]));
  }
  const bool left_is_up = axis.x > 0;
  canvas.polygon(left, scaled(colour, left_is_up ? 1.1 : 0.82));
  canvas.polygon(right, scaled(colour, left_is_up ? 0.82 : 1.1));
  canvas.stroke(at(0, 0), at(0.92, 0), 0.09 * width, 0.04 * width, mix(colour, {0.80, 0.86, 0.50}, 0.45));
}

struct Clump {
  Vec2 centre;
  double radius;
};

// Leaves of several clumps in three coats: the inner ones dark, the outer ones lit where they face the sun (up and left).
void foliage(Canvas& canvas, Dice& dice, std::span<const Clump> clumps, double leaves_per_m2, double leaf_length,
             double light) {
  for (int coat = 0; coat < 3; ++coat) {
    for (const Clump& clump : clumps) {
      const double area = std::numbers::pi * clump.radius * clump.radius;
      const auto count = static_cast<int>(leaves_per_m2 * area);
      for (int i = 0; i < count; ++i) {
        const double reach = clump.radius * std::sqrt(dice.between(0, 1)) * (1.06 - 0.07 * coat);
        const double where = dice.between(0, 2 * std::numbers::pi);
        const Vec2 offset{reach * std::cos(where), reach * std::sin(where)};
        const double facing = (-0.55 * offset.x + 0.83 * offset.y) / clump.radius;
        const double lit = std::clamp(0.18 + 0.22 * coat + 0.38 * facing + 0.13 * dice.normal(), 0.0, 1.0) * light;
        Colour colour =
            lit < 0.45 ? mix(kLeafShadow, kLeafMiddle, lit / 0.45) : mix(kLeafMiddle, kLeafLit, (lit - 0.45) / 0.55);
        colour.red *= dice.between(0.85, 1.2);  // no two leaves of one green
        const double angle = where + dice.between(-1.3, 1.3) - 0.4 * std::cos(where);
        const double length = leaf_length * dice.between(0.7, 1.2);
        leaf(canvas, {clump.centre.x + offset.x, clump.centre.y + offset.y}, angle, length, length * dice.between(0.36, 0.5),
             colour);
      }
    }
  }
}

void whole_stem(Canvas& canvas, Dice& dice, std::span<const Knot> knots) { stem(canvas, dice, knots, 0, knots.size() - 1); }

// The trunk and, in one curve with it, the branch that moves: kTrunkKnots up to its root, the rest beyond.
constexpr std::size_t kTrunkKnots = 6;

std::vector<Knot> trunk_and_branch(const Vec3& root, double length_m) {
  const auto above = [&](double x_m, double share, double width) {
    return Knot{{root.x + x_m, root.z + share * length_m}, width};
  };
  return {{{root.x - 0.50, kUnderground}, 0.42},
          {{root.x - 0.46, root.z - 1.20}, 0.36},
          {{root.x - 0.40, root.z - 0.83}, 0.32},
          {{root.x - 0.32, root.z - 0.50}, 0.27},
          {{root.x - 0.18, root.z - 0.22}, 0.19},
          above(0, 0, 0.135),
          above(0.08, 0.15, 0.112),
          above(0.16, 0.30, 0.095),
          above(0.25, 0.45, 0.078),
          above(0.33, 0.60, 0.060),
          above(0.39, 0.75, 0.042),
          above(0.42, 0.93, 0.022)};
}

}  // namespace

Layer draw_barn(double px_per_m, double blur_px) {
  Canvas canvas({3.5, 13.5, -0.1, 5.2}, kBarnY, px_per_m);
  rectangle(canvas, 4.2, 0, 11.6, 2.6, {0.66, 0.62, 0.55});
  rectangle(canvas, 11.6, 0, 13.0, 2.6, {0.50, 0.47, 0.43});
  canvas.polygon(std::array<Vec2, 4>{Vec2{3.9, 2.5}, {12.2, 2.5}, {11.7, 4.6}, {4.6, 4.6}}, {0.62, 0.31, 0.23});
  canvas.polygon(std::array<Vec2, 3>{Vec2{11.7, 4.6}, {12.2, 2.5}, {13.2, 2.5}}, {0.45, 0.24, 0.19});
  for (int row = 0; row < 5; ++row) {
    canvas.stroke({4.0 + 0.12 * row, 2.8 + 0.38 * row}, {12.1 - 0.1 * row, 2.8 + 0.38 * row}, 0.05, 0.05, {0.50, 0.25, 0.19});
  }
  rectangle(canvas, 6.9, 0, 8.5, 2.0, {0.30, 0.22, 0.16});
  rectangle(canvas, 7.65, 0, 7.75, 2.0, {0.44, 0.34, 0.26});
  for (const double x : {5.1, 9.7}) {
    rectangle(canvas, x, 1.1, x + 0.8, 1.9, {0.92, 0.92, 0.90});
    rectangle(canvas, x + 0.08, 1.18, x + 0.37, 1.82, {0.20, 0.24, 0.28});
    rectangle(canvas, x + 0.43, 1.18, x + 0.72, 1.82, {0.20, 0.24, 0.28});
  }
  return canvas.finish(blur_px);
}

Layer draw_fence(double px_per_m, double blur_px, std::uint64_t seed) {
  constexpr Colour kWood{0.58, 0.52, 0.45};
  Canvas canvas({-10, 10, -0.3, 1.4}, kFenceY, px_per_m);
  Dice dice(seed, kFenceStream);
  for (const double height : {0.45, 0.88}) {
    for (double x = -9.8; x < 9; x += 1.9) {
      const double sag = dice.between(-0.025, 0.025);
      canvas.stroke({x, height + sag}, {x + 1.95, height + dice.between(-0.025, 0.025)}, 0.095, 0.095, scaled(kWood, 0.66));
      canvas.stroke({x, height + sag + 0.02}, {x + 1.95, height + 0.02}, 0.05, 0.05, kWood);
    }
  }
  for (double x = -9.8; x < 10; x += 1.9) {
    const double top = 1.12 + dice.between(-0.05, 0.05);
    const double lean = dice.between(-0.03, 0.03);
    canvas.stroke({x, -0.2}, {x + lean, top}, 0.16, 0.14, scaled(kWood, 0.6));
    canvas.stroke({x - 0.03, -0.2}, {x - 0.03 + lean, top}, 0.07, 0.06, scaled(kWood, 1.1));
  }
  for (int tuft = 0; tuft < 420; ++tuft) {
    const double x = dice.between(-9.9, 9.9);
    const double height = dice.between(0.1, 0.34);
    canvas.stroke({x, -0.25}, {x + dice.between(-0.08, 0.12), height - 0.15}, 0.03, 0.008,
                  mix({0.30, 0.40, 0.15}, {0.62, 0.62, 0.30}, dice.between(0, 1)));
  }
  return canvas.finish(blur_px);
}

Layer draw_sonic(const Vec3& position_in_world, double px_per_m, double blur_px) {
  constexpr Colour kSteel{0.72, 0.74, 0.76};
  constexpr Colour kSteelDark{0.40, 0.42, 0.45};
  constexpr Colour kSteelLit{0.95, 0.96, 0.97};
  const double x = position_in_world.x;
  const double z = position_in_world.z;
  Canvas canvas({x - 0.4, x + 0.4, -0.1, z + 0.35}, position_in_world.y, px_per_m);
  const auto tube = [&](Vec2 from, Vec2 to, double width) {
    canvas.stroke(from, to, width, width, kSteelDark);
    canvas.stroke({from.x - 0.1 * width, from.y}, {to.x - 0.1 * width, to.y}, 0.7 * width, 0.7 * width, kSteel);
    canvas.stroke({from.x - 0.25 * width, from.y}, {to.x - 0.25 * width, to.y}, 0.25 * width, 0.25 * width, kSteelLit);
  };
  tube({x, -0.1}, {x, z - 0.55}, 0.045);
  tube({x, z - 0.58}, {x, z - 0.24}, 0.085);
  tube({x, z - 0.26}, {x, z - 0.20}, 0.12);
  // Three pairs of transducers on bowed struts around the measured volume.
  for (const double side : {-1.0, 0.15, 1.0}) {
    const double reach = 0.155 * side;
    tube({x + 0.3 * reach, z - 0.22}, {x + reach, z - 0.13}, 0.016);
    tube({x + reach, z - 0.13}, {x + reach, z + 0.15}, 0.016);
    tube({x + reach, z + 0.15}, {x + 0.35 * reach, z + 0.24}, 0.016);
    canvas.stroke({x + 0.42 * reach, z - 0.115}, {x + 0.34 * reach, z - 0.075}, 0.034, 0.030, kSteelDark);
    canvas.stroke({x + 0.42 * reach, z + 0.125}, {x + 0.34 * reach, z + 0.085}, 0.034, 0.030, kSteelDark);
  }
  tube({x - 0.06, z + 0.245}, {x + 0.06, z + 0.245}, 0.030);
  return canvas.finish(blur_px);
}

std::vector<Layer> draw_tree(const Vec3& root, double branch_length_m, double px_per_m, double blur_px, std::uint64_t seed) {
  const PlaneWindow window{root.x - 2.55, root.x + 0.85, kUnderground, root.z + 2.85};
  const auto at = [&root](double x_m, double z_m) { return Vec2{root.x + x_m, root.z + z_m}; };
  std::vector<Layer> layers;

  Canvas back(window, root.y + 0.45, px_per_m);
  Dice back_dice(seed, kBackLeavesStream);
  const Clump back_clumps[] = {
      {at(-1.27, 1.10), 0.62}, {at(-0.87, 1.75), 0.58}, {at(-1.67, 1.60), 0.50}, {at(-1.87, 0.85), 0.42}};
  foliage(back, back_dice, back_clumps, 230, 0.085, 0.62);
  layers.push_back(back.finish(1.6 * blur_px));  // behind the focus

  Canvas middle(window, root.y + 0.02, px_per_m);
  Dice dice(seed, kBoughStream);
  const auto bough = [&](std::initializer_list<Knot> knots) { whole_stem(middle, dice, std::vector(knots)); };
  // Thin wood first: each piece grows out from under the thicker one.
  bough({{at(-0.80, 0.57), 0.07}, {at(-1.22, 1.15), 0.05}, {at(-1.54, 1.60), 0.02}});
  bough({{at(-0.50, 0.17), 0.11}, {at(-0.97, 0.41), 0.08}, {at(-1.40, 0.67), 0.05}, {at(-1.82, 0.85), 0.03}});
  bough({{at(-0.30, -0.43), 0.20},
         {at(-0.47, 0.10), 0.16},
         {at(-0.78, 0.53), 0.12},
         {at(-0.97, 0.95), 0.08},
         {at(-1.04, 1.5), 0.05}});
  bough({{at(-0.42, -0.75), 0.07}, {at(-0.72, -0.53), 0.04}, {at(-0.90, -0.27), 0.02}});
  stem(middle, dice, trunk_and_branch(root, branch_length_m), 0, kTrunkKnots - 1);
  layers.push_back(middle.finish(blur_px));

  Canvas front(window, root.y - 0.3, px_per_m);
  Dice front_dice(seed, kFrontLeavesStream);
  const Clump front_clumps[] = {{at(-1.04, 1.60), 0.40}, {at(-1.54, 1.50), 0.38}, {at(-0.77, 1.17), 0.34},
                                {at(-1.34, 0.97), 0.40}, {at(-1.90, 0.85), 0.34}, {at(-0.92, -0.23), 0.17},
                                {at(-1.04, 1.97), 0.28}, {at(-0.64, 1.65), 0.26}};
  foliage(front, front_dice, front_clumps, 230, 0.085, 1.0);
  layers.push_back(front.finish(blur_px));
  return layers;
}

PlaneWindow branch_target_window(const Vec3& root, double length_m) {
  return {root.x + 0.05, root.x + 0.75, root.z + (kStiffBegin + 0.03) * length_m, root.z + 0.97 * length_m};
}

Layer draw_branch(const Vec3& root, double length_m, double px_per_m, double blur_px, std::uint64_t seed) {
  Canvas canvas({root.x - 0.55, root.x + 1.05, root.z - 0.12, root.z + length_m + 0.25}, root.y, px_per_m);
  Dice dice(seed, kBranchStream);
  const auto at = [&](double x_m, double share) { return Vec2{root.x + x_m, root.z + share * length_m}; };
  const auto twig = [&](std::initializer_list<Knot> knots) { whole_stem(canvas, dice, std::vector(knots)); };
  twig({{at(0.18, 0.36), 0.045}, {at(0.03, 0.50), 0.028}, {at(-0.01, 0.62), 0.014}});
  twig({{at(0.28, 0.52), 0.045}, {at(0.50, 0.62), 0.028}, {at(0.62, 0.72), 0.014}});
  twig({{at(0.36, 0.68), 0.035}, {at(0.22, 0.78), 0.022}, {at(0.14, 0.86), 0.012}});
  const std::vector<Knot> leader = trunk_and_branch(root, length_m);
  stem(canvas, dice, leader, kTrunkKnots - 1, leader.size() - 1);
  const Clump clumps[] = {{at(0.40, 0.98), 0.15}, {at(0.24, 0.88), 0.19}, {at(0.50, 0.87), 0.20},  {at(0.10, 0.79), 0.16},
                          {at(0.66, 0.77), 0.16}, {at(0.37, 0.76), 0.23}, {at(-0.01, 0.66), 0.11}, {at(0.60, 0.68), 0.13}};
  foliage(canvas, dice, clumps, 210, 0.09, 1.0);
  const Clump low[] = {{at(0.30, 0.40), 0.09}, {at(0.02, 0.24), 0.08}};
  foliage(canvas, dice, low, 200, 0.08, 0.9);
  return canvas.finish(blur_px);
}

}  // namespace roseau::synthesis
