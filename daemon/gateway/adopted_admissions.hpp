// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <expected>
#include <set>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/reserving.hpp"

namespace mlcca {

/// The operations on admissions that other gateways have made and that cross this one: what is
/// decided about them here, and what follows for state and gates. They are called when all
/// decisions are settled. `requests` have numbers of this gateway.
class AdoptedAdmissions {
 public:
  AdoptedAdmissions() = default;
  AdoptedAdmissions(const AdoptedAdmissions&) = delete;
  AdoptedAdmissions& operator=(const AdoptedAdmissions&) = delete;
  AdoptedAdmissions(AdoptedAdmissions&&) = delete;
  AdoptedAdmissions& operator=(AdoptedAdmissions&&) = delete;
  virtual ~AdoptedAdmissions() = default;

  /// Why the admission would not fit with everything reserved that it needs, also one that is there
  /// already; empty if it would.
  [[nodiscard]] virtual Reserving::Refusal misfit(const control::Request& request) = 0;
  /// Adds the admission to state and gates, if it is not there. The error says why nothing was
  /// changed.
  virtual Result<void> admit(const control::Request& request) = 0;
  /// Adds the admission to the state, whether it fits or not: its publisher is needed. Settling has
  /// to follow. The error says why nothing was changed.
  virtual Result<void> take_in(const control::Request& request) = 0;
  virtual void remove(const std::vector<core::AdmissionId>& gone) = 0;
  /// Adds the admission to a state that is not decided yet. What has no place there is left out.
  virtual void restore(const control::Request& request) = 0;
  /// What to reserve for a subscriber that another gateway has asked this one to admit. The error
  /// says why it does not fit.
  [[nodiscard]] virtual std::expected<Reserving::Wish, Reserving::Refusal> wish(
      const control::Request& request, std::size_t gateway) = 0;
  /// The admissions of publishers and subscribers of which a delivery of these channels is not
  /// granted.
  [[nodiscard]] virtual std::set<core::AdmissionId> not_granted(
      const std::set<std::size_t>& channels) = 0;
  /// Whether nobody publishes any more what that subscriber was admitted for.
  [[nodiscard]] virtual bool is_without_publisher(const control::Request& request) = 0;
  /// Whether that is for good: no admission of this gateway brings such a publisher, not even one
  /// for which the description has no place now.
  [[nodiscard]] virtual bool is_publisher_gone(const control::Request& request) = 0;
};

}  // namespace mlcca
