// SPDX-License-Identifier: BSD-2-Clause
// Compile-time checks that pass, and what the errors of the others say. That a compiler prints it
// as one short error is in tests/include/compile/.
#include "mlcca/static_check.hpp"

#include <gtest/gtest.h>

#include <type_traits>

namespace mlcca {
namespace {

using detail::LayerQuestion;
using detail::RouteQuestion;
using detail::TrafficQuestion;

template <class Question, class Error>
constexpr bool says = std::is_same_v<decltype(Question::Mismatch::error()), Error>;
template <class Question, class Error>
constexpr bool user_says = std::is_same_v<decltype(Question::Users::Mismatch::error()), Error>;

template <Value V>
struct Temperature : UserAttribute<Temperature, V, Better::smaller, Composition::slowest> {};
template <Value V>
struct Cost : UserAttribute<Cost, V, Better::smaller, Composition::sum> {};
template <Value V>
struct Trust : UserAttribute<Trust, V, Better::larger, Composition::smallest> {};
template <Value V>
struct Corruption : UserAttribute<Corruption, V, Better::smaller, Composition::survival> {};

using Switch = AttributeList<Period<50_ms>, Omission<2>>;
using Can = AttributeList<Period<10_ms>, Omission<2>>;
using Bridge = AttributeList<Period<10_ms>, Omission<5>>;

// A layer.
using CanCarriesTheSwitch = Check<Switch, Can>;
static_assert(std::is_same_v<CanCarriesTheSwitch, Fit>);
static_assert(std::is_same_v<CanCarriesTheSwitch::type, Fit>);
static_assert(Check<AttributeList<>, AttributeList<>>::value, "nothing is asked for");
static_assert(says<LayerQuestion<Switch, Bridge>,
                   ATTRIBUTES_MISMATCH<PROVIDED<Omission<5>>, REQUIRED<Omission<2>>>>);
static_assert(says<LayerQuestion<Switch, AttributeList<Omission<2>>>,
                   ATTRIBUTES_MISMATCH<NOT_PROVIDED, REQUIRED<Period<50_ms>>>>,
              "the Period that is written, not the Deadline that it implies");
static_assert(
    says<LayerQuestion<Switch, AttributeList<Period<10_ms>, Latency<51_ms>, Omission<2>>>,
         ATTRIBUTES_MISMATCH<PROVIDED<Latency<51_ms>>, REQUIRED<Period<50_ms>, AS_DEADLINE>>>);
static_assert(says<LayerQuestion<AttributeList<Deadline<9_ms>>, AttributeList<Period<10_ms>>>,
                   ATTRIBUTES_MISMATCH<PROVIDED<Period<10_ms>>, REQUIRED<Deadline<9_ms>>>>,
              "a provided Period promises a Latency");
static_assert(says<LayerQuestion<AttributeList<MaxPayload<9_bytes>, Omission<0>>,
                                 AttributeList<MaxPayload<8_bytes>, Omission<1>>>,
                   ATTRIBUTES_MISMATCH<PROVIDED<Omission<1>>, REQUIRED<Omission<0>>>>,
              "of several the first in the order of the table");

// A best case refutes, and does not grant: that is decided at run time.
using Mesh = AttributeList<Dynamic<Latency<5_ms>>>;
static_assert(Check<AttributeList<Latency<5_ms>>, Mesh>::value);
static_assert(says<LayerQuestion<AttributeList<Latency<4_ms>>, Mesh>,
                   ATTRIBUTES_MISMATCH<PROVIDED<Dynamic<Latency<5_ms>>>, REQUIRED<Latency<4_ms>>>>);
static_assert(Check<AttributeList<Dynamic<Omission<2>>>, AttributeList<Omission<2>>>::value,
              "means nothing in a requirement");

// Publisher against subscriber.
static_assert(CheckTraffic<Switch, AttributeList<Period<50_ms>, Deadline<1_ms>>>::value);
static_assert(says<TrafficQuestion<Switch, AttributeList<Period<40_ms>>>,
                   ATTRIBUTES_MISMATCH<PUBLISHED<Period<50_ms>>, REQUIRED<Period<40_ms>>>>);
static_assert(says<TrafficQuestion<Switch, AttributeList<Jitter<1_ms>>>,
                   ATTRIBUTES_MISMATCH<NOT_PUBLISHED, REQUIRED<Jitter<1_ms>>>>);
static_assert(
    CheckTraffic<AttributeList<MaxPayload<8_bytes>>, AttributeList<MaxPayload<8_bytes>>>::value);
static_assert(
    says<TrafficQuestion<AttributeList<MaxPayload<9_bytes>>, AttributeList<MaxPayload<8_bytes>>>,
         ATTRIBUTES_MISMATCH<PUBLISHED<MaxPayload<9_bytes>>, ACCEPTED<MaxPayload<8_bytes>>>>);
// 8 bytes in 3 ms are 2666.67 bytes/s.
static_assert(says<TrafficQuestion<AttributeList<MaxPayload<8_bytes>, Period<3_ms>>,
                                   AttributeList<Bandwidth<2667_bytes_per_s>>>,
                   ATTRIBUTES_MISMATCH<PUBLISHED<Bandwidth<2666_bytes_per_s>>,
                                       REQUIRED<Bandwidth<2667_bytes_per_s>>>>);

// Both ends together: the harder one of each.
using Strict = AttributeList<Omission<1>, Latency<20_ms>>;
static_assert(
    Check<Union<Switch, Strict>, AttributeList<Period<10_ms>, Latency<20_ms>, Omission<1>>>::value);
static_assert(says<LayerQuestion<Union<Switch, Strict>, Can>,
                   ATTRIBUTES_MISMATCH<PROVIDED<Omission<2>>, REQUIRED<Omission<1>>>>);
static_assert(says<LayerQuestion<Union<Strict, Switch>, Can>,
                   ATTRIBUTES_MISMATCH<PROVIDED<Omission<2>>, REQUIRED<Omission<1>>>>);
static_assert(
    says<LayerQuestion<Union<Switch, AttributeList<Deadline<1_s>>>,
                       AttributeList<Period<10_ms>, Latency<60_ms>, Omission<1>>>,
         ATTRIBUTES_MISMATCH<PROVIDED<Latency<60_ms>>, REQUIRED<Period<50_ms>, AS_DEADLINE>>>,
    "a lenient listener softens nothing");
static_assert(Check<Union<AttributeList<Jitter<9_ms>>, AttributeList<>>, AttributeList<>>::value,
              "the Jitter of the source asks nothing of a network");

// Routes. Two networks that lose one event in a row lose (1 + 1)(1 + 1) - 1 = 3 together.
using LosesOne = AttributeList<Period<10_ms>, Omission<1>>;
using Pc = AttributeList<Latency<1_ms>, Omission<0>>;
static_assert(CheckRoute<Switch, RouteOf<Network<LosesOne>, Gateway<Pc>>>::value,
              "a gateway that states no Period limits none");
static_assert(says<RouteQuestion<Switch, RouteOf<Network<LosesOne>, Network<Pc>>>,
                   ATTRIBUTES_MISMATCH<HOP<2>, NOT_PROVIDED, REQUIRED<Period<50_ms>>>>,
              "a network that states no Period does not provide one");
static_assert(says<RouteQuestion<Switch, RouteOf<Network<Can>, Gateway<Pc>, Network<Bridge>>>,
                   ATTRIBUTES_MISMATCH<HOP<3>, PROVIDED<Omission<5>>, REQUIRED<Omission<2>>>>);
static_assert(
    says<RouteQuestion<Switch, RouteOf<Network<LosesOne>, Gateway<Pc>, Network<LosesOne>>>,
         ATTRIBUTES_MISMATCH<END_TO_END, PROVIDED<Omission<3>>, REQUIRED<Omission<2>>>>);
static_assert(says<RouteQuestion<Switch, RouteOf<Gateway<AttributeList<Omission<0>>>>>,
                   ATTRIBUTES_MISMATCH<HOP<1>, NOT_PROVIDED, REQUIRED<Period<50_ms>, AS_DEADLINE>>>,
              "a gateway delays, whatever it limits");
static_assert(says<RouteQuestion<AttributeList<Bandwidth<9_kB_per_s>>,
                                 RouteOf<Gateway<AttributeList<Bandwidth<8_kB_per_s>>>>>,
                   ATTRIBUTES_MISMATCH<HOP<1>, PROVIDED<Bandwidth<8_kB_per_s>>,
                                       REQUIRED<Bandwidth<9_kB_per_s>>>>,
              "a limit that a gateway does state");
// An event of two frames, each lost with 10 %: 1 - 0.9^2 = 19 %.
using Lossy = AttributeList<PacketLoss<10_percent>>;
using Tolerant = AttributeList<PacketLoss<18_percent>>;
static_assert(CheckRoute<Tolerant, RouteOf<Network<Lossy>>>::value);
static_assert(says<RouteQuestion<Tolerant, RouteOf<Network<Lossy, 2>>>,
                   ATTRIBUTES_MISMATCH<HOP<1>, PROVIDED<PacketLoss<19_percent>>,
                                       REQUIRED<PacketLoss<18_percent>>>>);
// Two networks are two media: the slower one counts, they do not share one medium's time.
static_assert(CheckRoute<AttributeList<Bandwidth<11_Mbit_per_s>>,
                         RouteOf<Network<AttributeList<Bandwidth<24_Mbit_per_s>>>,
                                 Network<AttributeList<Bandwidth<11_Mbit_per_s>>>>>::value);
// The jitter of the source joins that of the route.
using Shaky = AttributeList<Jitter<2_ms>>;
static_assert(CheckRoute<Union<Shaky, AttributeList<Jitter<5_ms>>>,
                         RouteOf<Network<AttributeList<Jitter<3_ms>>>>>::value);
static_assert(
    says<RouteQuestion<Union<Shaky, AttributeList<Jitter<5_ms>>>,
                       RouteOf<Network<AttributeList<Jitter<4_ms>>>>>,
         ATTRIBUTES_MISMATCH<END_TO_END, PROVIDED<Jitter<6_ms>>, REQUIRED<Jitter<5_ms>>>>);
static_assert(CheckRoute<AttributeList<Latency<9_ms>>,
                         RouteOf<Network<Mesh>, Network<AttributeList<Latency<4_ms>>>>>::value,
              "5 ms at best and 4 ms: decided at run time");

// Attributes of the user's own.
static_assert(Check<AttributeList<Temperature<300>>, AttributeList<Temperature<300>>>::value);
static_assert(
    user_says<LayerQuestion<AttributeList<Omission<2>, Temperature<280>>,
                            AttributeList<Temperature<300>, Omission<1>>>,
              ATTRIBUTES_MISMATCH<PROVIDED<Temperature<300>>, REQUIRED<Temperature<280>>>>);
static_assert(user_says<LayerQuestion<AttributeList<Temperature<280>>, Can>,
                        ATTRIBUTES_MISMATCH<NOT_PROVIDED, REQUIRED<Temperature<280>>>>);
static_assert(
    user_says<LayerQuestion<AttributeList<Trust<3>>, AttributeList<Temperature<1>, Trust<2>>>,
              ATTRIBUTES_MISMATCH<PROVIDED<Trust<2>>, REQUIRED<Trust<3>>>>,
    "larger is better here");
static_assert(Check<AttributeList<Cost<5>>, AttributeList<Dynamic<Cost<5>>>>::value);
static_assert(user_says<LayerQuestion<AttributeList<Cost<4>>, AttributeList<Dynamic<Cost<5>>>>,
                        ATTRIBUTES_MISMATCH<PROVIDED<Dynamic<Cost<5>>>, REQUIRED<Cost<4>>>>);
template <class Required, class First, class Second>
using OverTwo =
    RouteQuestion<AttributeList<Required>,
                  RouteOf<Network<AttributeList<First>>, Gateway<AttributeList<Second>>>>;
static_assert(
    CheckRoute<AttributeList<Cost<5>>,
               RouteOf<Network<AttributeList<Cost<2>>>, Network<AttributeList<Cost<3>>>>>::value);
static_assert(user_says<OverTwo<Cost<4>, Cost<2>, Cost<3>>,
                        ATTRIBUTES_MISMATCH<END_TO_END, PROVIDED<Cost<5>>, REQUIRED<Cost<4>>>>);
static_assert(user_says<OverTwo<Cost<4>, Cost<2>, Cost<9>>,
                        ATTRIBUTES_MISMATCH<HOP<2>, PROVIDED<Cost<9>>, REQUIRED<Cost<4>>>>);
static_assert(OverTwo<Temperature<4>, Temperature<4>, Temperature<3>>::Users::kFinding ==
              detail::Finding::fit);
static_assert(OverTwo<Trust<4>, Trust<4>, Trust<5>>::Users::kFinding == detail::Finding::fit);
static_assert(
    user_says<OverTwo<Corruption<190000000>, Corruption<100000000>, Corruption<100000001>>,
              ATTRIBUTES_MISMATCH<END_TO_END, PROVIDED<Corruption<190000001>>,
                                  REQUIRED<Corruption<190000000>>>>,
    "1 - 0.9 * 0.899999999 = 0.1900000009, rounded up");
template <class Required, class Provided>
using BehindSilentGateway =
    RouteQuestion<AttributeList<Required>,
                  RouteOf<Gateway<AttributeList<>>, Network<AttributeList<Provided>>>>;
static_assert(BehindSilentGateway<Temperature<4>, Temperature<4>>::Users::kFinding ==
                  detail::Finding::fit,
              "a gateway limits no maximum that it does not state");
static_assert(BehindSilentGateway<Trust<4>, Trust<4>>::Users::kFinding == detail::Finding::fit,
              "nor a minimum");
static_assert(user_says<BehindSilentGateway<Cost<4>, Cost<4>>,
                        ATTRIBUTES_MISMATCH<HOP<1>, NOT_PROVIDED, REQUIRED<Cost<4>>>>,
              "but it may cost anything");
static_assert(
    user_says<RouteQuestion<Union<AttributeList<Omission<9>, Cost<9>>, AttributeList<Cost<1>>>,
                            RouteOf<Network<AttributeList<Omission<0>, Cost<2>>>>>,
              ATTRIBUTES_MISMATCH<HOP<1>, PROVIDED<Cost<2>>, REQUIRED<Cost<1>>>>,
    "each end's are asked for");

// What is stated here at compile time is what check_layer() answers at run time.
TEST(StaticCheckTest, TheFindingIsTheOutcomeOfTheRunTimeCheck) {
  EXPECT_EQ(check_layer(Switch::set(), Can::set()).outcome, Outcome::fit);
  EXPECT_EQ(check_layer(Switch::set(), Bridge::set()).outcome, Outcome::unfit);
  EXPECT_EQ(layer_outcome(Switch::set(), Can::set()), Outcome::fit);
  EXPECT_EQ(layer_outcome(Switch::set(), Bridge::set()), Outcome::unfit);
}

}  // namespace
}  // namespace mlcca
