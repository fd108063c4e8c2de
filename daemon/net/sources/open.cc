// SPDX-License-Identifier: BSD-2-Clause
// Which adapter a described source gets.
#include <utility>

#include "daemon/net/sources/awds.hpp"
#include "daemon/net/sources/babel.hpp"
#include "daemon/net/sources/batman.hpp"
#include "daemon/net/sources/described.hpp"
#include "daemon/net/sources/file.hpp"
#include "daemon/net/sources/nl80211.hpp"
#include "daemon/net/sources/olsr.hpp"
#include "daemon/net/sources/source.hpp"
#include "daemon/net/sources/wire.hpp"

namespace mlcca::net {

Result<std::unique_ptr<LinkSource>> open_source(const core::mesh::Source& source,
                                                const core::mesh::Mesh& mesh, sd_event* loop,
                                                LinkSource::Report report) {
  using enum core::mesh::SourceKind;
  switch (source.kind) {
    case description:
      return open_described(mesh, loop, std::move(report));
    case file:
      return open_file(source, mesh, loop, std::move(report));
    case nl80211:
      return open_nl80211(source, loop, std::move(report));
    case batman:
      return open_batman(source, loop, std::move(report));
    case awds:
      return open_awds(source, loop, std::move(report));
    case babel:
      return open_babel(source, mesh, loop, std::move(report));
    case olsr:
      return open_olsr(source, loop, std::move(report));
    case wire:
      return open_wire(source, mesh, loop, std::move(report));
  }
  return fail("an unknown kind of link source");
}

}  // namespace mlcca::net
