// SPDX-License-Identifier: BSD-2-Clause
// Finds the interface that a description means.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "daemon/net/links.hpp"

namespace mlcca::net {

/// The properties that udev has of an interface and that survive re-plugging.
struct UdevFacts {
  std::string id_path;
  std::string serial;
  std::optional<unsigned> port;  ///< dev_port, or dev_id if the driver numbers channels by that
};

/// Reads udev's database. Empty if udev knows nothing (yet).
[[nodiscard]] UdevFacts udev_facts(int ifindex);

using FactsOf = std::function<UdevFacts(int ifindex)>;
/// Returns a function that asks for the facts of each interface only once, for any number of ports.
[[nodiscard]] FactsOf read_once(const FactsOf& facts_of);

/// The interface with this identity; nullopt if it is not there; an error if several match.
[[nodiscard]] Result<std::optional<int>> find_interface(const core::InterfaceIdentity& identity,
                                                        const InterfaceTable& links,
                                                        const FactsOf& facts_of);

/// For example "name can0" or "id-path pci-0000:01:00.0 port 1".
[[nodiscard]] std::string to_text(const core::InterfaceIdentity& identity);

}  // namespace mlcca::net
