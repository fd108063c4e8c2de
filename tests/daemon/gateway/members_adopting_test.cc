// SPDX-License-Identifier: BSD-2-Clause
// Tests of how often a gateway decides about one entry of another gateway.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/cluster/member.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "daemon/gateway/adopted_admissions.hpp"
#include "daemon/gateway/adopting.hpp"
#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

/// Decides about each request: subscribers fit with one publisher alone.
class FakeAdmissions final : public AdoptedAdmissions {
 public:
  Reserving::Refusal misfit(const control::Request& request) override {
    ++decisions;
    const auto& admit = std::get<control::Admit>(request.body);
    const bool fits = admit.to.empty() || admit.publisher == fitting;
    return {.why = fits ? "" : "nobody publishes"};
  }
  Result<void> admit(const control::Request& /*request*/) override { return {}; }
  Result<void> take_in(const control::Request& /*request*/) override { return {}; }
  void remove(const std::vector<core::AdmissionId>& /*gone*/) override {}
  void restore(const control::Request& /*request*/) override {}
  std::expected<Reserving::Wish, Reserving::Refusal> wish(const control::Request& /*request*/,
                                                          std::size_t /*gateway*/) override {
    return std::unexpected(Reserving::Refusal{.why = "nothing is reserved"});
  }
  std::set<core::AdmissionId> not_granted(const std::set<std::size_t>& /*channels*/) override {
    return {};
  }
  bool is_without_publisher(const control::Request& /*request*/) override { return false; }
  bool is_publisher_gone(const control::Request& /*request*/) override { return false; }

  std::string fitting = "p0";  ///< the publisher that subscribers fit with
  std::size_t decisions = 0;
};

/// Gives names and numbers, and reserves nothing.
class FakeHands final : public Adopting::Hands {
 public:
  void remove(const std::vector<core::AdmissionId>& /*gone*/) override {}
  Result<void> reserve(Reserving::Job /*job*/) override { return fail("nothing is reserved"); }
  void forget(Adopting::Number /*adopted*/) override {}
  [[nodiscard]] bool wants(Adopting::Number /*number*/) const override { return false; }
  void give_back(const std::vector<core::AdmissionId>& /*gone*/) override {}
  [[nodiscard]] std::string name_of(std::size_t gateway) const override {
    return "g" + std::to_string(gateway);
  }
  core::AdmissionId new_id() override { return ++numbers; }
  Adopting::Number new_number() override { return ++numbers; }
  bool bring_in_line() override { return true; }

  std::uint64_t numbers = 1000;  ///< the latest one
};

class MembersAdopting : public testing::Test {
 protected:
  /// g1 asks for so many publishers and then for so many subscribers. Returns the decisions.
  std::size_t decisions_about(std::size_t publishers, std::size_t subscribers) {
    cluster::StoredRequest asked{.channel = "c2", .requests = {}};
    for (std::size_t n = 0; n < publishers; ++n) {
      control::Admit admit;
      admit.channel = asked.channel;
      admit.from = "own1";
      admit.publisher = "p" + std::to_string(n);
      asked.also.push_back({.id = ++hands_.numbers, .body = admit});
    }
    for (std::size_t n = 0; n < subscribers; ++n) {
      control::Admit admit;
      admit.channel = asked.channel;
      admit.to = "own0";
      admit.subscriber = "s" + std::to_string(n);
      asked.requests.push_back({.id = ++hands_.numbers, .body = admit});
    }
    admissions_.decisions = 0;
    adopting_.on(cc::Adopt{.origin = {.gateway = 1, .id = ++hands_.numbers, .asked = 1},
                           .admission = cluster::text_of(asked),
                           .footprint = {}});
    adopting_.step(member_, 0);
    return admissions_.decisions;
  }

  FakeAdmissions admissions_;
  FakeHands hands_;
  core::System system_ = two_gateways();
  cluster::RecordCodec codec_{system_, cc::Digest{1}};
  SharedNetworks networks_{system_, 0};
  cc::Member member_{std::make_shared<cc::Keys>(system_, "/mlcca/pair/"), codec_,
                     cc::Member::Identity{.gateway = 0, .lease = kLease}};
  Adopting adopting_{networks_, admissions_, hands_};
};

TEST_F(MembersAdopting, EachSubscriberIsTriedAloneAndWithAPublisherThatComesWithIt) {
  EXPECT_EQ(decisions_about(1, 1), 2U);
  EXPECT_EQ(decisions_about(1, 255), 2U * 255);
}

TEST_F(MembersAdopting, ManyPublishersTakeNoMoreDecisionsThanTwoForEachRequest) {
  constexpr std::size_t half = cluster::StoredRequest::kMostRequests / 2;
  admissions_.fitting = "p" + std::to_string(half - 1);
  const std::size_t all = decisions_about(half, half);
  EXPECT_GT(all, half);
  EXPECT_LE(all, 2 * cluster::StoredRequest::kMostRequests);
}

}  // namespace
}  // namespace mlcca::test
