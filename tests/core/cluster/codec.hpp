// SPDX-License-Identifier: BSD-2-Clause
// Records as short texts: what a Codec is, for tests of the protocol.
#pragma once
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/number.hpp"
#include "core/cluster/types.hpp"
#include "tests/core/cluster/parts.hpp"

namespace mlcca::core::cluster::test {

class TextCodec : public Codec {
 public:
  [[nodiscard]] std::string write(const Beat& b) const override {
    return line({b.incarnation, num(b.session), num(b.seq), b.digest[0], num(b.generation),
                 b.applied, static_cast<std::int64_t>(b.role), b.draining, num(b.lease)});
  }
  [[nodiscard]] std::string write(const Taken& t) const override {
    return line({num(bytes_of(t.part.rates))}) + list(t.through);
  }
  [[nodiscard]] std::string write(const RouteRequest& a) const override {
    return line({static_cast<std::int64_t>(a.stage)}) + list(a.gateways) + a.admission;
  }
  [[nodiscard]] std::string write(const VoteOf& v) const override {
    return line({v.asked, v.vote.ok, v.vote.final}) + v.vote.reason;
  }
  [[nodiscard]] std::string write(const Current& c) const override {
    return line({num(c.generation), c.digest[0], c.former[0], c.open, c.undone}) + names(c.waits);
  }
  [[nodiscard]] std::string write(const Next& n) const override {
    return line({num(n.generation), n.digest[0], n.chunks, num(n.patience)}) + n.by + ' ' +
           names(n.without);
  }
  [[nodiscard]] std::string write(const RolloutVote& v) const override {
    return line({v.next, v.ok}) + v.reason;
  }

  [[nodiscard]] std::optional<Beat> beat(std::string_view v) const override {
    const auto n = numbers<9>(v);
    if (!n) return std::nullopt;
    Beat b{.incarnation = (*n)[0],
           .session = val((*n)[1]),
           .seq = val((*n)[2]),
           .generation = val((*n)[4]),
           .applied = (*n)[5],
           .role = static_cast<Role>((*n)[6]),
           .draining = (*n)[7] != 0,
           .lease = val((*n)[8])};
    b.digest[0] = static_cast<std::uint8_t>((*n)[3]);
    return b;
  }
  [[nodiscard]] std::optional<Taken> taken(std::string_view v, std::size_t network) const override {
    const auto n = numbers<1>(v);
    if (!n) return std::nullopt;
    return Taken{.channel = {},
                 .publisher = {},
                 .part = part_of(network, val((*n)[0])),
                 .through = take_list(v)};
  }
  [[nodiscard]] bool of_other_description(std::string_view taken) const override {
    return taken == "of another";
  }
  [[nodiscard]] std::optional<RouteRequest> asked(std::string_view v) const override {
    const auto n = numbers<1>(v);
    if (!n) return std::nullopt;
    RouteRequest a{.stage = static_cast<Stage>((*n)[0]), .admission = {}, .gateways = take_list(v)};
    a.admission = v;
    return a;
  }
  [[nodiscard]] std::optional<VoteOf> vote(std::string_view v) const override {
    const auto n = numbers<3>(v);
    if (!n) return std::nullopt;
    return VoteOf{
        .asked = (*n)[0],
        .vote = {.ok = (*n)[1] != 0, .hop = {}, .reason = std::string(v), .final = (*n)[2] != 0}};
  }
  [[nodiscard]] std::optional<Current> current(std::string_view v) const override {
    const auto n = numbers<5>(v);
    if (!n) return std::nullopt;
    Current c{.generation = val((*n)[0]),
              .open = (*n)[3] != 0,
              .waits = take_names(v),
              .undone = (*n)[4] != 0};
    c.digest[0] = static_cast<std::uint8_t>((*n)[1]);
    c.former[0] = static_cast<std::uint8_t>((*n)[2]);
    return c;
  }
  [[nodiscard]] std::optional<Next> next(std::string_view v) const override {
    const auto n = numbers<4>(v);
    if (!n) return std::nullopt;
    Next next{.generation = val((*n)[0]),
              .chunks = static_cast<std::uint32_t>((*n)[2]),
              .by = {},
              .without = {},
              .patience = val((*n)[3])};
    next.digest[0] = static_cast<std::uint8_t>((*n)[1]);
    auto all = take_names(v);
    if (all.empty()) return std::nullopt;
    next.by = all.front();
    next.without.assign(all.begin() + 1, all.end());
    return next;
  }
  [[nodiscard]] std::optional<RolloutVote> rollout_vote(std::string_view v) const override {
    const auto n = numbers<2>(v);
    if (!n) return std::nullopt;
    return RolloutVote{.next = (*n)[0], .ok = (*n)[1] != 0, .reason = std::string(v)};
  }
  [[nodiscard]] std::optional<Epoch> epoch(std::string_view v) const override {
    if (v.empty()) return std::nullopt;
    Epoch e{};
    e[0] = static_cast<std::uint8_t>(v.front());
    return e;
  }

  [[nodiscard]] static Digest digest(std::uint8_t number) {
    Digest d{};
    d[0] = number;
    return d;
  }

 private:
  static std::int64_t num(std::uint64_t v) { return static_cast<std::int64_t>(v); }
  static std::uint64_t val(std::int64_t v) { return static_cast<std::uint64_t>(v); }
  static std::string line(std::initializer_list<std::int64_t> numbers) {
    std::string out;
    for (const std::int64_t n : numbers) (out += std::to_string(n)) += ' ';
    return out;
  }
  static std::string list(const std::vector<std::size_t>& indexes) {
    std::string out = std::to_string(indexes.size()) + ' ';
    for (const std::size_t i : indexes) (out += std::to_string(i)) += ' ';
    return out;
  }
  static std::string names(const std::vector<std::string>& all) {
    std::string out;
    for (const auto& name : all) (out += name) += ' ';
    return out;
  }
  static std::optional<std::int64_t> take(std::string_view& v) {
    auto n = take_number<std::int64_t>(v);
    if (!n || v.empty() || v.front() != ' ') return std::nullopt;
    v.remove_prefix(1);
    return n;
  }
  template <std::size_t N>
  static std::optional<std::array<std::int64_t, N>> numbers(std::string_view& v) {
    std::array<std::int64_t, N> all{};
    for (auto& n : all) {
      const auto read = take(v);
      if (!read) return std::nullopt;
      n = *read;
    }
    return all;
  }
  static std::vector<std::size_t> take_list(std::string_view& v) {
    std::vector<std::size_t> all;
    const auto count = take(v).value_or(0);
    for (std::int64_t i = 0; i < count; ++i)
      all.push_back(static_cast<std::size_t>(take(v).value_or(0)));
    return all;
  }
  static std::vector<std::string> take_names(std::string_view& v) {
    std::vector<std::string> all;
    while (!v.empty()) {
      const auto space = std::min(v.find(' '), v.size());
      if (space > 0) all.emplace_back(v.substr(0, space));
      v.remove_prefix(std::min(space + 1, v.size()));
    }
    return all;
  }
};

}  // namespace mlcca::core::cluster::test
