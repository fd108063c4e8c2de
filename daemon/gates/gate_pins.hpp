// SPDX-License-Identifier: BSD-2-Clause
// The names of what is pinned for one gate. What replaces it has next names until it is attached:
// the gate that is in force has its own, or, after a crash in between, is found by what is
// attached.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::enforce {

/// In the directory of Control.
inline std::string gate_directory(const std::string& directory, std::uint32_t ifindex) {
  return directory + "/if" + std::to_string(ifindex);
}
inline std::string program_pin(const std::string& directory, Direction direction) {
  return directory + "/" + to_text(direction);
}
inline std::string next_of(const std::string& pin) { return pin + "_next"; }
inline std::string next_pin(const std::string& directory, Direction direction) {
  return next_of(program_pin(directory, direction));
}
inline std::string early_pin(const std::string& directory) { return directory + "/early"; }
inline constexpr const char* kTablePin = "table";
inline constexpr const char* kCpusPin = "cpus";
inline std::string table_pin(const std::string& directory) { return directory + "/" + kTablePin; }
inline std::string silence_timers_pin(const std::string& directory) {
  return directory + "/silence_timers";
}
inline std::string cpus_pin(const std::string& directory) { return directory + "/" + kCpusPin; }

using MapIds = std::vector<std::uint32_t>;
/// The maps of each program of ours that is pinned there and attached to this very device; those of
/// a gate that a crash kept from getting its own names come first.
Result<std::vector<MapIds>> maps_of_attached(const std::string& directory, std::uint32_t ifindex);
/// The one of these maps that has the name, or its next name, which becomes its own; or none.
Fd take_map(const std::string& path, const MapIds& ids);

/// Gives each object the next name of its pin, unless it has its own.
Result<void> pin_as_next(std::span<const Pin> pins);
/// After that: each gets its own name, instead of what has it.
Result<void> name_next(std::span<const Pin> pins);
/// What was to be next and is not attached loses its names.
void forget_next(const std::string& directory);

}  // namespace mlcca::enforce
