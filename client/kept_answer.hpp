// SPDX-License-Identifier: BSD-2-Clause
// An answer that nobody has asked for yet, in a few hundred octets: its comparisons have four texts
// each, and a program may have thousands of channels.
#pragma once
#include <memory>
#include <string>

#include "mlcca/client/client.hpp"

namespace mlcca::client {

class KeptAnswer {
 public:
  KeptAnswer() = default;
  explicit KeptAnswer(const std::shared_ptr<const Answer>& answer);

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] std::shared_ptr<const Answer> get() const;

 private:
  State state_ = State::unannounced;
  std::string reason_;      ///< empty where it is that of a delivery
  std::string deliveries_;  ///< as the control protocol has them
};

}  // namespace mlcca::client
