// SPDX-License-Identifier: BSD-2-Clause
// A store into which a test writes what a gateway that does not run, or another program, could.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/cluster/types.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {

/// Asks for a subscriber on own1 of that channel.
inline control::Admit subscriber_on_own1(const std::string& channel, const std::string& name,
                                         const std::string& from = {}) {
  control::Admit request;
  request.channel = channel;
  request.from = from;
  request.to = "own1";
  request.subscriber = name;
  request.key = "also-" + name;
  return request;
}

class MembersForged : public MembershipBench {
 protected:
  MembersForged() : MembershipBench(with_a_described_publisher()) {}

  static std::string key(const std::string& kind) { return "/mlcca/pair/" + kind; }
  void beat_of_g1(std::uint64_t lease = kLease) {
    const auto& was = store.entries.at(key("m/g1"));
    auto beat = codec.beat(was.value).value_or(core::cluster::Beat{});
    if (beat.incarnation == 0) beat.incarnation = was.create;
    beat.digest = core::cluster::Digest{1};
    beat.lease = lease;
    beat.applied = store.revision;
    beat.generation = 1;
    store.write({{.key = key("m/g1"), .value = codec.write(beat)}});
  }
  /// g1 asks g0 to make this admission for it.
  void request_of_g1(std::uint64_t n, core::cluster::Stage stage, const control::Admit& admit) {
    const cluster::StoredRequest asked{.channel = admit.channel,
                                       .requests = {{.id = 7000 + n, .body = admit}},
                                       .also = {},
                                       .on_behalf = true};
    store.write({{.key = key("x/g1/") + std::to_string(n),
                  .value = codec.write(core::cluster::RouteRequest{
                      .stage = stage, .admission = cluster::text_of(asked), .gateways = {0}})}});
  }
  /// What g0 has answered to such a request.
  std::optional<core::cluster::Vote> answer_to_g1(std::uint64_t n) {
    const auto there = store.entries.find(key("a/g0/g1/") + std::to_string(n));
    const auto vote = there == store.entries.end() ? std::nullopt : codec.vote(there->second.value);
    if (!vote) return std::nullopt;
    return vote->vote;
  }
  /// What g0 itself has asked for, by the key of its entry.
  std::vector<std::pair<std::string, cluster::StoredRequest>> asked_by_g0() {
    std::vector<std::pair<std::string, cluster::StoredRequest>> all;
    for (const auto& [name, entry] : store.entries) {
      if (!name.starts_with(key("x/g0/"))) continue;
      const auto asked = codec.asked(entry.value);
      if (auto text = asked ? cluster::asked_in(asked->admission) : std::nullopt)
        all.emplace_back(name, std::move(*text));
    }
    return all;
  }

  cluster::RecordCodec codec{with_a_described_publisher(), core::cluster::Digest{1}};
};

}  // namespace mlcca::test
