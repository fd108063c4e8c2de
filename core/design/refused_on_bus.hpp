// SPDX-License-Identifier: BSD-2-Clause
// What is refused and yet may be sent: no gate lies between a publisher and the bus that it is on.
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

class RefusedOnBus {
 public:
  /// A verdict as it was decided in the end.
  void add(const Verdict& verdict);
  /// MLCCA044 of each analysed bus where something that is granted, or may be, would be late if
  /// what is refused there is sent all the same, or may be because nobody knows how much that is.
  /// When everything is decided. `contested`: messages on buses that may be granted in the place of
  /// others.
  void report(const System& system, const Members& members, const Ledger& ledger,
              std::span<const BusMessage> contested, std::vector<Finding>& to) const;

 private:
  /// `contested`: of this bus, with their keys.
  void report(const System& system, const Members& members, const can::Schedule& bus,
              std::size_t network, std::span<const can::Message> contested,
              std::vector<Finding>& to) const;
  void add(const Members& members, const std::vector<std::size_t>& senders, std::size_t network,
           const std::string& harm, std::vector<Finding>& to) const;

  std::set<std::size_t> granted_;  ///< publishers to somebody: the bus has their frames
  std::map<std::size_t, std::size_t> refused_{};  ///< publishers, with their attribute sets
  std::set<std::size_t> perhaps_;                 ///< those of them that the run time decides about
};

}  // namespace mlcca::core
