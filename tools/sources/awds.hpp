// SPDX-License-Identifier: BSD-2-Clause
// Topology packets of AWDS. They come from the unit mlcca-awds@INTERFACE, which alone may listen to
// a network interface; this end only reads a local socket.
#pragma once
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

/// Where mlcca-awds@INTERFACE.socket listens.
inline constexpr const char* kAwdsFolder = "/run/mlcca/awds/";

/// `source.endpoint`, if it is an absolute path, is the socket instead of the one in kAwdsFolder.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_awds(const core::mesh::Source& source,
                                                            const core::mesh::Mesh& mesh,
                                                            sd_event* loop,
                                                            LinkSource::Report report);

}  // namespace mlcca::net
