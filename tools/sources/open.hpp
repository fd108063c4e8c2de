// SPDX-License-Identifier: BSD-2-Clause
// Opens the sources whose data untrusted peers write, in this process (mlcca-sources or a test).
#pragma once
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

/// As open_source(), for the sources awds, babel, olsr and file; any other one is an error.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_here(const core::mesh::Source& source,
                                                            const core::mesh::Mesh& mesh,
                                                            sd_event* loop, LinkSource::Report to);

}  // namespace mlcca::net
