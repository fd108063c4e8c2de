// SPDX-License-Identifier: BSD-2-Clause
// The common interface of everything that knows the state of links.
#pragma once
#include <systemd/sd-event.h>

#include <functional>
#include <memory>

#include "base/result.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/sample.hpp"

namespace mlcca::net {

/// Watches one source on the daemon's event loop until it is destroyed. Reports what it knows after
/// each poll, also if nothing has changed, because the samples are younger then. A problem (lost
/// connection, missing interface) is reported as a snapshot without links; the source tries again
/// by itself.
class LinkSource {
 public:
  using Report = std::function<void(core::mesh::Snapshot)>;

  LinkSource() = default;
  LinkSource(const LinkSource&) = delete;
  LinkSource& operator=(const LinkSource&) = delete;
  LinkSource(LinkSource&&) = delete;
  LinkSource& operator=(LinkSource&&) = delete;
  virtual ~LinkSource() = default;
};

/// A report function that passes on what is bounded() (core/mesh/bounds.hpp), at the time of the
/// loop.
[[nodiscard]] LinkSource::Report bounded_report(LinkSource::Report report,
                                                const core::mesh::Mesh& mesh, sd_event* loop);

/// Opens the described source. `to` is called only from the loop, never during this call. The error
/// concerns the configuration; a temporary fault is reported as a problem instead.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_source(const core::mesh::Source& source,
                                                              const core::mesh::Mesh& mesh,
                                                              sd_event* loop,
                                                              LinkSource::Report to);

}  // namespace mlcca::net
