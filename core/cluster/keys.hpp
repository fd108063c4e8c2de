// SPDX-License-Identifier: BSD-2-Clause
// The keys of a cluster in the store (docs/reference/cluster-store.md), and to whom they belong.
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

/// A key that was understood. Parts that the kind does not have are 0.
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
  std::size_t gateway = 0;  ///< the gateway that writes it; of a fence the fenced one
  std::size_t from = 0;     ///< of a vote: the gateway that asks
  std::uint64_t id = 0;     ///< of an admission: its number; of a blob: the number of the chunk
  std::string digest = {};  ///< of a blob, in hexadecimal digits
  bool operator==(const Key&) const = default;
};

/// A key of a gateway that the description does not contain, left by a former description.
struct LeftKey {
  Key::Kind kind = Key::Kind::member;  ///< member, fence, reservation, asked, vote or rollout_vote
  std::string_view gateway;            ///< encoded
  std::optional<std::size_t> network = std::nullopt;
  std::optional<std::size_t> voter = std::nullopt;  ///< the gateway that has written a vote on its
                                                    ///< request
};

/// Builds and parses the keys of one cluster. Names are percent-encoded outside [A-Za-z0-9._-], so
/// that each key has exactly one reading.
class Keys {
 public:
  /// `prefix` is empty or ends with '/'.
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

  /// Parses a key. Nullopt if it is not a key of this cluster, or names a gateway or network that
  /// the description does not contain.
  [[nodiscard]] std::optional<Key> parse(std::string_view key) const;
  /// Parses a key of a gateway that the description does not contain; nullopt for any other.
  [[nodiscard]] std::optional<LeftKey> parse_left(std::string_view key) const;
  /// Whether `gateway` has written this key about a network that the description does not contain.
  [[nodiscard]] bool is_of_removed_network(std::string_view key, std::size_t gateway) const;
  /// For a key that parse() does not understand: the gateway that may write it, where it is one of
  /// a reservation.
  [[nodiscard]] std::optional<std::size_t> writer_of(std::string_view key) const;
  /// For a key that parse() does not understand: the network of which it may reserve something.
  [[nodiscard]] std::optional<std::size_t> network_of(std::string_view key) const;

  [[nodiscard]] std::size_t gateways() const { return gateways_.size(); }
  [[nodiscard]] std::size_t networks() const { return networks_.size(); }
  /// The name as it is in the description.
  [[nodiscard]] const std::string& gateway_name(std::size_t gateway) const {
    return gateway_names_[gateway];
  }
  /// The gateway with that name of the description; nullopt if there is none.
  [[nodiscard]] std::optional<std::size_t> gateway(std::string_view name) const;
  /// Whether the two gateways share two networks, so that either could carry events between them.
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
  Names gateway_of_, network_of_;  ///< by encoded name
  std::vector<bool> beside_;
};

/// The percent-encoded form of a name in a key.
[[nodiscard]] std::string encoded(std::string_view name);
/// The octets as hexadecimal digits, 64 for a digest.
[[nodiscard]] std::string hex_of(std::string_view octets);
template <std::size_t N>
[[nodiscard]] std::string hex_of(const std::array<std::uint8_t, N>& octets) {
  return hex_of(std::string(octets.begin(), octets.end()));
}

}  // namespace mlcca::core::cluster
