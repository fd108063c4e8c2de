// SPDX-License-Identifier: BSD-2-Clause
// Chooses the adapter of a described source. What only the kernel reports is read in this process;
// what untrusted peers write is read by a separate one.
#include <utility>

#include "core/mesh/bounds.hpp"
#include "daemon/net/sources/batman.hpp"
#include "daemon/net/sources/nl80211.hpp"
#include "daemon/net/sources/remote.hpp"
#include "daemon/net/sources/source.hpp"
#include "daemon/net/sources/wire.hpp"

namespace mlcca::net {

Result<std::unique_ptr<LinkSource>> open_source(const core::mesh::Source& source,
                                                const core::mesh::Mesh& mesh, sd_event* loop,
                                                LinkSource::Report to) {
  auto report = bounded_report(std::move(to), mesh, loop);
  using enum core::mesh::SourceKind;
  switch (source.kind) {
    case description:
      return fail("links that the description states need no source");
    case nl80211:
      return open_nl80211(source, loop, std::move(report));
    case batman:
      return open_batman(source, loop, std::move(report));
    case awds:
    case babel:
    case olsr:
    case file:
      return open_remote(source, mesh, loop, std::move(report));
    case wire:
      return open_wire(source, mesh, loop, std::move(report));
  }
  return fail("an unknown kind of link source");
}

}  // namespace mlcca::net
