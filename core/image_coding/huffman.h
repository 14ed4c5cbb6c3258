// Prefix codes of limited length, as deflate (RFC 1951) wants them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace roseau::image {

/// The lengths of an optimal prefix code none of whose words is longer than `longest_bits` (package-merge). `lengths` has an
/// entry for each weight; symbols of weight 0 get no word: length 0. At least two weights must not be 0, and no more than
/// 2^longest_bits of them.
void optimal_lengths(std::span<const std::uint32_t> weights, std::uint8_t longest_bits, std::span<std::uint8_t> lengths);

/// The code words that deflate gives to these lengths, their bits reversed: first bit of the word lowest.
void canonical_words(std::span<const std::uint8_t> lengths, std::span<std::uint16_t> words);

}  // namespace roseau::image
