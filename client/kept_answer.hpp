// SPDX-License-Identifier: BSD-2-Clause
// An answer in compact form.
#pragma once
#include <memory>
#include <string>

#include "mlcca/client/client.hpp"

namespace mlcca::client {

/// Keeps the answer of a channel in a few hundred bytes until a program asks for it. Each
/// comparison of an Answer has four strings, and a program may have thousands of channels.
class KeptAnswer {
 public:
  KeptAnswer() = default;
  explicit KeptAnswer(const std::shared_ptr<const Answer>& answer);

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] std::shared_ptr<const Answer> get() const;

 private:
  State state_ = State::unannounced;
  std::string reason_;      ///< empty if it is the reason of a delivery
  std::string deliveries_;  ///< encoded as a Reply of the control protocol
};

}  // namespace mlcca::client
