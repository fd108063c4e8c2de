// SPDX-License-Identifier: BSD-2-Clause
// Handles admissions that other gateways of the cluster have made and whose route crosses this
// gateway. This gateway votes on them, and carries them until they end. They are not in its
// journal, and it cannot release them.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "core/admission/state.hpp"
#include "core/cluster/member.hpp"
#include "daemon/cluster/codec.hpp"
#include "daemon/gateway/shared_networks.hpp"

namespace mlcca {

class Adopting {
 public:
  using Number = SharedNetworks::Number;

  /// The operations on the admissions themselves, which the caller provides. They are called when
  /// all decisions are settled.
  struct Hands {
    /// Why a request does not fit; empty if it fits.
    std::function<std::string(const control::Request&)> misfit;
    std::function<Result<void>(const control::Request&)> admit;
    std::function<void(const std::vector<core::AdmissionId>&)> remove;
    /// Adds the request to the state of a description that is not decided yet.
    std::function<void(const control::Request&)> restore;
    std::function<core::AdmissionId()> new_id;
    std::function<Number()> new_number;
    std::function<void()> bring_in_line;
  };
  Adopting(SharedNetworks& networks, Hands hands) : networks_(networks), hands_(std::move(hands)) {}

  void on(const core::cluster::Adopt& event);
  void on(const core::cluster::Opened& event);
  void on(const core::cluster::Ended& event);
  /// The connection to the store is lost: everything that was adopted is closed and no longer
  /// counted.
  void lost();
  /// Forgets everything without closing it, where the state that held it is gone already.
  void forget() { adopted_.clear(); }
  /// Votes on and opens what is due. True if anything was done.
  bool step(core::cluster::Member& member, Value now);
  /// Adds the open admissions to another state of the same description.
  void restore() const;
  [[nodiscard]] bool has(core::AdmissionId id) const;

 private:
  using Key = std::pair<std::size_t, std::uint64_t>;  ///< gateway, and its own number
  enum class Due : std::uint8_t { nothing, vote, open };
  struct Adopted {
    core::cluster::Origin origin;
    core::cluster::Footprint footprint;
    std::optional<cluster::Asked> asked;
    Number number = 0;
    std::vector<control::Request> ours;  ///< the requests, with admission numbers of this gateway
    std::vector<core::AdmissionId> theirs;  ///< numbers of the same requests at the other gateway
    Due due = Due::vote;
    bool open = false;
  };

  [[nodiscard]] std::optional<core::AdmissionId> ours_of(std::size_t gateway,
                                                         core::AdmissionId theirs) const;
  void name_requests(Adopted& adopted, const std::vector<control::Request>& requests) const;
  [[nodiscard]] std::string misfit(const Adopted& adopted) const;
  [[nodiscard]] std::string misfit(const Adopted& adopted, std::size_t request) const;
  [[nodiscard]] std::optional<core::cluster::Footprint> mapped(const Adopted& adopted) const;
  [[nodiscard]] std::string open(Adopted& adopted);
  void close(Adopted& adopted) const;
  void vote(Adopted& adopted, core::cluster::Member& member, Value now);

  SharedNetworks& networks_;
  Hands hands_;
  std::map<Key, Adopted> adopted_;
};

}  // namespace mlcca
