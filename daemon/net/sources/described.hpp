// SPDX-License-Identifier: BSD-2-Clause
// The links that the description states. They never grow old.
#pragma once
#include <vector>

#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

/// `taken` is left to the caller.
[[nodiscard]] std::vector<core::mesh::Sample> described_links(const core::mesh::Mesh& mesh);

[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_described(const core::mesh::Mesh& mesh,
                                                                 sd_event* loop,
                                                                 LinkSource::Report report);

}  // namespace mlcca::net
