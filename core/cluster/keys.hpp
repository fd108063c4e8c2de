// SPDX-License-Identifier: BSD-2-Clause
// The keys of a cluster in the store, and whose they are.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core::cluster {

/// A key that was understood. What it does not name is 0.
struct Key {
  enum class Kind : std::uint8_t {
    epoch,
    current,
    next,
    blob,
    rollout_vote,
    member,
    fence,
    version,
    reservation,
    asked,
    vote,
  };
  Kind kind = Kind::epoch;
  std::size_t network = 0;
  std::size_t gateway = 0;  ///< that writes it; of a fence: whose it is
  std::size_t from = 0;     ///< of a vote: who asks
  std::uint64_t id = 0;     ///< of an admission; of a blob: its number
  std::string digest = {};  ///< of a blob, in hexadecimal digits
  bool operator==(const Key&) const = default;
};

/// A key of a gateway that the description does not have: a former one has had it.
struct LeftKey {
  Key::Kind kind = Key::Kind::member;  ///< or fence, reservation, asked, vote or rollout_vote
  std::string_view gateway;            ///< encoded
  std::optional<std::size_t> network = std::nullopt;
  std::optional<std::size_t> voter = std::nullopt;  ///< that has written a vote for it
};

/// Names are percent-encoded outside [A-Za-z0-9._-], so that a key has one reading.
class Keys {
 public:
  /// The prefix ends with '/', or is empty.
  Keys(const System& system, std::string prefix);

  [[nodiscard]] const std::string& prefix() const { return prefix_; }
  [[nodiscard]] std::string epoch() const { return prefix_ + "e"; }
  [[nodiscard]] std::string current() const { return prefix_ + "d/current"; }
  [[nodiscard]] std::string next() const { return prefix_ + "d/next"; }
  [[nodiscard]] std::string blob(std::string_view digest, std::uint64_t number) const;
  [[nodiscard]] std::string rollout_vote(std::size_t gateway) const;
  [[nodiscard]] std::string member(std::size_t gateway) const;
  [[nodiscard]] std::string fence(std::size_t gateway) const;
  [[nodiscard]] std::string version(std::size_t network) const;
  [[nodiscard]] std::string reservation(std::size_t network, std::size_t gateway,
                                        std::uint64_t id) const;
  [[nodiscard]] std::string asked(std::size_t gateway, std::uint64_t id) const;
  [[nodiscard]] std::string vote(std::size_t gateway, std::size_t from, std::uint64_t id) const;

  /// nullopt: not a key of this cluster, or of something that the description does not have.
  [[nodiscard]] std::optional<Key> parse(std::string_view key) const;
  [[nodiscard]] std::optional<LeftKey> parse_left(std::string_view key) const;
  /// What `gateway` has written about a network that the description does not have.
  [[nodiscard]] bool is_of_removed_network(std::string_view key, std::size_t gateway) const;
  /// Of a key that parse() does not understand: the network of which it would take something.
  [[nodiscard]] std::optional<std::size_t> network_of(std::string_view key) const;

  [[nodiscard]] std::size_t gateways() const { return gateways_.size(); }
  [[nodiscard]] std::size_t networks() const { return networks_.size(); }
  /// As it was given in the description.
  [[nodiscard]] const std::string& gateway_name(std::size_t gateway) const {
    return gateway_names_[gateway];
  }
  [[nodiscard]] std::optional<std::size_t> gateway(std::string_view name) const;
  /// Two gateways could carry the same from one network to another.
  [[nodiscard]] bool side_by_side(std::size_t gateway, std::size_t other) const {
    return beside_[(gateway * gateways_.size()) + other];
  }

 private:
  using Names = std::map<std::string, std::size_t, std::less<>>;
  using Words = std::array<std::string_view, 4>;

  [[nodiscard]] std::optional<Key> parse_description(const Words& words, std::size_t count) const;
  [[nodiscard]] std::optional<Key> parse_pair(std::string_view kind, std::string_view name) const;
  [[nodiscard]] std::optional<Key> parse_admission(const Words& words, std::size_t count) const;

  std::string prefix_;
  std::vector<std::string> gateways_, networks_;  ///< encoded
  std::vector<std::string> gateway_names_;
  Names gateway_of_, network_of_;  ///< of encoded ones
  std::vector<bool> beside_;
};

/// A name as it is in a key.
[[nodiscard]] std::string encoded(std::string_view name);
/// 64 hexadecimal digits.
[[nodiscard]] std::string hex_of(std::string_view octets);
template <std::size_t N>
[[nodiscard]] std::string hex_of(const std::array<std::uint8_t, N>& octets) {
  return hex_of(std::string(octets.begin(), octets.end()));
}

}  // namespace mlcca::core::cluster
