// SPDX-License-Identifier: BSD-2-Clause
// A socket that sends frames on any CAN interface, and receives none. The unit of mlccad may not
// open such a socket, so mlcca-can@.service opens it and passes it on.
#pragma once
#include <linux/can.h>

#include <cstdint>
#include <string>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/outside/can_sender.hpp"

namespace mlcca::net {

/// Gets the socket from mlcca-can when a frame is first sent, without waiting.
class CanSocket final : public CanSender {
 public:
  /// `helper` is the path of the socket of mlcca-can.
  explicit CanSocket(std::string helper = "/run/mlcca/can") : helper_(std::move(helper)) {}

  /// False: mlcca-can was asked for a socket and has not answered yet.
  bool send(std::uint32_t ifindex, const can_frame& frame) override;
  [[nodiscard]] const std::string& problem() const override { return problem_; }

 private:
  enum class State : std::uint8_t { ready, awaited, missing };
  State find_socket();
  State note_missing(std::string why);

  std::string helper_;
  Fd way_;     ///< the connection to mlcca-can, which was asked
  Fd socket_;  ///< empty until it was received
  std::string problem_;
};

/// Checks that a socket from another process is a raw CAN socket, and sets it to receive nothing.
Result<void> make_sender(const Fd& socket);

}  // namespace mlcca::net
