// SPDX-License-Identifier: BSD-2-Clause
// One interface for everything that knows the state of links.
#pragma once
#include <systemd/sd-event.h>

#include <functional>
#include <memory>

#include "base/result.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/sample.hpp"

namespace mlcca::net {

/// Watches one source on the daemon's event loop until it is destroyed. It reports what it knows
/// after each poll, also when nothing changed (the samples are younger then), and reports a problem
/// (lost connection, missing interface) as a snapshot without links; it tries again by itself.
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

/// `to` is called from the loop only, never from here. An error says what is wrong with the
/// configuration; what may come and go is reported as a problem instead.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_source(const core::mesh::Source& source,
                                                              const core::mesh::Mesh& mesh,
                                                              sd_event* loop,
                                                              LinkSource::Report to);

}  // namespace mlcca::net
