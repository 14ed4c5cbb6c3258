#include "core/image_coding/huffman.h"

#include <algorithm>
#include <array>

#include "core/check.h"

namespace roseau::image {

namespace {

constexpr std::size_t kMostSymbols = 288;
constexpr std::uint16_t kPackage = 0xFFFF;

/// A symbol, or two items of the list below packed together.
struct Item {
  std::uint64_t weight;
  std::uint16_t symbol;
};

/// Of the items in one list that are taken, how many are symbols and how many are packages.
std::size_t count_packages(std::span<const Item> taken) {
  return static_cast<std::size_t>(std::ranges::count(taken, kPackage, &Item::symbol));
}

}  // namespace

void optimal_lengths(std::span<const std::uint32_t> weights, std::uint8_t longest_bits, std::span<std::uint8_t> lengths) {
  ROSEAU_CHECK(weights.size() <= kMostSymbols && lengths.size() == weights.size() && longest_bits <= 15);
  std::vector<Item> symbols;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] > 0) symbols.push_back({weights[i], static_cast<std::uint16_t>(i)});
  }
  ROSEAU_CHECK(symbols.size() >= 2 && symbols.size() <= (std::size_t{1} << longest_bits));
  std::ranges::stable_sort(symbols, {}, &Item::weight);

  // One list per bit of length: the symbols, and the pairs of the list before.
  std::array<std::vector<Item>, 15> lists;
  lists[0] = symbols;
  for (std::size_t level = 1; level < longest_bits; ++level) {
    const auto& below = lists.at(level - 1);
    std::vector<Item> packages;
    for (std::size_t i = 0; i + 1 < below.size(); i += 2) packages.push_back({below[i].weight + below[i + 1].weight, kPackage});
    std::ranges::merge(symbols, packages, std::back_inserter(lists.at(level)), {}, &Item::weight, &Item::weight);
  }

  // The lightest 2 (n - 1) items of the last list; each list says how much of the one below it is inside its packages. A
  // symbol's word is as long as the number of lists in which it was taken.
  std::ranges::fill(lengths, std::uint8_t{0});
  std::size_t take = 2 * (symbols.size() - 1);
  for (std::size_t level = longest_bits; level-- > 0 && take > 0;) {
    const auto taken = std::span(lists.at(level)).first(take);
    for (const Item& item : taken) {
      if (item.symbol != kPackage) ++lengths[item.symbol];
    }
    take = 2 * count_packages(taken);
  }
}

void canonical_words(std::span<const std::uint8_t> lengths, std::span<std::uint16_t> words) {
  std::array<std::uint32_t, 16> next{};
  for (const std::uint8_t length : lengths) ++next.at(length);
  next[0] = 0;
  std::uint32_t word = 0;
  for (std::uint32_t& entry : next) {
    const std::uint32_t count = entry;
    entry = word;
    word = (word + count) << 1U;
  }
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (lengths[i] == 0) continue;
    std::uint32_t ordered = next.at(lengths[i])++;
    std::uint32_t reversed = 0;
    for (std::uint8_t bit = 0; bit < lengths[i]; ++bit, ordered >>= 1U) reversed = (reversed << 1U) | (ordered & 1U);
    words[i] = static_cast<std::uint16_t>(reversed);
  }
}

}  // namespace roseau::image
