// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/admission/holders.hpp"
#include "core/admission/world.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// Names the gateways that hold what others cannot have: for texts, not for decisions.
class HeldByOthers {
 public:
  /// All must outlive this.
  HeldByOthers(const System& system, const World& world, const Ledger& ledger)
      : system_(system), world_(world), ledger_(ledger) {}

  /// From where it is known who holds what; it must outlive this. Null: nobody is named.
  void set_source(const Holdings* holdings) {
    holdings_ = holdings;
    known_.clear();
  }
  /// To be called when the condition of a network, or what others hold of it, is another one.
  void forget(std::size_t network) { known_.erase(network); }

  /// What other gateways have reserved of a network; nothing without set_source().
  [[nodiscard]] const std::vector<HeldBy>& of(std::size_t network) const;
  /// If other gateways have reserved more of a network than it has: how much, and who they are.
  /// Empty otherwise.
  [[nodiscard]] std::string excess(std::size_t network) const;
  /// Of a refusal for want of room on a shared network: which gateways hold it, as the end of the
  /// line that reason() gives. Empty for all others, and where nobody holds anything.
  [[nodiscard]] std::string of_refusal(const Verdict& verdict) const;
  /// Of a delivery that is not reserved, or to which other gateways have not agreed: which of them
  /// does not carry it, and why; see Holdings::objection().
  [[nodiscard]] std::string objection_to(const Verdict& verdict) const;

 private:
  /// What of() has found, as long as that lasts.
  struct Known {
    std::shared_ptr<const MeshView> view;
    std::vector<HeldBy> by;
  };
  [[nodiscard]] std::string why_unknown(std::size_t network) const;

  const System& system_;
  const World& world_;
  const Ledger& ledger_;
  const Holdings* holdings_ = nullptr;
  mutable std::map<std::size_t, Known> known_;  ///< a cache, by network
};

}  // namespace mlcca::core
