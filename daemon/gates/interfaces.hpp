// SPDX-License-Identifier: BSD-2-Clause
// Operations on interfaces without a gate object: remaining pins, and closing an interface before
// there is a daemon.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/attachment.hpp"
#include "daemon/gates/control.hpp"

namespace mlcca::gates {

/// The indices of interfaces, present or not, for which gates of this or an earlier daemon are
/// pinned.
[[nodiscard]] Result<std::vector<std::uint32_t>> pinned_interfaces(const Control& control);

/// Removes the pins of interfaces that do not exist in this network namespace any more, as the
/// kernel states for each of them.
Result<void> unpin_vanished(const Control& control);

enum class Closing : std::uint8_t {
  closed,     ///< a gate without slots was attached
  was_gated,  ///< a gate was there already; nothing was done
};

/// Puts a gate without slots on the interface unless one of ours is there. Never replaces a
/// program. Uses clsact if nothing can be pinned, so that it needs no bpffs. `control` is that of
/// the daemon that asks.
Result<Closing> close_interface(const std::string& name, const Control& control,
                                std::optional<Hook> hook = std::nullopt);
/// The same for early boot and udev, where it may race with the daemon. If there is no bpffs at
/// `root`, or its control word cannot be read, the gate has a separate word that nothing can open:
/// it stays closed until a daemon replaces it.
Result<Closing> close_interface(const std::string& name, const std::string& root,
                                std::optional<Hook> hook = std::nullopt);

}  // namespace mlcca::gates
