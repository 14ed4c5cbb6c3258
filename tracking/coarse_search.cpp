#include "tracking/coarse_search.h"

#include <cmath>
#include <vector>

namespace roseau::tracking {

namespace {

constexpr int kSide = Patch::kSide;
constexpr int kPixels = kSide * kSide;

/// The compared pixels of a patch with their mean (rounded) taken off.
struct Template {
  std::array<int, kPixels> values{};
  double sum = 0;  // what rounding the mean left
  double energy = 0;
};

Template template_of(const Patch& patch) {
  Template result;
  int sum = 0;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const int value = patch.pixels()[pixel_index(row + 1, column + 1, Patch::kCut)];
      result.values[pixel_index(row, column, kSide)] = value;
      sum += value;
    }
  }
  const int mean = (sum + kPixels / 2) / kPixels;
  for (int& value : result.values) {
    value -= mean;
    result.sum += value;
    result.energy += static_cast<double>(value) * value;
  }
  result.energy -= result.sum * result.sum / kPixels;
  return result;
}

double correlation(const cv::Mat& gray, const Template& wanted, int centre_x, int centre_y) {
  const int left = centre_x - Patch::kReach;
  const int top = centre_y - Patch::kReach;
  if (left < 0 || top < 0 || left + kSide > gray.cols || top + kSide > gray.rows) return 0;
  int sum = 0;
  int square = 0;
  int product = 0;
  for (int row = 0; row < kSide; ++row) {
    const std::uint8_t* from = gray.ptr<std::uint8_t>(top + row) + left;
    const int* value = wanted.values.data() + row * kSide;
    for (int column = 0; column < kSide; ++column) {
      sum += from[column];
      square += from[column] * from[column];
      product += from[column] * value[column];
    }
  }
  const double energy = square - static_cast<double>(sum) * sum / kPixels;
  if (!(energy > kPixels) || !(wanted.energy > 0)) return 0;
  return (product - sum * wanted.sum / kPixels) / std::sqrt(energy * wanted.energy);
}

}  // namespace

CoarseShift coarse_search(const cv::Mat& gray, std::span<const CoarseProbe> probes, int radius) {
  CoarseShift best;
  if (probes.empty()) return best;
  std::vector<Template> templates;
  for (const CoarseProbe& probe : probes) templates.push_back(template_of(*probe.patch));
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      double sum = 0;
      for (std::size_t i = 0; i < probes.size(); ++i) {
        sum += correlation(gray, templates[i], probes[i].expected.x() + dx, probes[i].expected.y() + dy);
      }
      const double mean = sum / static_cast<double>(probes.size());
      if (mean > best.correlation) best = {{dx, dy}, mean};
    }
  }
  return best;
}

}  // namespace roseau::tracking
