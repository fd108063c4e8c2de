// SPDX-License-Identifier: BSD-2-Clause
// What this gateway holds of the networks that it shares with others, and what it counts there
// without holding it: what others hold, and what is reserved and not in use.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/admission/permits.hpp"
#include "core/admission/state.hpp"
#include "core/cluster/baseline.hpp"
#include "core/cluster/view.hpp"

namespace mlcca {

/// Reservations have numbers, those of this gateway and those that it has agreed to.
class SharedNetworks {
 public:
  using Number = std::uint64_t;

  SharedNetworks(const core::System& system, std::size_t self);

  [[nodiscard]] const core::cluster::Baseline& baseline() const { return baseline_; }
  [[nodiscard]] core::Permits& permits() { return permits_; }
  [[nodiscard]] const core::Permits& permits() const { return permits_; }

  /// It may be used from now on. `agreed`: the admissions of this gateway to which the gateways of
  /// the footprint have agreed with it.
  void hold(Number number, const core::cluster::Footprint& footprint,
            const std::vector<core::AdmissionId>& agreed);
  /// The same of what another gateway has reserved, and in its own numbers. The order is the same.
  /// That gateway has agreed, too. `all`: its admissions, also those to which nobody had to agree.
  void carry(Number number, const core::cluster::Footprint& footprint, std::size_t gateway,
             const core::cluster::Footprint& theirs, std::vector<core::AdmissionId> agreed,
             std::vector<core::AdmissionId> all);
  /// It counts as of that gateway, and nobody here uses it.
  void count(Number number, const core::cluster::Footprint& footprint, std::size_t gateway);
  /// Neither any more, as far as this gateway is concerned.
  void drop(Number number);
  [[nodiscard]] bool holds(Number number) const { return held_.contains(number); }
  /// What is held under that number, or counted; null: neither.
  [[nodiscard]] const core::cluster::Footprint* footprint(Number number) const;
  /// What is decided now is decided without that one, which it is to replace, and without whatever
  /// else has the same traffic.
  void leave_out(std::optional<Number> number);

  /// Something is used that lasts as long as the lease.
  [[nodiscard]] bool has_leased() const { return !held_.empty() || has_elected_; }

  /// Others hold something else there.
  void touch(std::size_t network) { stale_.insert(network); }
  void touch_all();
  /// What others have reserved of a network, in their own numbers, without what is decided now.
  [[nodiscard]] core::cluster::Foreign of_others(std::size_t network,
                                                 const core::cluster::View& view) const;
  /// What has changed since goes to the state; settle() is due.
  void put_foreign(core::State& state, const core::cluster::View& view);

 private:
  struct Counted {
    core::cluster::Footprint footprint;
    std::size_t gateway = 0;
  };
  struct Held {
    core::cluster::Footprint footprint;
    std::size_t gateway = 0;          ///< that has reserved it
    core::cluster::Footprint theirs;  ///< in the numbers of that one
  };
  void touch(const core::cluster::Footprint& footprint);
  [[nodiscard]] core::cluster::Foreign foreign(std::size_t network, const core::Members& members,
                                               const core::cluster::View& view) const;
  void add_without_publisher(core::cluster::Foreign& all, std::size_t network,
                             const core::Members& members) const;
  /// What is decided now, as it is reserved, with the gateway that has reserved it; null: nothing
  /// is.
  using Decided = std::pair<const core::cluster::Part*, std::size_t>;
  [[nodiscard]] Decided decided(std::size_t network) const;
  void name_carried(core::cluster::Foreign& all, std::size_t network,
                    const core::Members& members) const;

  std::size_t self_;
  std::size_t networks_;
  core::cluster::Baseline baseline_;
  core::Permits permits_;
  bool has_elected_ = false;
  std::map<Number, Held> held_;
  std::map<Number, Counted> counted_;
  std::optional<Number> left_out_;
  std::set<std::size_t> stale_;
};

}  // namespace mlcca
