#include "core/image_coding/huffman.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace roseau::image {
namespace {

using ::testing::ElementsAre;

std::vector<std::uint8_t> lengths_of(const std::vector<std::uint32_t>& weights, std::uint8_t longest_bits) {
  std::vector<std::uint8_t> lengths(weights.size());
  optimal_lengths(weights, longest_bits, lengths);
  return lengths;
}

std::uint64_t cost(const std::vector<std::uint32_t>& weights, const std::vector<std::uint8_t>& lengths) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) bits += std::uint64_t{weights[i]} * lengths[i];
  return bits;
}

/// Sum of 2^-length, in units of 2^-16: 65536 for a complete code.
std::uint32_t kraft(const std::vector<std::uint8_t>& lengths) {
  std::uint32_t sum = 0;
  for (const std::uint8_t length : lengths) sum += length == 0 ? 0 : 65536U >> length;
  return sum;
}

TEST(OptimalLengths, AreHuffmansWhereThereIsRoom) {
  EXPECT_THAT(lengths_of({1, 1, 2, 4, 8}, 15), ElementsAre(4, 4, 3, 2, 1));
  EXPECT_THAT(lengths_of({0, 5, 0, 5}, 15), ElementsAre(0, 1, 0, 1));
}

TEST(OptimalLengths, HoldTheLimitAndStayOptimal) {
  // Huffman's own would be 7 bits long.
  const std::vector<std::uint32_t> fibonacci{1, 1, 2, 3, 5, 8, 13, 21};
  const auto lengths = lengths_of(fibonacci, 4);
  EXPECT_LE(*std::ranges::max_element(lengths), 4);
  EXPECT_EQ(kraft(lengths), 65536U);
  // All complete codes of 8 words of up to 4 bits, heaviest first.
  std::uint64_t best = ~std::uint64_t{0};
  std::vector<std::uint8_t> tried(8);
  const std::function<void(std::size_t)> visit = [&](std::size_t i) {
    if (i == tried.size()) {
      if (kraft(tried) <= 65536) best = std::min(best, cost(fibonacci, tried));
      return;
    }
    for (std::uint8_t length = 1; length <= 4; ++length) {
      tried[i] = length;
      visit(i + 1);
    }
  };
  visit(0);
  EXPECT_EQ(cost(fibonacci, lengths), best);
}

TEST(OptimalLengths, MakeCompleteCodesOfAnyWeights) {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    std::vector<std::uint32_t> weights(2 + random() % 256);
    for (auto& weight : weights) weight = static_cast<std::uint32_t>(1 + (random() >> (2 + random() % 28)));
    EXPECT_EQ(kraft(lengths_of(weights, 14)), 65536U) << round;
  }
}

TEST(CanonicalWords, AreThoseOfTheStandard) {
  // The example of RFC 1951, 3.2.2: lengths 3 3 3 3 3 2 4 4 give 010 011 100 101 110 00 1110 1111; ours begin with the last
  // bit.
  const std::vector<std::uint8_t> lengths{3, 3, 3, 3, 3, 2, 4, 4};
  std::vector<std::uint16_t> words(8);
  canonical_words(lengths, words);
  EXPECT_THAT(words, ElementsAre(0b010, 0b110, 0b001, 0b101, 0b011, 0b00, 0b0111, 0b1111));
}

}  // namespace
}  // namespace roseau::image
