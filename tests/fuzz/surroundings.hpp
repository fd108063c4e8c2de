// SPDX-License-Identifier: BSD-2-Clause
// What a gateway under test lives in: interfaces and a bpffs in namespaces of its own, a folder in
// memory, the descriptions that it may be given, and users who connect.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/handle.hpp"

namespace mlcca::fuzz {

inline constexpr gid_t kGroup = 4242;  ///< whose members may change something

struct Surroundings {
  std::string bpf_root;
  std::string folder;  ///< gone with the process
  Fd can;
};

/// Made by the first call, which needs root.
const Surroundings& surroundings();

inline constexpr std::size_t kDescriptions = 4;
inline constexpr std::size_t kUnreadable = 3;

/// Of gateway "gate", lan and bus. c1 is described with both ends (or one, or its subscriber
/// elsewhere), c2 has a subscriber, c3 and c4 have no endpoint, c5 a local publisher.
std::string description(std::size_t number);

enum class User : std::uint8_t { root, member, outsider };

Fd connected(const std::string& path, User user);

}  // namespace mlcca::fuzz
