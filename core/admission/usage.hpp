// SPDX-License-Identifier: BSD-2-Clause
// Index from resources (a network or gateway, System::resource_of) to channels: which channels a
// change of a resource affects.
#pragma once
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/admission/admission.hpp"

namespace mlcca::core {

/// Keeps, for all channels, the resources that carry them, those that they wait for, and the
/// numbers of granted and refused deliveries.
class Usage {
 public:
  using Channels = std::unordered_set<std::size_t>;
  using NodePair = std::pair<std::uint32_t, std::uint32_t>;

  explicit Usage(const System& system)
      : of_channel_(system.channels.size()),
        carried_(system.resources()),
        pairs_(system.networks.size()),
        waiting_(system.resources()) {}

  /// Replaces what is known of a channel by its present decision.
  void set(const Situation& situation, std::size_t channel, const Decision& decision);

  /// Channels with a granted delivery over the resource.
  [[nodiscard]] const Channels& carried_by(std::size_t resource) const {
    return carried_[resource];
  }
  /// Channels with a granted delivery from one mesh node to another, by network. The key is the
  /// pair, see pair_of().
  [[nodiscard]] const std::unordered_map<std::uint64_t, Channels>& pairs_of(
      std::size_t network) const {
    return pairs_[network];
  }
  /// The (network, node pair) entries of a channel.
  [[nodiscard]] const std::vector<std::pair<std::size_t, std::uint64_t>>& pairs_of_channel(
      std::size_t channel) const {
    return of_channel_[channel].pairs;
  }
  [[nodiscard]] static NodePair pair_of(std::uint64_t key) {
    return {static_cast<std::uint32_t>(key >> 32U), static_cast<std::uint32_t>(key)};
  }
  /// Channels that could be granted more and have a possible route over the resource.
  [[nodiscard]] const Channels& waiting_for(std::size_t resource) const {
    return waiting_[resource];
  }
  /// Channels with a granted delivery that does not take the first of its possible routes.
  [[nodiscard]] const Channels& detours() const { return detours_; }
  /// Numbers of granted and of refused deliveries, of all channels.
  [[nodiscard]] std::size_t granted() const { return granted_; }
  [[nodiscard]] std::size_t refused() const { return refused_; }
  /// Resources that carry a granted delivery of the channel.
  [[nodiscard]] const std::vector<std::size_t>& resources_of(std::size_t channel) const {
    return of_channel_[channel].carried;
  }

 private:
  struct OfChannel {
    std::vector<std::size_t> carried;
    std::vector<std::pair<std::size_t, std::uint64_t>> pairs;
    std::vector<std::size_t> waiting;
    bool detour = false;
    std::size_t granted = 0;
    std::size_t refused = 0;
    bool operator==(const OfChannel&) const = default;
  };
  static OfChannel use_of(const Situation& situation, const Decision& decision);
  void forget(std::size_t channel);

  std::vector<OfChannel> of_channel_;
  std::vector<Channels> carried_;
  std::vector<std::unordered_map<std::uint64_t, Channels>> pairs_;
  std::vector<Channels> waiting_;
  Channels detours_;
  std::size_t granted_ = 0;
  std::size_t refused_ = 0;
};

}  // namespace mlcca::core
