// SPDX-License-Identifier: BSD-2-Clause
#include "tools/sources/open.hpp"

#include <utility>

#include "core/mesh/bounds.hpp"
#include "tools/sources/awds.hpp"
#include "tools/sources/babel.hpp"
#include "tools/sources/file.hpp"
#include "tools/sources/olsr.hpp"

namespace mlcca::net {

Result<std::unique_ptr<LinkSource>> open_here(const core::mesh::Source& source,
                                              const core::mesh::Mesh& mesh, sd_event* loop,
                                              LinkSource::Report to) {
  auto report = bounded_report(std::move(to), mesh, loop);
  using enum core::mesh::SourceKind;
  switch (source.kind) {
    case file:
      return open_file(source, mesh, loop, std::move(report));
    case awds:
      return open_awds(source, mesh, loop, std::move(report));
    case babel:
      return open_babel(source, mesh, loop, std::move(report));
    case olsr:
      return open_olsr(source, loop, std::move(report));
    default:
      return fail("this source is read by mlccad itself");
  }
}

}  // namespace mlcca::net
