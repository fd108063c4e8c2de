// SPDX-License-Identifier: BSD-2-Clause
// What would be right, in words that several findings share.
#pragma once
#include <cstdint>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Of a mesh whose links nobody can know.
inline constexpr const char* kNoLinksHint =
    "add a <Source kind=\"…\"/> to its Mesh, or describe its links";
/// Of a queue of a gateway in which so many frames wait; `why` says whose they are.
[[nodiscard]] std::string queue_hint(std::uint64_t frames, const std::string& why);
/// Of two nodes with one address on a bus.
[[nodiscard]] std::string address_words(const std::string& a, const std::string& b,
                                        std::uint32_t sender, const std::string& network);
/// Of two senders of one identifier on a bus.
[[nodiscard]] std::string sender_hint(Profile profile);

}  // namespace mlcca::core
