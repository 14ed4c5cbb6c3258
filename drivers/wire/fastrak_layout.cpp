#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "drivers/wire/fastrak.h"
#include "drivers/wire/fastrak_items.h"
#include "drivers/wire/fields.h"

namespace roseau::wire {

namespace {

constexpr std::size_t kMostItems = 32;
constexpr std::size_t kMostBytes = 254;

constexpr std::array kItems = {
    FastrakItem{.code = 0, .what = FastrakItem::What::space, .text_bytes = 1, .binary_bytes = 1},
    FastrakItem{.code = 1, .what = FastrakItem::What::line_end, .text_bytes = 2, .binary_bytes = 2},
    FastrakItem{.code = 2, .what = FastrakItem::What::position, .numbers = 3, .decimals = 2},
    FastrakItem{.code = 3, .what = FastrakItem::What::movement, .numbers = 3, .decimals = 2},
    FastrakItem{.code = 4, .what = FastrakItem::What::angles, .numbers = 3, .decimals = 2},
    FastrakItem{.code = 5, .what = FastrakItem::What::cosines_x, .numbers = 3, .decimals = 4},
    FastrakItem{.code = 6, .what = FastrakItem::What::cosines_y, .numbers = 3, .decimals = 4},
    FastrakItem{.code = 7, .what = FastrakItem::What::cosines_z, .numbers = 3, .decimals = 4},
    FastrakItem{.code = 11, .what = FastrakItem::What::quaternion, .numbers = 4, .decimals = 4},
    FastrakItem{.code = 16, .what = FastrakItem::What::stylus, .text_bytes = 1, .binary_bytes = 1},
};
constexpr int kExtended = 50;  // item 52 is item 2 with more digits

Error layout_error(std::string_view items, const std::string& what) {
  return {ErrorCode::invalid_argument, fmt::format("FASTRAK items '{}': {}", items, what)};
}

FastrakLayout parse_known(std::string_view items) {
  auto layout = FastrakLayout::parse(items);
  ROSEAU_CHECK(layout);
  return *layout;
}

}  // namespace

std::optional<FastrakItem> fastrak_item(int code) {
  const bool is_extended = code >= kExtended;
  const auto* found = std::ranges::find(kItems, is_extended ? code - kExtended : code, &FastrakItem::code);
  if (found == kItems.end()) return std::nullopt;
  FastrakItem item = *found;
  if (item.numbers > 0) {
    item.is_extended = is_extended;
    item.text_bytes = item.numbers * (is_extended ? kExtendedDigits : kPlainDigits);
    item.binary_bytes = item.numbers * sizeof(float);
  }
  return item;
}

Result<FastrakLayout> FastrakLayout::parse(std::string_view items) {
  FastrakLayout layout;
  layout.text_ = items;
  layout.text_bytes_ = layout.binary_bytes_ = kFastrakHeaderBytes;
  bool has_position = false;
  for (const auto field : split_fields(items)) {
    int code = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), code);
    const bool is_number = error == std::errc{} && end == field.data() + field.size();
    const auto item = is_number ? fastrak_item(code) : std::nullopt;
    if (!item) return layout_error(items, fmt::format("'{}' is not one of 0-7, 11, 16, 50-57, 61, 66", field));
    layout.items_.push_back(code);
    layout.text_bytes_ += item->text_bytes;
    layout.binary_bytes_ += item->binary_bytes;
    has_position = has_position || item->what == FastrakItem::What::position;
  }
  if (!has_position) return layout_error(items, "has no position (2)");
  if (layout.items_.size() > kMostItems || layout.text_bytes_ > kMostBytes) {
    return layout_error(items, fmt::format("is longer than {} items or {} bytes", kMostItems, kMostBytes));
  }
  return layout;
}

FastrakLayout default_fastrak_layout() { return parse_known("2,4,1"); }

FastrakLayout quaternion_fastrak_layout() { return parse_known("2,11,0"); }

}  // namespace roseau::wire
