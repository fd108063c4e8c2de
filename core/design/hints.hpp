// SPDX-License-Identifier: BSD-2-Clause
// What would be right, in words that several findings share.
#pragma once
#include <cstdint>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Of a queue of a gateway in which so many frames wait; `why` says whose they are.
[[nodiscard]] std::string queue_hint(std::uint64_t frames, const std::string& why);
/// Of two senders of one identifier on a bus.
[[nodiscard]] std::string sender_hint(Profile profile);

}  // namespace mlcca::core
