// SPDX-License-Identifier: BSD-2-Clause
// Reading a description, for a start or a reload.
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

/// Why a description is not used, or why the daemon cannot start.
struct StartError {
  std::vector<std::string> lines;
  /// True: the description was read and is refused, which only a person can correct. False: the
  /// machine failed (a file that cannot be opened, no memory, a full disk), and the next start may
  /// succeed.
  bool bad_input = false;
};

/// A description that was read, with nothing decided yet.
struct Described {
  std::unique_ptr<core::State> state;
  std::size_t self = 0;             ///< index of the gateway of this machine
  Sha256::Digest digest = {};       ///< digest of the text that was read; only in a cluster
  Sha256::Digest file_digest = {};  ///< digest of the file, if another text was read
  std::string text = {};            ///< of what was read, in a cluster, if it can be passed on
  bool unchecked = false;           ///< other gateways may be on any network: see Rollout::reader()
  std::vector<std::string> notes = {};  ///< for the log: what could not be used
};

using DescribedResult = std::expected<Described, StartError>;
/// Reads the description that exists now. May run on another thread, so it shares no data.
using ReadDescription = std::function<DescribedResult()>;

/// Reads the file that the options name.
[[nodiscard]] DescribedResult read_description(const Options& options);
/// Reads a text that another gateway has passed on.
[[nodiscard]] DescribedResult read_description_text(const Options& options,
                                                    const std::string& text);
/// The error text when reading takes longer than it may, with the likely cause.
[[nodiscard]] std::string not_read_in_time(const Options& options);

}  // namespace mlcca
