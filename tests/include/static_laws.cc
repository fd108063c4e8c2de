// SPDX-License-Identifier: BSD-2-Clause
// What must hold at compile time on every compiler that a node uses: the table, the paper's
// example, the edges. C++14 and freestanding; check-mcu compiles it once for each of them.
#include "mlcca/mlcca.hpp"

namespace mlcca {
namespace {

constexpr bool same_text(const char* a, const char* b) {
  for (; *a != '\0' && *a == *b; ++a) ++b;
  return *a == *b;
}

constexpr bool table_is_unique() {
  for (size_t i = 0; i < kAttributes; ++i)
    for (size_t j = 0; j < i; ++j)
      if (same_text(kAttributeTable[i].name, kAttributeTable[j].name) ||
          kAttributeTable[i].tag == kAttributeTable[j].tag)
        return false;
  return true;
}
constexpr bool table_is_complete() {
  for (size_t i = 0; i < kAttributes; ++i)
    if (kAttributeTable[i].name[0] == '\0' || kAttributeTable[i].unit[0] == '\0' ||
        kAttributeTable[i].tag != i + 1)
      return false;
  return index_of(Attribute::max_payload) + 1 == kAttributes;
}
static_assert(table_is_unique(), "names and tags identify an attribute");
static_assert(table_is_complete(), "tags are part of the wire formats: append only");
static_assert(same_text(info(Attribute::packet_loss).name, "PacketLoss"), "");
static_assert(!same_text("Period", "Perio") && !same_text("Perio", "Period"), "");

// The emergency switch of the paper, on its own bus and behind the bridge.
constexpr AttributeSet kSwitch = make_set<Period<50_ms>, Omission<2>>();
constexpr AttributeSet kBus = make_set<Period<10_ms>, Omission<2>>();
constexpr AttributeSet kBridge = make_set<Period<10_ms>, Omission<5>>();
constexpr CheckResult kRefusal = check_layer(kSwitch, kBridge);
static_assert(check_layer(kSwitch, kBus).outcome == Outcome::fit, "");
static_assert(kRefusal.outcome == Outcome::unfit && kRefusal.count == 3, "");
static_assert(kRefusal.rows[0].attribute == Attribute::deadline, "implied by the Period");
static_assert(kRefusal.rows[0].outcome == Outcome::fit, "");
static_assert(kRefusal.rows[1].outcome == Outcome::fit, "");
static_assert(kRefusal.rows[2].attribute == Attribute::omission, "");
static_assert(kRefusal.rows[2].required == 2 && kRefusal.rows[2].provided == 5, "");
static_assert(kRefusal.rows[2].margin() == 3, "");

// 24 and 11 Mbit/s in a row on one medium are 7.542857 Mbit/s; on two media the slower one.
constexpr Hop kMesh[] = {{make_set<Bandwidth<24_Mbit_per_s>>(), 1, 1},
                         {make_set<Bandwidth<11_Mbit_per_s>>(), 1, 1}};
constexpr Hop kTwoMedia[] = {{make_set<Bandwidth<24_Mbit_per_s>>(), 1, 1},
                             {make_set<Bandwidth<11_Mbit_per_s>>(), 2, 1}};
static_assert(compose(kMesh, 2)[Attribute::bandwidth] == 7542857 / 8, "");
static_assert(compose(kTwoMedia, 2)[Attribute::bandwidth] == 11000000 / 8, "");
static_assert(check_route(make_set<Bandwidth<400_kB_per_s>>(), kMesh, 2).outcome == Outcome::fit,
              "");

// Composition at its edges.
constexpr Hop kLossy[] = {{make_set<PacketLoss<10_percent>, Omission<1>>(), 1, 1},
                          {make_set<PacketLoss<10_percent>, Omission<2>>(), 2, 1}};
constexpr Hop kTiny[] = {{make_set<PacketLoss<1_ppb>>(), 1, 1},
                         {make_set<PacketLoss<1_ppb>>(), 1, 1}};
constexpr Hop kFragmented[] = {{make_set<PacketLoss<10_percent>, Omission<0>>(), 1, 2}};
constexpr Hop kFragmentedLosing[] = {{make_set<Omission<1>>(), 1, 2}};
static_assert(compose(kLossy, 2)[Attribute::packet_loss] == 190000000, "");
static_assert(compose(kLossy, 2)[Attribute::omission] == 5, "(1 + 1)(2 + 1) - 1");
static_assert(compose(kTiny, 2)[Attribute::packet_loss] == 2, "1.999999999 rounded up once");
static_assert(compose(kFragmented, 1)[Attribute::packet_loss] == 190000000, "1 - 0.9^2");
static_assert(compose(kFragmented, 1)[Attribute::omission] == 0, "");
static_assert(compose(kFragmentedLosing, 1)[Attribute::omission] == kUnbounded, "");

// Refusal by default.
static_assert(compose(kMesh, 0).empty() && compose(kMesh, kMaxComposedHops + 1).empty(), "");
static_assert(check_route(AttributeSet(), kMesh, 0).outcome == Outcome::unfit, "");
static_assert(check_layer(AttributeSet(), AttributeSet()).outcome == Outcome::fit, "");
static_assert(check_layer(kSwitch, AttributeSet()).outcome == Outcome::unfit, "");
static_assert(at_run_time(Outcome::run_time) == Outcome::unfit, "");
static_assert(at_run_time(Outcome::fit) == Outcome::fit, "");
static_assert(worse(Outcome::fit, Outcome::run_time) == Outcome::run_time, "");
static_assert(worse(Outcome::unfit, Outcome::run_time) == Outcome::unfit, "");

// No wrap-around.
static_assert(add_saturating(kUnbounded - 1, 1) == kUnbounded, "");
static_assert(add_saturating(kUnbounded, 1) == kUnbounded, "");
static_assert(mul_saturating(kUnbounded / 2, 2) == kUnbounded - 1, "");
static_assert(mul_saturating(kUnbounded / 2 + 1, 2) == kUnbounded, "");
static_assert(sub_floor(1, 2) == 0 && sub_floor(2, 1) == 1, "");
static_assert(mul_div_down(kUnbounded - 1, kUnbounded, kUnbounded) == kUnbounded - 1, "");
static_assert(mul_div_up(kUnbounded, kUnbounded, kUnbounded - 1) == kUnbounded, "");

// Worst-case reaction of the switch: 3 * 50 ms and the whole way.
static_assert(
    worst_case_reaction(make_set<Period<50_ms>, Omission<2>, Latency<4_ms>, Jitter<1_ms>>()) ==
        count(155_ms),
    "");

}  // namespace
}  // namespace mlcca
