// SPDX-License-Identifier: BSD-2-Clause
// Stations, mesh paths and survey of a radio of this machine, read from nl80211.
#pragma once
#include <memory>

#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

/// Polls the interface `source.interface` each second. The interface may appear later. Mesh paths
/// need CAP_NET_ADMIN.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_nl80211(const core::mesh::Source& source,
                                                               sd_event* loop,
                                                               LinkSource::Report report);

}  // namespace mlcca::net
