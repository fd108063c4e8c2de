// SPDX-License-Identifier: BSD-2-Clause
// Texts of hints that several findings share.
#pragma once
#include <cstdint>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::core {

/// For a mesh whose links cannot be known.
inline constexpr const char* kNoLinksHint =
    "add a <Source kind=\"…\"/> to its Mesh, or describe its links";
/// For a queue of a gateway in which so many frames wait; `why` names whose they are.
[[nodiscard]] std::string queue_hint(std::uint64_t frames, const std::string& why);
/// For two nodes with the same address on a bus.
[[nodiscard]] std::string address_words(const std::string& a, const std::string& b,
                                        std::uint32_t sender, const std::string& network);
/// For two senders of one identifier on a bus.
[[nodiscard]] std::string sender_hint(Profile profile);

}  // namespace mlcca::core
