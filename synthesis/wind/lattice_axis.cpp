#include "synthesis/wind/lattice_axis.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace roseau::synthesis {

namespace {
constexpr double kSameLineM = 1e-3;
constexpr double kSameWidth = 1e-6;

// The exact positions and the range's ends, ascending, without any two closer than a line is wide; exact ones win.
std::vector<double> knots_of(std::span<const double> exact_m, const std::optional<LatticeRange>& range) {
  std::vector<double> sorted(exact_m.begin(), exact_m.end());
  std::ranges::sort(sorted);
  std::vector<double> knots;
  for (const double knot : sorted) {
    if (knots.empty() || knot - knots.back() >= kSameLineM) knots.push_back(knot);
  }
  if (!range) return knots;
  for (const double end : {range->low_m, range->high_m}) {
    const auto is_near = [end](double knot) { return std::abs(knot - end) < kSameLineM; };
    if (std::ranges::none_of(knots, is_near)) knots.insert(std::ranges::upper_bound(knots, end), end);
  }
  return knots;
}
}  // namespace

LatticeAxis::LatticeAxis(std::span<const double> exact_m, const std::optional<LatticeRange>& range, double spacing_m) {
  ROSEAU_CHECK((range || !exact_m.empty()) && spacing_m > 0);
  const std::vector<double> knots = knots_of(exact_m, range);
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const double middle_m = (knots[i] + knots[i + 1]) / 2;
    const bool is_in_range = range && middle_m > range->low_m && middle_m < range->high_m;
    const double gap_m = knots[i + 1] - knots[i];
    const double parts = is_in_range ? std::max(1.0, std::ceil(gap_m / spacing_m - kSameWidth)) : 1;
    for (double part = 0; part < parts; ++part) lines_m_.push_back(knots[i] + gap_m * part / parts);
  }
  lines_m_.push_back(knots.back());
  index();
}

void LatticeAxis::index() {
  for (std::size_t i = 0; i + 1 < lines_m_.size(); ++i) {
    const double width_m = lines_m_[i + 1] - lines_m_[i];
    const auto is_same = [width_m](double known_m) { return std::abs(known_m - width_m) < kSameWidth; };
    const auto known = std::ranges::find_if(widths_m_, is_same);
    width_of_line_.push_back(static_cast<std::uint32_t>(known - widths_m_.begin()));
    if (known == widths_m_.end()) widths_m_.push_back(width_m);
    per_width_.push_back(1 / width_m);
  }
  if (lines_m_.size() < 2) return;
  const double length_m = lines_m_.back() - lines_m_.front();
  const auto buckets = static_cast<std::size_t>(std::ceil(1.1 * length_m / *std::ranges::min_element(widths_m_)));
  buckets_per_m_ = static_cast<double>(buckets) / length_m;
  std::uint32_t line = 0;
  for (std::size_t bucket = 0; bucket <= buckets; ++bucket) {
    // A hair to the left, so that rounding never finds a line to the right of the position.
    const double begin_m = lines_m_.front() + static_cast<double>(bucket) / buckets_per_m_ - kSameWidth;
    while (line + 2 < lines_m_.size() && begin_m >= lines_m_[line + 1]) ++line;
    first_of_bucket_.push_back(line);
  }
}

}  // namespace roseau::synthesis
