// SPDX-License-Identifier: BSD-2-Clause
// What a gateway polls once a second, in rounds of short jobs.
#pragma once
#include "daemon/gateway/gateway_parts.hpp"
#include "daemon/gateway/rounds.hpp"

namespace mlcca {

class PeriodicJobs {
 public:
  explicit PeriodicJobs(GatewayParts& parts);

  /// Begins a round. If one is under way, that one continues.
  void begin_round() { rounds_.begin(); }
  [[nodiscard]] bool has_work() const { return rounds_.under_way(); }
  /// Does a part of the round.
  void work() { rounds_.turn(); }

 private:
  void poll_surroundings();
  bool repair_next();
  bool poll_next_bypass();
  bool write_some_history();

  GatewayParts& parts_;
  Rounds rounds_;
  int repaired_ = 0;  ///< ifindex of the gate that was repaired last in this round; 0: none
  int checked_ = 0;   ///< ifindex of the gate that was checked last for ways round it; 0: none
  /// The latest round had more than one slice of history to write.
  bool writes_much_history_ = false;
};

}  // namespace mlcca
