// SPDX-License-Identifier: BSD-2-Clause
// What a check of a description admits, and its export to files for other tools.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "core/admission/admission.hpp"
#include "core/model/members.hpp"
#include "core/profiles/profile.hpp"
#include "tools/design/import/lacks.hpp"

namespace mlcca::tools::design {

/// The decisions about a system on which all exports are based.
class Admitted {
 public:
  /// `system` must have sorted bindings and outlive this object.
  explicit Admitted(const core::System& system);

  [[nodiscard]] const core::System& system() const { return system_; }
  [[nodiscard]] const core::Members& members() const { return members_; }
  /// The decision about each channel, in the attribute set in use.
  [[nodiscard]] const std::vector<core::Decision>& decisions() const { return decisions_; }

 private:
  const core::System& system_;
  core::Members members_;
  std::vector<core::Decision> decisions_;
};

/// The text of an export, and what of the description the format cannot express.
struct Exported {
  std::string text;
  Lacks lacks;
};

/// The frames of a publisher on a CAN network that are admitted to a subscriber on it or behind it.
struct AdmittedFrames {
  std::size_t channel = 0;
  std::size_t publisher = 0;
  std::size_t set = 0;
  core::FrameIdentity identity;
  std::string sender;  ///< name of the component, the publisher, or the gateway that forwards
  std::vector<std::string> receivers;  ///< names of the same kinds, without duplicates
};
/// The admitted frames on a network, in the order of channels. What is not admitted there is added
/// to `lacks`.
std::vector<AdmittedFrames> frames_on(const Admitted& admitted, std::size_t network, Lacks& lacks);

/// Adds what kernel rules do not carry over a gateway: refused deliveries, and those that only
/// mlcca-relay can carry.
void list_not_carried(const Admitted& admitted, std::size_t gateway, Lacks& lacks);

/// A DBC file of a CAN network.
Exported export_dbc(const Admitted& admitted, std::size_t network);
/// Shell scripts with rules of can-gw, or with em_canid filters. An error if a port does not state
/// the name of its interface.
Result<Exported> export_can_gw(const Admitted& admitted, std::size_t gateway);
Result<Exported> export_em_canid(const Admitted& admitted, std::size_t number);
/// A Lua script for Wireshark and tshark.
Exported export_wireshark(const Admitted& admitted);

}  // namespace mlcca::tools::design
