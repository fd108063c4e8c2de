// SPDX-License-Identifier: BSD-2-Clause
// Random valid descriptions with a fixed seed: small systems in which values are often equal, or
// differ by the last digit that counts.
#pragma once
#include <cstdint>
#include <string>

namespace mlcca::testing {

/// The text of one System. Whoever subscribes sits where a declared route, or nothing but their own
/// network, connects it to every publisher of the channel.
///
/// Not in it is what an XSLT check does not decide as the C++ one: several attribute sets,
/// connections that are not declared, channels without a binding, publishers without a FAMOUSO node
/// where one is crossed, and losses of events of several frames other than 0 and 1.
std::string random_description(std::uint64_t seed);

}  // namespace mlcca::testing
