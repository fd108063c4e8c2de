// SPDX-License-Identifier: BSD-2-Clause
// Saturation, rounding and 128-bit intermediates against natural numbers of any size.
#include "mlcca/arithmetic.hpp"

#include <gtest/gtest.h>

#include "natural.hpp"
#include "random_world.hpp"

namespace mlcca {
namespace {

using testing::Natural;
using testing::quotient;
using testing::RandomWorld;

constexpr int kRounds = 20000;

TEST(ArithmeticTest, SumsAndProductsSaturateInsteadOfWrapping) {
  RandomWorld world(1);
  for (int i = 0; i < kRounds; ++i) {
    const Value a = world.value();
    const Value b = world.value();
    ASSERT_EQ(add_saturating(a, b), quotient(Natural(a) + b, 1)) << a << " + " << b;
    ASSERT_EQ(mul_saturating(a, b), quotient(Natural(a) * b, 1)) << a << " * " << b;
    ASSERT_EQ(sub_floor(a, b), a < b ? 0 : a - b);
  }
}

TEST(ArithmeticTest, ProductHasAllItsBits) {
  RandomWorld world(2);
  for (int i = 0; i < kRounds; ++i) {
    const Value a = world.value();
    const Value b = world.value();
    const detail::Product p = detail::multiply(a, b);
    const Natural product = Natural(p.high) * (Natural(kUnbounded) + 1) + p.low;
    ASSERT_TRUE(product <= Natural(a) * b && Natural(a) * b <= product) << a << " * " << b;
  }
}

TEST(ArithmeticTest, MulDivRoundsTheExactQuotientOnce) {
  RandomWorld world(3);
  for (int i = 0; i < kRounds; ++i) {
    const Value a = world.value();
    const Value b = world.value();
    const Value c = std::max<Value>(world.value(), 1);
    const Value down = quotient(Natural(a) * b, c);
    const bool exact = Natural(a) * b <= Natural(down) * c;
    ASSERT_EQ(mul_div_down(a, b, c), down) << a << " * " << b << " / " << c;
    ASSERT_EQ(mul_div_up(a, b, c), exact ? down : add_saturating(down, 1))
        << a << " * " << b << " / " << c;
    ASSERT_EQ(div_up(a, c), quotient(Natural(a) + (c - 1), c)) << a << " / " << c;
  }
}

TEST(ArithmeticTest, MulDivSaturatesExactlyWhereTheQuotientDoesNotFit) {
  constexpr Value half = Value{1} << 63;
  EXPECT_EQ(mul_div_down(half, kUnbounded, half), kUnbounded);
  EXPECT_EQ(mul_div_down(half, kUnbounded - 1, half), kUnbounded - 1);
  EXPECT_EQ(mul_div_down(half, 2, 1), kUnbounded);
  EXPECT_EQ(mul_div_down(half - 1, 2, 1), kUnbounded - 1);
  EXPECT_EQ(mul_div_up(kUnbounded, kUnbounded, kUnbounded - 1), kUnbounded);
}

TEST(ArithmeticTest, DivisionByZeroHasNoBound) {
  EXPECT_EQ(div_up(0, 0), kUnbounded);
  EXPECT_EQ(mul_div_up(0, 1, 0), kUnbounded);
  EXPECT_EQ(mul_div_down(0, 1, 0), kUnbounded);
}

TEST(ArithmeticTest, LargestProbabilityAndDivisorPatternsDivideExactly) {
  // Digits of all ones and divisors just above half provoke both corrections of a long division.
  constexpr Value patterns[] = {0xffffffffffffffff, 0xfffffffeffffffff, 0x8000000000000001,
                                0x80000000ffffffff, 0x8000000000000000, 0xffffffff00000001,
                                0x7fffffffffffffff, 0x00000001ffffffff, 0x0000000100000000};
  for (const Value a : patterns)
    for (const Value b : patterns)
      for (const Value c : patterns)
        ASSERT_EQ(mul_div_down(a, b, c), quotient(Natural(a) * b, c)) << a << ' ' << b << ' ' << c;
}

}  // namespace
}  // namespace mlcca
