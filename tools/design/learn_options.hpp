// SPDX-License-Identifier: BSD-2-Clause
// Options of `mlccactl learn`, examined before it listens. Errors name the option, and what would
// be right.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "tools/learn/frame.hpp"

namespace mlcca::tools::design {

/// Splits "can0=500k" into the interface and the rest; nullopt if it has another form.
[[nodiscard]] std::optional<std::pair<std::string, std::string>> assignment(
    const std::string& text);

// The values of repeated options, by interface. An interface that is named twice is an error.
/// Bit rates, in bit/s, of `option`; at most `most`.
[[nodiscard]] Result<std::map<std::string, std::uint32_t>> stated_rates(
    const std::vector<std::string>& texts, const char* option, std::uint32_t most);
[[nodiscard]] Result<std::map<std::string, core::Profile>> stated_profiles(
    const std::vector<std::string>& texts);

/// An error if one of the values of `option` is for an interface that is not in `there`, or for one
/// that is no CAN bus (`of_buses`).
[[nodiscard]] Result<void> fit_interfaces(const std::vector<std::string>& texts, const char* option,
                                          bool of_buses,
                                          const std::map<std::string, learn::Medium>& there);

/// An error if no user of a description can have this name.
[[nodiscard]] Result<void> can_be_user(const std::string& name);

/// The signals that end listening call `handler`. SIGHUP stays ignored where it is, as by nohup.
void on_end(void (*handler)(int));

}  // namespace mlcca::tools::design
