// SPDX-License-Identifier: BSD-2-Clause
// What concerns interfaces that no gate object is for: whose pins are left, and which are to be
// closed before there is a daemon.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/attachment.hpp"
#include "daemon/gates/control.hpp"

namespace mlcca::enforce {

/// Those that gates of this daemon, or of one before it, are pinned for, there or not.
[[nodiscard]] Result<std::vector<std::uint32_t>> pinned_interfaces(const Control& control);

/// Frees what is pinned for interfaces that do not exist any more in this network namespace, as the
/// kernel says of each of them.
Result<void> unpin_vanished(const Control& control);

enum class Closing : std::uint8_t {
  closed,     ///< a gate without slots is attached now
  was_gated,  ///< a gate was there already; nothing was done
};

/// Puts a gate without slots on the interface unless one of ours is there. Never replaces a
/// program. By clsact where nothing can be pinned, so that it needs no bpffs. `control`: of the
/// daemon that asks.
Result<Closing> close_interface(const std::string& name, const Control& control,
                                std::optional<Hook> hook = std::nullopt);
/// The same for early boot and udev, where it may race with the daemon. Where there is no bpffs at
/// `root`, or the control word there cannot be read, the gate has one of its own, which nothing can
/// open: it stays closed until a daemon replaces it.
Result<Closing> close_interface(const std::string& name, const std::string& root,
                                std::optional<Hook> hook = std::nullopt);

}  // namespace mlcca::enforce
