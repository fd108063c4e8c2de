// SPDX-License-Identifier: BSD-2-Clause
// Tests of how often a gateway decides about one entry of another gateway.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "core/cluster/member.hpp"
#include "daemon/cluster/codec.hpp"
#include "daemon/gateway/adopting.hpp"
#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

class MembersAdopting : public testing::Test {
 protected:
  MembersAdopting() {
    Adopting::Hands hands{};
    hands.misfit = [this](const control::Request& request) {
      ++decisions_;
      const auto& admit = std::get<control::Admit>(request.body);
      const bool fits = admit.to.empty() || admit.publisher == fitting_;
      return fits ? std::string() : "nobody publishes";
    };
    hands.name_of = [](std::size_t g) { return "g" + std::to_string(g); };
    hands.new_id = [this] { return ++ids_; };
    hands.new_number = [this] { return ++ids_; };
    hands.bring_in_line = [] {};
    adopting_ = std::make_unique<Adopting>(networks_, std::move(hands));
  }
  /// g1 asks for so many publishers and then for so many subscribers. Returns the decisions.
  std::size_t decisions_about(std::size_t publishers, std::size_t subscribers) {
    cluster::StoredRequest asked{.channel = "c2", .requests = {}};
    for (std::size_t n = 0; n < publishers; ++n) {
      control::Admit admit;
      admit.channel = asked.channel;
      admit.from = "own1";
      admit.publisher = "p" + std::to_string(n);
      asked.also.push_back({.id = ++ids_, .body = admit});
    }
    for (std::size_t n = 0; n < subscribers; ++n) {
      control::Admit admit;
      admit.channel = asked.channel;
      admit.to = "own0";
      admit.subscriber = "s" + std::to_string(n);
      asked.requests.push_back({.id = ++ids_, .body = admit});
    }
    decisions_ = 0;
    adopting_->on(cc::Adopt{.origin = {.gateway = 1, .id = ++ids_, .asked = 1},
                            .admission = cluster::text_of(asked),
                            .footprint = {}});
    adopting_->step(member_, 0);
    return decisions_;
  }

  std::string fitting_ = "p0";  ///< the publisher that subscribers fit with
  std::size_t decisions_ = 0;
  std::uint64_t ids_ = 1000;
  core::System system_ = two_gateways();
  cluster::Codec codec_{system_, cc::Digest{1}};
  SharedNetworks networks_{system_, 0};
  cc::Member member_{std::make_shared<cc::Keys>(system_, "/mlcca/pair/"), codec_,
                     cc::Member::Identity{.gateway = 0, .lease = kLease}};
  std::unique_ptr<Adopting> adopting_;
};

TEST_F(MembersAdopting, EachSubscriberIsTriedAloneAndWithAPublisherThatComesWithIt) {
  EXPECT_EQ(decisions_about(1, 1), 2U);
  EXPECT_EQ(decisions_about(1, 255), 2U * 255);
}

TEST_F(MembersAdopting, ManyPublishersTakeNoMoreDecisionsThanTwoForEachRequest) {
  constexpr std::size_t half = cluster::StoredRequest::kMostRequests / 2;
  fitting_ = "p" + std::to_string(half - 1);
  const std::size_t all = decisions_about(half, half);
  EXPECT_GT(all, half);
  EXPECT_LE(all, 2 * cluster::StoredRequest::kMostRequests);
}

}  // namespace
}  // namespace mlcca::test
