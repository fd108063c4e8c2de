// SPDX-License-Identifier: BSD-2-Clause
// A socket by which a frame can be sent on any CAN interface, and that receives none. The unit of
// mlccad lets it open no such socket: mlcca-can@.service opens one and hands it over.
#pragma once
#include <linux/can.h>

#include <cstdint>
#include <string>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/outside/can_sender.hpp"

namespace mlcca::net {

class CanSocket final : public CanSender {
 public:
  /// `helper`: where mlcca-can is reached.
  explicit CanSocket(std::string helper = "/run/mlcca/can") : helper_(std::move(helper)) {}

  /// False: mlcca-can has been asked for a socket and has not answered yet.
  bool send(std::uint32_t ifindex, const can_frame& frame) override;
  [[nodiscard]] const std::string& problem() const override { return problem_; }

 private:
  enum class State : std::uint8_t { ready, awaited, missing };
  State find_socket();
  State note_missing(std::string why);

  std::string helper_;
  Fd way_;     ///< to mlcca-can, which has been asked
  Fd socket_;  ///< nothing: not yet
  std::string problem_;
};

/// What another process hands over is of CAN, and receives nothing from here on.
Result<void> make_sender(const Fd& socket);

}  // namespace mlcca::net
