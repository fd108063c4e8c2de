// SPDX-License-Identifier: BSD-2-Clause
// /etc/mlcca/cluster.conf: where the store is, and by which certificate it knows this gateway.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::cluster {

struct Settings {
  std::vector<std::string> endpoints;  ///< "https://HOST:PORT", in order, at least one
  std::string ca, certificate, key;    ///< files (PEM)
  std::uint64_t timeout_ms = 1000;     ///< of a connection, and of a sign of life

  bool operator==(const Settings&) const = default;
};

/// A line each: `endpoint = https://10.0.0.1:2379`, once for each member; `ca`, `certificate` and
/// `key` are files, ca.pem, cert.pem and key.pem in `credentials` by default; `timeout` has ms. `#`
/// begins a comment. An error names the file and each line that is wrong.
[[nodiscard]] Result<Settings> parse_settings(std::string_view text, const std::string& file,
                                              const std::string& credentials);
[[nodiscard]] Result<Settings> read_settings(const std::string& file,
                                             const std::string& credentials);

}  // namespace mlcca::cluster
