// SPDX-License-Identifier: BSD-2-Clause
// The settings file /etc/mlcca/cluster.conf: the members of the store, and the certificate by which
// the store recognises this gateway.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::cluster {

/// The settings of the file.
struct Settings {
  std::vector<std::string> endpoints;  ///< "https://HOST:PORT", in the order in which they are
                                       ///< tried, at least one
  std::string ca, certificate, key;    ///< file names (PEM)
  std::uint64_t timeout_ms = 1000;  ///< limit for a connection, and for an answer that shows that
                                    ///< the member is alive

  bool operator==(const Settings&) const = default;
};

/// Parses one setting a line: `endpoint = https://10.0.0.1:2379`, once for each member; `ca`,
/// `certificate` and `key` name files, by default ca.pem, cert.pem and key.pem in `credentials`;
/// `timeout` is in ms. `#` begins a comment. An error names `file` and each line that is wrong.
[[nodiscard]] Result<Settings> parse_settings(std::string_view text, const std::string& file,
                                              const std::string& credentials);
[[nodiscard]] Result<Settings> read_settings(const std::string& file,
                                             const std::string& credentials);
/// Whether the files of certificates and key can be read and are such (PEM). An error has a line
/// for each file that is not. Whether the key belongs to the certificate, and whether the store
/// accepts both, shows the first connection.
[[nodiscard]] Result<void> check_credentials(const Settings& settings);

}  // namespace mlcca::cluster
