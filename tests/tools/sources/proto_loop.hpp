// SPDX-License-Identifier: BSD-2-Clause
// A link source on a loop, whose snapshots are awaited.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/handle.hpp"
#include "core/mesh/mesh.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::test {

class Watched {
 public:
  using Predicate = std::function<bool(const core::mesh::Snapshot&)>;

  using Open =
      std::function<Result<std::unique_ptr<net::LinkSource>>(sd_event*, net::LinkSource::Report)>;

  /// Opens it as mlcca-sources does; on a loop of its own if none is given.
  Watched(const core::mesh::Source& source, const core::mesh::Mesh& mesh, sd_event* loop = nullptr);
  explicit Watched(const Open& open, sd_event* loop = nullptr);

  /// Why the source could not be opened; empty: it could.
  [[nodiscard]] const std::string& error() const { return error_; }
  /// The first snapshot from now on that fits, waited for; nothing after a generous time.
  std::optional<core::mesh::Snapshot> await(const Predicate& fits);
  /// What was reported last, for a message.
  [[nodiscard]] std::string last() const;

 private:
  std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop_;
  std::optional<core::mesh::Snapshot> reported_;
  const Predicate* fits_ = nullptr;
  std::optional<core::mesh::Snapshot> found_;
  std::string error_;
  std::unique_ptr<net::LinkSource> source_;
};

/// Nodes "n1", "n2", … with the given addresses.
core::mesh::Mesh mesh_of(const std::vector<std::string>& addresses);

/// The sample of one direction, nullptr if there is none.
const core::mesh::Sample* find(const core::mesh::Snapshot& snapshot, const std::string& from,
                               const std::string& to);

/// A new folder below the one for temporary files, removed with this object.
class Folder {
 public:
  Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder();
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace mlcca::test
