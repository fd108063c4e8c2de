// SPDX-License-Identifier: BSD-2-Clause
// OLSRv2 by OONF (olsrd2): the graph of the mesh with its directional airtime metric (RFC 7779).
#pragma once
#include <string_view>

#include "daemon/net/sources/bounds.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

namespace olsr {

inline constexpr std::size_t kMaxRows = 16384;  ///< of the three tables together
inline constexpr std::size_t kMaxOwn = 8;       ///< addresses of this node
inline constexpr std::size_t kMaxText = 256;    ///< bytes of a value

/// Three tables, after which olsrd2 closes: who we are, our own links, those of all others.
inline constexpr std::string_view kRequest =
    "/olsrv2info json originator/nhdpinfo json neighbor/olsrv2info json edge\n";

/// Bit/s of a link that costs `metric`: 2^31 / metric, as ff_dat_metric computes it (losses are
/// part of the cost). 0 where the metric is no cost (RFC 7181: 1 to 0xffff00).
[[nodiscard]] Value rate_of(std::uint64_t metric);

/// The answer to kRequest: JSON objects one after the other. `taken` is left to the caller. Rates
/// only of links whose metric is ff_dat_metric.
[[nodiscard]] Result<core::mesh::Snapshot> parse(std::string_view answer);

}  // namespace olsr

/// `source.endpoint`: HOST:PORT, [HOST]:PORT or the path of a socket.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_olsr(const core::mesh::Source& source,
                                                            sd_event* loop,
                                                            LinkSource::Report report);

}  // namespace mlcca::net
