// SPDX-License-Identifier: BSD-2-Clause
// The operations on admissions of other gateways that cross this one.
#pragma once
#include <cstddef>
#include <expected>
#include <memory>
#include <set>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/adopted_admissions.hpp"
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

/// What this gateway decides about them, and how it carries them.
class AdmissionsOfOthers final : public AdoptedAdmissions {
 public:
  /// All references must outlive this object.
  struct Parts {
    const Scene& scene;
    Recorder& recorder;
    const Admissions& admissions;
    GateDriver& gates;
    Turn& turn;
    TagBindings& tags;
    CanForwarding& forwarding;
    DeliveryEvents& deliveries;
    const std::unique_ptr<Membership>& membership;  ///< set before the first call
  };
  explicit AdmissionsOfOthers(const Parts& parts) : parts_(parts) {}

  [[nodiscard]] Reserving::Refusal misfit(const control::Request& request) override;
  Result<void> admit(const control::Request& request) override;
  Result<void> take_in(const control::Request& request) override;
  void remove(const std::vector<core::AdmissionId>& gone) override;
  void restore(const control::Request& request) override;
  [[nodiscard]] std::expected<Reserving::Wish, Reserving::Refusal> wish(
      const control::Request& request, std::size_t gateway) override;
  [[nodiscard]] std::set<core::AdmissionId> not_granted(
      const std::set<std::size_t>& channels) override;
  [[nodiscard]] bool is_without_publisher(const control::Request& request) override;
  [[nodiscard]] bool is_publisher_gone(const control::Request& request) override;

 private:
  [[nodiscard]] Reserving::Refusal misfit_of_present(core::AdmissionId id,
                                                     std::size_t channel) const;

  Parts parts_;
};

}  // namespace mlcca::requests
