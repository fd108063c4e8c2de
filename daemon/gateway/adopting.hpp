// SPDX-License-Identifier: BSD-2-Clause
// Admissions of other gateways that go over this one: it agrees to them or not, and carries them
// while they last. They are not this gateway's to release, and not in its journal.
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

  /// What is done with the admissions themselves. With everything settled.
  struct Hands {
    /// Why it would not fit; empty: it would.
    std::function<std::string(const control::Request&)> misfit;
    std::function<Result<void>(const control::Request&)> admit;
    std::function<void(const std::vector<core::AdmissionId>&)> remove;
    /// Into a description that is not decided yet.
    std::function<void(const control::Request&)> restore;
    std::function<core::AdmissionId()> new_id;
    std::function<Number()> new_number;
    std::function<void()> bring_in_line;
  };
  Adopting(SharedNetworks& networks, Hands hands) : networks_(networks), hands_(std::move(hands)) {}

  void on(const core::cluster::Adopt& event);
  void on(const core::cluster::Opened& event);
  void on(const core::cluster::Ended& event);
  void lost();
  /// The same where their state is gone already.
  void forget() { adopted_.clear(); }
  /// True: something was done.
  bool step(core::cluster::Member& member, Value now);
  /// Those that are carried, into another state of the same description.
  void restore() const;
  [[nodiscard]] bool has(core::AdmissionId id) const;

 private:
  using Key = std::pair<std::size_t, std::uint64_t>;  ///< gateway and number of its own
  enum class Due : std::uint8_t { nothing, vote, open };
  struct Adopted {
    core::cluster::Origin origin;
    core::cluster::Footprint footprint;
    std::optional<cluster::Asked> asked;
    Number number = 0;
    std::vector<control::Request> ours;     ///< with numbers of this gateway
    std::vector<core::AdmissionId> theirs;  ///< of the same, with numbers of the other one
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
