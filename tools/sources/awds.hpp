// SPDX-License-Identifier: BSD-2-Clause
// The link source AWDS. The topology packets come from the unit mlcca-awds@INTERFACE, the only
// service that may listen to the interface; this side reads a local socket.
#pragma once
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

/// The folder of the sockets of mlcca-awds@INTERFACE.socket.
inline constexpr const char* kAwdsFolder = "/run/mlcca/awds/";

/// Opens the source. If `source.endpoint` is an absolute path, it is used instead of a socket in
/// kAwdsFolder.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_awds(const core::mesh::Source& source,
                                                            const core::mesh::Mesh& mesh,
                                                            sd_event* loop,
                                                            LinkSource::Report report);

}  // namespace mlcca::net
