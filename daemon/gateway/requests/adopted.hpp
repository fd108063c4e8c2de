// SPDX-License-Identifier: BSD-2-Clause
// The operations of Adopting on admissions of other gateways that cross this one.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/reserving.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {
class Admissions;
class CanForwarding;
class DeliveryEvents;
class GateDriver;
class Membership;
class Recorder;
class TagBindings;
class Turn;
}  // namespace mlcca

namespace mlcca::requests {

/// The parts of a gateway that these operations use. All outlive them.
struct AdoptedParts {
  const Scene& scene;
  Recorder& recorder;
  const Admissions& admissions;
  GateDriver& gates;
  Turn& turn;
  TagBindings& tags;
  CanForwarding& forwarding;
  DeliveryEvents& deliveries;
  const Membership& membership;
};

/// Why the admission would not fit with everything reserved that it needs, also one that is there
/// already; empty if it would.
[[nodiscard]] std::string misfit_of_adopted(const AdoptedParts& parts,
                                            const control::Request& request);
/// What to reserve for a subscriber that another gateway has asked this one to admit. The error
/// says why it does not fit.
[[nodiscard]] Result<Reserving::Wish> wish_for_another(const AdoptedParts& parts,
                                                       const control::Request& request,
                                                       std::size_t gateway);
/// Whether nobody publishes any more what that subscriber was admitted for.
[[nodiscard]] bool is_without_publisher(const AdoptedParts& parts, const control::Request& request);
/// Whether that is for good: no admission of this gateway brings such a publisher, not even one for
/// which the description has no place now.
[[nodiscard]] bool is_publisher_gone(const AdoptedParts& parts, const control::Request& request);
/// Adds the admission to state and gates, if it is not there. The error says why nothing was
/// changed.
Result<void> admit_adopted(const AdoptedParts& parts, const control::Request& request);
/// Adds the admission to the state, whether it fits or not: its publisher is needed. Settling has
/// to follow. The error says why nothing was changed.
Result<void> take_in_adopted(const AdoptedParts& parts, const control::Request& request);
void remove_adopted(const AdoptedParts& parts, const std::vector<core::AdmissionId>& gone);
/// Adds the admission to a state that is not decided yet. What has no place there is left out.
void restore_adopted(core::State& state, const control::Request& request);

}  // namespace mlcca::requests
