// SPDX-License-Identifier: BSD-2-Clause
// The link source OLSRv2, for olsrd2 of OONF: the graph of the mesh with its directional airtime
// metric (RFC 7779).
#pragma once
#include <string_view>

#include "core/mesh/bounds.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

namespace olsr {

inline constexpr std::size_t kMaxRows = 16384;  ///< of the three tables together
inline constexpr std::size_t kMaxOwn = 8;       ///< addresses of this node
inline constexpr std::size_t kMaxText = 256;    ///< bytes of a value

/// Requests three tables, after which olsrd2 closes: our identity, our links, the links of all
/// others.
inline constexpr std::string_view kRequest =
    "/olsrv2info json originator/nhdpinfo json neighbor/olsrv2info json edge\n";

/// bit/s of a link with cost `metric`: 2^31 / metric, as ff_dat_metric computes it (losses are part
/// of the cost). 0 if `metric` is not a valid cost (RFC 7181: 1 to 0xffff00).
[[nodiscard]] Value rate_of(std::uint64_t metric);

/// Decodes the answer to kRequest, consecutive JSON objects. Only links whose metric is
/// ff_dat_metric have rates. The caller sets `taken`.
[[nodiscard]] Result<core::mesh::Snapshot> parse(std::string_view answer);

}  // namespace olsr

/// Opens the source; `source.endpoint` is HOST:PORT, [HOST]:PORT or the path of a socket.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_olsr(const core::mesh::Source& source,
                                                            sd_event* loop,
                                                            LinkSource::Report report);

}  // namespace mlcca::net
