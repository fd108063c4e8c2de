// SPDX-License-Identifier: BSD-2-Clause
// Sources that untrusted peers write, opened in this process: that of mlcca-sources, or of a test.
#pragma once
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

/// As open_source() of the sources awds, babel, olsr and file; another is an error.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_here(const core::mesh::Source& source,
                                                            const core::mesh::Mesh& mesh,
                                                            sd_event* loop, LinkSource::Report to);

}  // namespace mlcca::net
