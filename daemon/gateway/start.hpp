// SPDX-License-Identifier: BSD-2-Clause
// The start of a gateway: what was granted goes on while the daemon reads what it needs.
#pragma once
#include <optional>

#include "base/result.hpp"
#include "daemon/gateway/gateway_parts.hpp"

namespace mlcca {

class Start {
 public:
  explicit Start(GatewayParts& parts) : parts_(parts) {}

  /// See Controller::start().
  std::optional<StartError> run();
  /// The description was not read in time, and the thread that reads it does not end.
  [[nodiscard]] bool reads_for_ever() const { return reads_for_ever_; }

 private:
  std::optional<StartError> begin_start();
  std::optional<StartError> read_what_was();
  std::optional<StartError> open_gates();
  Result<void> forget_former_limit();

  GatewayParts& parts_;
  bool reads_for_ever_ = false;
};

}  // namespace mlcca
