// SPDX-License-Identifier: BSD-2-Clause
// Explains verdicts as findings: for each publisher and subscriber what does not fit, where, by how
// much, who required it, and what would be right.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/admission/route_check.hpp"
#include "core/design/findings.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// Adds findings for verdicts to a list.
class Explainer {
 public:
  /// The ledger is used to try things out and left unchanged. All arguments must outlive this.
  Explainer(const Situation& situation, Ledger& ledger, std::vector<Finding>& findings)
      : s_(situation), ledger_(ledger), findings_(findings) {}

  /// Adds nothing for a fit verdict, and a note for one that is decided at run time.
  void add(const Verdict& verdict);
  /// Adds a note that a lower attribute set is used (or would be, depending on the run time);
  /// nothing for the preferred one.
  void add_lower_set(std::size_t channel, std::size_t set, Outcome outcome);
  /// Adds a note that the run time decides which attribute set is used.
  void add_open_set(std::size_t channel);

 private:
  void add_obstacle(const Verdict& v);
  void add_run_time(const Verdict& v);
  /// What becomes known of a CAN hop at run time only, as texts.
  [[nodiscard]] std::vector<std::string> open_on_bus(const Verdict& v, Place hop) const;
  void add_pair(const Verdict& v, std::size_t subscriber);
  void add_row(const Verdict& v, const Row& row, std::size_t subscriber);
  [[nodiscard]] bool is_left_open(const Row& row) const;
  void add_capacity(const Verdict& v, const Row& row);
  void add_medium(const Verdict& v, const Row& row);
  Finding& new_finding(FindingId id, const Verdict& v);
  Finding& new_finding(FindingId id, std::size_t channel);

  const Situation& s_;
  Ledger& ledger_;
  std::vector<Finding>& findings_;
};

}  // namespace mlcca::core
