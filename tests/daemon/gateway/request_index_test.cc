// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/request_index.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace mlcca::test {
namespace {

std::size_t compared = 0;
struct CountedLess {
  bool operator()(const auto& a, const auto& b) const {
    ++compared;
    return a < b;
  }
};
using Index = RequestIndex<CountedLess>;
using Admission = Index::Admission;

constexpr std::size_t kGateway = 1;

WhichRequest request(std::uint64_t number, std::uint8_t content = 0) {
  return {.gateway = kGateway, .number = number, .content = {content}};
}

TEST(RequestIndex, FindsWhoHoldsANumberAndForWhat) {
  Index index;
  EXPECT_EQ(index.held(request(1)), nullptr);
  index.hold(request(1, 5), {kGateway, 10});
  ASSERT_NE(index.held(request(1, 6)), nullptr);
  EXPECT_EQ(index.held(request(1, 6))->which, request(1, 5));
  EXPECT_EQ(index.held(request(1, 6))->holder, Admission(kGateway, 10));
  EXPECT_EQ(index.held(request(2, 5)), nullptr);
  WhichRequest elsewhere = request(1, 5);
  elsewhere.gateway = kGateway + 1;
  EXPECT_EQ(index.held(elsewhere), nullptr);
  index.hold(request(1, 5), {kGateway, 11});
  EXPECT_EQ(index.held(request(1, 5))->holder, Admission(kGateway, 11));
  index.hold_no_more(request(1, 5));
  EXPECT_EQ(index.held(request(1, 5)), nullptr);
}

TEST(RequestIndex, FindsAnotherOneThatAsksForTheSameFirstOneThatIsOpen) {
  Index index;
  const Admission first(kGateway, 10);
  const Admission second(kGateway, 11);
  const Admission third(kGateway, 12);
  index.ask(request(1), first);
  EXPECT_EQ(index.other(request(1), first), std::nullopt);
  for (const Admission& one : {second, third}) index.ask(request(1), one);
  EXPECT_EQ(index.other(request(1), first), second);
  index.set_open(request(1), third, true);
  EXPECT_EQ(index.other(request(1), first), third);
  EXPECT_EQ(index.other(request(1), third), first);
  EXPECT_EQ(index.other(request(1, 5), first), std::nullopt) << "something else";
  index.set_open(request(1), third, false);
  EXPECT_EQ(index.other(request(1), first), second);
  index.ask_no_more(request(1), second);
  EXPECT_EQ(index.other(request(1), first), third);
  index.set_open(request(1), second, true);
  EXPECT_EQ(index.other(request(1), first), third) << "it does not ask any more";
}

/// As many as a gateway may write, with numbers of their own or all with the same one.
TEST(RequestIndex, ComparesWithFewOfManyAdmissions) {
  constexpr std::uint64_t many = 20'000;
  for (const bool same : {false, true}) {
    Index index;
    for (std::uint64_t n = 0; n < many; ++n) {
      index.ask(request(same ? 0 : n), {kGateway, n});
      index.hold(request(same ? 0 : n), {kGateway, n});
    }
    compared = 0;
    for (std::uint64_t n = 0; n < many; ++n) {
      const WhichRequest which = request(same ? 0 : n);
      index.set_open(which, {kGateway, n}, true);
      static_cast<void>(index.held(which));
      static_cast<void>(index.other(which, {kGateway, n}));
      index.ask_no_more(which, {kGateway, n});
      index.hold_no_more(which);
    }
    constexpr std::size_t searches = 12;
    EXPECT_LT(compared, many * searches * 2 * std::bit_width(many)) << same;
  }
}

}  // namespace
}  // namespace mlcca::test
