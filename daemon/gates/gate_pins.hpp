// SPDX-License-Identifier: BSD-2-Clause
// The names of the pins of one gate. What is to replace a gate has "next" names until it is
// attached. So the gate in force has its own names; or, after a crash in between, it is found by
// what is attached.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::gates {

/// `directory` is that of Control.
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
/// The maps of each program of ours that is pinned in the directory and attached to this device. A
/// gate that did not get its own names because of a crash comes first.
Result<std::vector<MapIds>> maps_of_attached(const std::string& directory, std::uint32_t ifindex);
/// The map among `ids` that has the name `path`, or its next name, which then becomes its own; an
/// empty Fd if none has.
Fd take_map(const std::string& path, const MapIds& ids);

/// Pins each object under its next name, unless it has its own.
Result<void> pin_as_next(std::span<const Pin> pins);
/// After pin_as_next(): gives each object its own name, replacing what has that name.
Result<void> name_next(std::span<const Pin> pins);
/// Removes the next names of objects that were not attached.
void forget_next(const std::string& directory);

}  // namespace mlcca::gates
