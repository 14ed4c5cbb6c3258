// LatticeAxis: lines at ascending positions along one direction, and between which two of them a position lies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace roseau::synthesis {

struct LatticeRange {
  double low_m = 0;
  double high_m = 0;
};

class LatticeAxis {
 public:
  /// A line through each exact position, and over the range lines no further apart than `spacing_m`. Positions closer than a
  /// millimetre share a line. At least one of the two must be given.
  LatticeAxis(std::span<const double> exact_m, const std::optional<LatticeRange>& range, double spacing_m);

  const std::vector<double>& lines_m() const { return lines_m_; }
  std::size_t size() const { return lines_m_.size(); }

  /// The different distances between neighbouring lines; and which of them stands between line i and the next.
  const std::vector<double>& widths_m() const { return widths_m_; }
  std::size_t width_index(std::size_t line) const { return width_of_line_[line]; }

  /// `share` of the way from line `line` to the next; 0 on the last line and outside the lines on the nearest one.
  struct Place {
    std::uint32_t line = 0;
    float share = 0;
  };
  Place locate(double position_m) const {
    if (!(position_m > lines_m_.front())) return {};
    if (position_m >= lines_m_.back()) return {static_cast<std::uint32_t>(lines_m_.size() - 1), 0};
    std::uint32_t line =
        first_of_bucket_[static_cast<std::size_t>(static_cast<std::int64_t>((position_m - lines_m_.front()) * buckets_per_m_))];
    line += position_m >= lines_m_[line + 1] ? 1 : 0;
    return {line, static_cast<float>((position_m - lines_m_[line]) * per_width_[line])};
  }

 private:
  void index();

  std::vector<double> lines_m_;
  std::vector<double> widths_m_;
  std::vector<std::uint32_t> width_of_line_;
  std::vector<double> per_width_;  // 1 / distance to the next line
  // Equal buckets over the lines, none as wide as the least distance between two: a position is found without a search.
  std::vector<std::uint32_t> first_of_bucket_;
  double buckets_per_m_ = 0;
};

}  // namespace roseau::synthesis
