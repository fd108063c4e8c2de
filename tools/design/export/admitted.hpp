// SPDX-License-Identifier: BSD-2-Clause
// What a check of a description admits, for files that other tools read.
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

class Admitted {
 public:
  /// `system` has sorted bindings, and must outlive this.
  explicit Admitted(const core::System& system);

  [[nodiscard]] const core::System& system() const { return system_; }
  [[nodiscard]] const core::Members& members() const { return members_; }
  /// Of each channel, in the attribute set that it uses.
  [[nodiscard]] const std::vector<core::Decision>& decisions() const { return decisions_; }

 private:
  const core::System& system_;
  core::Members members_;
  std::vector<core::Decision> decisions_;
};

/// What is written, and what of the description it cannot say.
struct Exported {
  std::string text;
  Lacks lacks;
};

/// A publisher's frames on a CAN network, admitted to somebody behind or on it.
struct AdmittedFrames {
  std::size_t channel = 0;
  std::size_t publisher = 0;
  std::size_t set = 0;
  core::FrameIdentity identity;
  std::string sender;                  ///< component or publisher, or the gateway that forwards
  std::vector<std::string> receivers;  ///< the same, each once
};
/// In the order of the channels. What is not admitted on the network is added to `lacks`.
std::vector<AdmittedFrames> frames_on(const Admitted& admitted, std::size_t network, Lacks& lacks);

/// What rules of the kernel do not carry over a gateway: what is refused, and what crosses by
/// mlcca-relay alone.
void list_not_carried(const Admitted& admitted, std::size_t gateway, Lacks& lacks);

Exported export_dbc(const Admitted& admitted, std::size_t network);
/// Shell scripts. Refused where a port does not state the name of its interface.
Result<Exported> export_can_gw(const Admitted& admitted, std::size_t gateway);
Result<Exported> export_em_canid(const Admitted& admitted, std::size_t number);
/// Lua, for Wireshark and tshark.
Exported export_wireshark(const Admitted& admitted);

}  // namespace mlcca::tools::design
