// SPDX-License-Identifier: BSD-2-Clause
// Finds refused messages that may be sent all the same, because no gate is between a publisher and
// its own bus (MLCCA044).
#pragma once
#include <cstddef>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/design/bus_messages.hpp"
#include "core/design/findings.hpp"
#include "core/model/members.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// Collects final verdicts, then reports the buses on which granted messages could become late.
class RefusedOnBus {
 public:
  /// Adds a final verdict.
  void add(const Verdict& verdict);
  /// Reports each analysed bus on which a granted or contested message would be late if refused
  /// messages of that bus are sent, or may be because their load is unknown. Call it when
  /// everything is decided. `contested`: messages that may be granted in the place of others.
  void report(const System& system, const Members& members, const Ledger& ledger,
              std::span<const BusMessage> contested, std::vector<Finding>& to) const;

 private:
  /// `contested`: those of this bus, with their keys.
  void report(const System& system, const Members& members, const can::Schedule& bus,
              std::size_t network, std::span<const can::Message> contested,
              std::vector<Finding>& to) const;
  void add(const Members& members, const std::vector<std::size_t>& senders, std::size_t network,
           const std::string& harm, std::vector<Finding>& to) const;

  std::set<std::size_t> granted_;  ///< publishers granted to somebody, whose frames are on the bus
  std::map<std::size_t, std::size_t> refused_{};  ///< refused publishers with their attribute sets
  std::set<std::size_t> perhaps_;  ///< those of them about which the run time decides
};

}  // namespace mlcca::core
