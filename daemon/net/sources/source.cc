// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/source.hpp"

#include <utility>

#include "base/loop_timer.hpp"
#include "core/mesh/bounds.hpp"

namespace mlcca::net {

LinkSource::Report bounded_report(LinkSource::Report report, const core::mesh::Mesh& mesh,
                                  sd_event* loop) {
  return [report = std::move(report), described = core::mesh::described_nodes(mesh),
          loop](core::mesh::Snapshot snapshot) {
    report(core::mesh::bounded(std::move(snapshot), described, loop_time(loop)));
  };
}

}  // namespace mlcca::net
