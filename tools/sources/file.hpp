// SPDX-License-Identifier: BSD-2-Clause
// The link source file: a text file of links, read again when it changes.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/bounds.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

inline constexpr std::size_t kMaxFileBytes = std::size_t{4} << 20U;

/// Parses a file of links, one a line, '#' begins a comment:
///   FROM TO RATE [loss=0.01] [channel=2412] [kind=phy|effective|derived] [busy=0.1] [weight=N]
///   [both]
/// FROM and TO are names or addresses of described nodes, RATE is a number with bit/s, kbit/s,
/// Mbit/s or Gbit/s. At most kMaxFacts directions are accepted. An error begins with "NAME:LINE: ".
/// The caller sets `taken`.
[[nodiscard]] Result<std::vector<core::mesh::Sample>> parse_links(std::string_view text,
                                                                  const std::string& name,
                                                                  const core::mesh::Mesh& mesh);

/// Opens the source; `source.endpoint` is the path of the file. Its folder is watched, so that a
/// rename onto the file is noticed.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_file(const core::mesh::Source& source,
                                                            const core::mesh::Mesh& mesh,
                                                            sd_event* loop,
                                                            LinkSource::Report report);

}  // namespace mlcca::net
