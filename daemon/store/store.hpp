// SPDX-License-Identifier: BSD-2-Clause
// What was granted or taken back at run time and must survive the daemon and a reboot: a list of
// the requests that brought it about, on disk before the answer is given.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "core/result.hpp"

namespace mlcca::store {

struct Contents {
  /// Admit requests that were granted, oldest first; Request::id is the admission's id.
  std::vector<control::Request> admissions;
  /// Channels (by subject, "0x…") that the operator has released.
  std::vector<std::string> released;
  /// The next admission gets this id; ids are never used twice.
  std::uint64_t next_id = 1;
  bool operator==(const Contents&) const = default;
};

class Store {
 public:
  /// `directory` must exist.
  explicit Store(std::string directory) : path_(std::move(directory) + "/admissions") {}

  /// Empty contents when nothing was ever stored. A damaged file is an error that names it: nothing
  /// in it is used.
  [[nodiscard]] Result<Contents> load() const;
  /// The file is the old one or the new one at any moment, also across a power loss.
  [[nodiscard]] Result<void> save(const Contents& contents) const;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace mlcca::store
