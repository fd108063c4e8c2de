// SPDX-License-Identifier: BSD-2-Clause
// The names of what is pinned for one gate.
#pragma once
#include <cstdint>
#include <string>

#include "daemon/gates/slots.hpp"

namespace mlcca::enforce {

/// In the directory of Control.
inline std::string gate_directory(const std::string& directory, std::uint32_t ifindex) {
  return directory + "/if" + std::to_string(ifindex);
}
inline std::string program_pin(const std::string& directory, Direction direction) {
  return directory + (direction == Direction::ingress ? "/ingress" : "/egress");
}
inline std::string next_pin(const std::string& directory, Direction direction) {
  return program_pin(directory, direction) + "_next";
}
inline std::string early_pin(const std::string& directory) { return directory + "/early"; }
inline std::string table_pin(const std::string& directory) { return directory + "/table"; }
inline std::string watchmen_pin(const std::string& directory) { return directory + "/watchmen"; }
inline std::string cpus_pin(const std::string& directory) { return directory + "/cpus"; }

}  // namespace mlcca::enforce
