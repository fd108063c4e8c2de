// SPDX-License-Identifier: BSD-2-Clause
// The program of this gateway that receives and sends subscriptions on networks of FAMOUSO.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/model/system.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca::requests {

/// The ports of this gateway whose networks accept subscriptions.
[[nodiscard]] std::vector<std::size_t> subscription_ports(const Scene& scene);
/// The port on a network, if the user may send its control traffic. The error says what is missing.
[[nodiscard]] Result<std::size_t> subscription_port(const Scene& scene, uid_t user,
                                                    const std::string& network);

/// The user whose programs may send it, in words: "user 991, the control-user of its Port".
[[nodiscard]] std::string control_user_of(const core::Port& port);

}  // namespace mlcca::requests
