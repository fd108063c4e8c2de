// SPDX-License-Identifier: BSD-2-Clause
// What a daemon adds to a member of the protocol so that it takes part in rollouts: a model of
// daemon/gateway/rollout. Descriptions are numbers, and all have the same gateways and networks.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/cluster/following.hpp"
#include "tests/core/cluster/codec.hpp"

namespace mlcca::core::cluster::test {

/// The description that does not have the last gateway, where a scenario says so.
inline constexpr std::uint8_t kWithoutLast = 2;

/// A rollout that an operator begins once.
struct Order {
  std::size_t gateway = 0;
  std::uint8_t description = 2;
  std::vector<std::string> off = {};  ///< gateways that are called off
  bool back = false;                  ///< of the description before, whatever it is
};

/// Reservations have the digest of the description from which they were decided, as in the daemon.
class DescriptionCodec : public TextCodec {
 public:
  explicit DescriptionCodec(std::uint8_t description)
      : mark_(static_cast<char>('a' + description)) {}
  using TextCodec::taken;
  using TextCodec::write;
  [[nodiscard]] std::string write(const Taken& taken) const override {
    return mark_ + TextCodec::write(taken);
  }
  [[nodiscard]] std::optional<Taken> taken(std::string_view v, std::size_t network) const override {
    if (v.empty() || v.front() != mark_) return std::nullopt;
    return TextCodec::taken(v.substr(1), network);
  }

 private:
  char mark_;
};

struct RolloutSide {
  enum class State : std::uint8_t { none, open, switching, in_force, refused };
  // It survives a crash.
  Following following;
  // It is of one process.
  std::uint8_t loaded = 1;
  bool joined = false;
  Value lapsed_at = 0;  ///< its gates have closed without heart-beats, by its clock; 0: not since
  Value awaits = 0;     ///< real time until which its gates are as the former process left them
  std::optional<Digest> to_judge;
  std::set<std::pair<std::size_t, std::uint64_t>> opened;  ///< adopted admissions that are granted
  std::int64_t agreed_to = 0;  ///< revision of the proposal that this gateway agrees to
  // The latest rollout that was begun here.
  State state = State::none;
  Digest own{};
  // The kernel's gate of what the description promises on the shared network, whatever is reserved.
  bool open = false;
  std::uint8_t of = 1;  ///< the description of what passes it
  Value dead_from = 0;  ///< real time at which it closes without heart-beats; 0: it gets them
  Value closed = 0;     ///< real time

  template <class F>
  void visit_state(F&& f) const {
    f(following.rolled[0], following.replaced[0], following.in_force[0], following.voted[0],
      following.wanted.has_value(), following.wanted.value_or(Digest{})[0], loaded, joined,
      lapsed_at, awaits, to_judge.has_value(), to_judge.value_or(Digest{})[0], opened, agreed_to,
      state, own[0], open, of, dead_from, closed);
  }
};

}  // namespace mlcca::core::cluster::test
