// SPDX-License-Identifier: BSD-2-Clause
// A description as a gateway takes it up.
#pragma once
#include <cstddef>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/sha256.hpp"
#include "core/admission/state.hpp"
#include "daemon/options.hpp"

namespace mlcca {

/// Why a description is not used, or the daemon cannot start.
struct StartError {
  std::vector<std::string> lines;
  /// The description was read and is refused: only a person can correct that. False: the machine
  /// failed (a file that cannot be opened, no memory, a full disk), and the next start may succeed.
  bool bad_input = false;
};

/// What a description says, with nothing decided yet.
struct Described {
  std::unique_ptr<core::State> state;
  std::size_t self = 0;                 ///< the gateway of this machine
  Sha256::Digest digest = {};           ///< of what was read, in a cluster
  Sha256::Digest file_digest = {};      ///< of the file, where that is another one
  std::string text = {};                ///< of what was read, in a cluster, if it can be handed on
  bool unchecked = false;               ///< others may be on any network: see Rollout::reader()
  std::vector<std::string> notes = {};  ///< what could not be used meanwhile, for the log
};

using DescribedResult = std::expected<Described, StartError>;
/// Reads the description that is there now. May run on another thread: shares nothing.
using ReadDescription = std::function<DescribedResult()>;

/// From the file that the options name.
[[nodiscard]] DescribedResult read_description(const Options& options);
/// From a text that another gateway has handed on.
[[nodiscard]] DescribedResult read_description_text(const Options& options,
                                                    const std::string& text);
/// When that takes longer than it may, and what may be the cause.
[[nodiscard]] std::string not_read_in_time(const Options& options);

}  // namespace mlcca
