// SPDX-License-Identifier: BSD-2-Clause
// Natural numbers of any size, as plain as possible: the oracle that the attribute core's own
// arithmetic is held against.
#pragma once
#include <algorithm>
#include <cstdint>
#include <ranges>
#include <vector>

namespace mlcca::testing {

class Natural {
 public:
  Natural(std::uint64_t v = 0) {  // NOLINT(google-explicit-constructor): reads as a number
    for (; v != 0; v >>= 16) digit_.push_back(static_cast<std::uint16_t>(v));
  }

  friend Natural operator+(const Natural& a, const Natural& b) {
    Natural sum;
    std::uint32_t carry = 0;
    for (std::size_t i = 0; i < std::max(a.digit_.size(), b.digit_.size()) || carry != 0; ++i) {
      carry += a.digit(i) + b.digit(i);
      sum.digit_.push_back(static_cast<std::uint16_t>(carry));
      carry >>= 16;
    }
    return sum;
  }
  friend Natural operator*(const Natural& a, const Natural& b) {
    Natural product;
    product.digit_.resize(a.digit_.size() + b.digit_.size() + 1);
    for (std::size_t i = 0; i < a.digit_.size(); ++i) {
      std::uint32_t carry = 0;
      for (std::size_t j = 0; j < b.digit_.size() || carry != 0; ++j) {
        carry += a.digit(i) * b.digit(j) + product.digit_[i + j];
        product.digit_[i + j] = static_cast<std::uint16_t>(carry);
        carry >>= 16;
      }
    }
    while (!product.digit_.empty() && product.digit_.back() == 0) product.digit_.pop_back();
    return product;
  }
  friend bool operator<(const Natural& a, const Natural& b) {
    if (a.digit_.size() != b.digit_.size()) return a.digit_.size() < b.digit_.size();
    return std::ranges::lexicographical_compare(a.digit_ | std::views::reverse,
                                                b.digit_ | std::views::reverse);
  }
  friend bool operator<=(const Natural& a, const Natural& b) { return !(b < a); }

 private:
  [[nodiscard]] std::uint32_t digit(std::size_t i) const {
    return i < digit_.size() ? digit_[i] : 0;
  }
  std::vector<std::uint16_t> digit_;  // lowest first, no leading zeros
};

inline Natural power(const Natural& base, unsigned n) {
  Natural result = 1;
  for (; n != 0; --n) result = result * base;
  return result;
}

/// floor(n / d) where it fits into 64 bits, else the largest 64-bit number.
inline std::uint64_t quotient(const Natural& n, const Natural& d) {
  std::uint64_t q = 0;
  for (int bit = 63; bit >= 0; --bit) {
    const std::uint64_t candidate = q | (std::uint64_t{1} << bit);
    if (d * candidate <= n) q = candidate;
  }
  return q;
}

}  // namespace mlcca::testing
