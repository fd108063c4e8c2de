// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/sha256.hpp"
#include "core/cluster/member.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "daemon/gateway/adopting.hpp"
#include "daemon/gateway/reserving.hpp"
#include "daemon/gateway/shared_networks.hpp"

namespace mlcca {

/// What this gateway has in a cluster with one description. It is made anew for each description.
struct ClusterSession {
  std::string system;    ///< its name, which is that of the cluster
  std::size_t self = 0;  ///< index of this gateway
  Sha256::Digest digest{};
  std::shared_ptr<const core::cluster::Keys> keys;
  std::unique_ptr<cluster::RecordCodec> codec;
  std::unique_ptr<SharedNetworks> networks;
  std::unique_ptr<core::cluster::Member> member;  ///< null until a description is put in force
  std::unique_ptr<Adopting> adopting;
  std::unique_ptr<Reserving> reserving;

  bool joined = false;               ///< whether it has joined with this description
  std::vector<bool> failed;          ///< by gateway: the cluster has elected that it has failed
  std::optional<Value> lapsed_at{};  ///< the gates have closed by themselves, and since then the
                                     ///< store has confirmed no beat
  std::vector<core::cluster::Event> early;  ///< events that came before anything was decided

  /// Whether the gateway can decide; also one that leaves to others what they can carry.
  [[nodiscard]] bool is_there(std::size_t gateway, Value now) const {
    using core::cluster::Alive;
    const Alive alive = member->view().alive(gateway, now);
    return alive == Alive::present || alive == Alive::standby;
  }
};

}  // namespace mlcca
