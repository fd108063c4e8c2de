// SPDX-License-Identifier: BSD-2-Clause
// Names entries of the store that are not understood, why that is, and what an operator can do.
// Keys come from outside, so they are shortened and escaped.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "core/cluster/records.hpp"

namespace mlcca::core::cluster {

/// The most octets of a key that are shown.
inline constexpr std::size_t kMostShownKey = 256;

/// A key with everything but plain ASCII escaped as \xNN, and "..." where it was longer than
/// kMostShownKey.
[[nodiscard]] std::string shown_key(std::string_view key);

/// Names the first entry that makes it unknown what others hold of the network, and how many more
/// there are. Empty if all can be read.
[[nodiscard]] std::string unreadable_words(const Records& records, const Keys& keys,
                                           std::size_t network);
/// The same of entries that hold nothing of a network: beats, requests, votes and descriptions.
[[nodiscard]] std::string unreadable_words(const Records& records, const Keys& keys);
/// Which limit the entries exceed, whose most of them are, and what to do; empty if none.
[[nodiscard]] std::string too_many_words(const Records& records, const Keys& keys);

}  // namespace mlcca::core::cluster
