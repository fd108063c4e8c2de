// SPDX-License-Identifier: BSD-2-Clause
// Programs that a compiler must refuse: one for each CASE but 0, which must compile.
#include "mlcca/mlcca.hpp"

#ifndef CASE
#define CASE 0
#endif

namespace mlcca {
#if CASE == 0
static_assert(count(18446744073_s) == 18446744073000000000U, "the largest whole second");
static_assert(count(100_percent) == kCertainLoss, "the largest loss");
static_assert(1'000'000_ns == 1_ms, "digits may be separated");
static_assert(make_set<Period<50_ms>, Omission<2>>()[Attribute::omission] == 2, "");
#elif CASE == 1
constexpr auto kSeconds = 18446744074_s;
#elif CASE == 2
constexpr auto kCertain = 101_percent;
#elif CASE == 3
constexpr auto kFraction = 1.5_ms;
#elif CASE == 4
constexpr auto kOctal = 010_ms;
#elif CASE == 5
constexpr auto kHexadecimal = 0x10_ms;
#elif CASE == 6
constexpr auto kUnboundedLiteral = 18446744073709551615_ns;
#elif CASE == 7
constexpr AttributeSet kSet = make_set<Period<50_bytes>>();
#elif CASE == 8
constexpr AttributeSet kSet = make_set<Period<50>>();
#elif CASE == 9
constexpr AttributeSet kSet = make_set<Period<50_ms>, Omission<2>, Period<60_ms>>();
#elif CASE == 10
constexpr auto kSum = 50_ms + 50_bytes;
#elif CASE == 11
static_assert(check_layer(make_set<Omission<2>>(), make_set<Omission<5>>()).outcome ==
                  Outcome::fit,
              "the emergency switch behind the bridge");
#endif
}  // namespace mlcca
