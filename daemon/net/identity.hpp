// SPDX-License-Identifier: BSD-2-Clause
// Which of the interfaces that are there is the one the description means.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "daemon/net/links.hpp"

namespace mlcca::net {

/// What udev knows of an interface that does not change when it is re-plugged.
struct UdevFacts {
  std::string id_path;
  std::string serial;
  std::optional<unsigned> port;  ///< dev_port, or dev_id where the driver numbers channels there
};

/// Asks udev's database; empty facts where udev knows nothing (yet).
[[nodiscard]] UdevFacts udev_facts(int ifindex);

using FactsOf = std::function<UdevFacts(int ifindex)>;
/// Asks for the facts of each interface once, however many ports look for one.
[[nodiscard]] FactsOf read_once(const FactsOf& facts_of);

/// The interface of the identity: nothing while it is not there, an error when several match.
[[nodiscard]] Result<std::optional<int>> find_interface(const core::InterfaceIdentity& identity,
                                                        const LinkTable& links,
                                                        const FactsOf& facts_of);

/// "name can0", "id-path pci-0000:01:00.0 port 1".
[[nodiscard]] std::string to_text(const core::InterfaceIdentity& identity);

}  // namespace mlcca::net
