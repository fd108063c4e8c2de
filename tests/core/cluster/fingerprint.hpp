// SPDX-License-Identifier: BSD-2-Clause
// 128 bits of a state, so that a checker knows whether it was there before.
#pragma once
#include <concepts>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/cluster/member.hpp"
#include "tests/core/cluster/parts.hpp"

namespace mlcca::core::cluster::test {

class Fingerprint {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (add(values), ...);
  }
  [[nodiscard]] std::pair<std::uint64_t, std::uint64_t> value() const { return {low_, high_}; }

 private:
  void word(std::uint64_t v) {
    low_ = (low_ ^ v) * 0x9e3779b97f4a7c15U;
    low_ ^= low_ >> 29U;
    high_ = (high_ + v) * 0xc2b2ae3d27d4eb4fU;
    high_ ^= high_ >> 31U;
  }
  template <class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void add(T v) {
    word(static_cast<std::uint64_t>(v));
  }
  void add(std::string_view text) {
    word(text.size());
    for (const char c : text) word(static_cast<std::uint8_t>(c));
  }
  void add(const std::string& text) { add(std::string_view(text)); }
  template <class T>
    requires requires(const T& v, Fingerprint& f) { v.visit_state(f); }
  void add(const T& v) {
    v.visit_state(*this);
  }
  template <class A, class B>
  void add(const std::pair<A, B>& v) {
    (*this)(v.first, v.second);
  }
  template <class... T>
  void add(const std::tuple<T...>& v) {
    std::apply(*this, v);
  }
  template <class T>
  void add(const std::optional<T>& v) {
    word(v.has_value());
    if (v) add(*v);
  }
  template <class T>
  void add(const std::vector<T>& all) {
    word(all.size());
    for (const auto& v : all) add(static_cast<const T&>(v));
  }
  template <class T, std::size_t N>
  void add(const std::array<T, N>& all) {
    for (const T& v : all) add(v);
  }
  template <class K, class V, class C>
  void add(const std::map<K, V, C>& all) {
    word(all.size());
    for (const auto& [key, v] : all) (*this)(key, v);
  }
  template <class T>
  void add(const std::set<T>& all) {
    word(all.size());
    for (const auto& v : all) add(v);
  }
  template <class T>
  void add(const Record<T>& v) {
    (*this)(v.value, v.mod);
  }
  void add(const Records::ReservationKey& v) { (*this)(v.network, v.gateway, v.id); }
  void add(const ReservationRecord& v) { (*this)(v.taken, v.mod, v.over_from); }
  void add(const AskedRecord& v) { (*this)(v.asked.stage, v.asked.gateways, v.create, v.mod); }
  void add(const MemberRecord& v) { (*this)(v.mod, v.fence, v.beat, v.lease); }
  void add(const Beat& v) {
    (*this)(v.incarnation, v.session, v.seq, v.digest[0], v.generation, v.applied, v.role,
            v.draining, v.lease);
  }
  void add(const Taken& v) { (*this)(bytes_of(v.part.rates), v.through); }
  void add(const VoteOf& v) { (*this)(v.asked, v.vote); }
  void add(const Vote& v) { (*this)(v.ok, v.reason); }
  void add(const Current& v) {
    (*this)(v.generation, v.digest[0], v.former[0], v.open, v.waits, v.undone);
  }
  void add(const Next& v) { (*this)(v.generation, v.digest[0], v.chunks, v.by, v.without); }
  void add(const RolloutVote& v) { (*this)(v.next, v.ok, v.reason); }
  void add(const Rollout& v) { (*this)(v.digest[0], v.chunks, v.without); }
  void add(const Journalled& v) {
    (*this)(v.epoch[0], v.epoch_revision, v.incarnation, v.seen_revision, v.voted_digest[0],
            v.gone_back, v.waits);
  }
  void add(const Footprint& v) {
    word(v.parts.size());
    for (const Part& part : v.parts) (*this)(part.network, bytes_of(part.rates));
    add(v.gateways);
  }
  void add(const Conflict& v) { (*this)(v.id, v.network, v.by, v.tries); }
  void add(const Entry& v) { (*this)(v.key, v.value, v.create, v.mod, v.gone); }
  void add(const Batch& v) { (*this)(v.revision, v.entries); }
  void add(const TxnResult& v) { (*this)(v.id, v.outcome, v.revision, v.read); }
  void add(const Txn& v) {
    (*this)(v.id, v.compares.size(), v.deletes);
    for (const Put& put : v.puts) (*this)(put.key, put.value);
    for (const Compare& c : v.compares) (*this)(c.key, c.revision);
  }
  void add(const Records& v) {
    (*this)(v.members, v.versions, v.reservations, v.asked, v.votes, v.epoch, v.current, v.next,
            v.rollout_votes, v.blobs.size(), v.strange.size(), v.left.size(), v.too_many);
  }

  std::uint64_t low_ = 0x243f6a8885a308d3U, high_ = 0x13198a2e03707344U;
};

}  // namespace mlcca::core::cluster::test
