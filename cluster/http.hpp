// SPDX-License-Identifier: BSD-2-Clause
// The channel over HTTP/2 and TLS, by libcurl in the loop of sd-event.
#pragma once
#include <systemd/sd-event.h>

#include <memory>
#include <string>

#include "base/result.hpp"
#include "cluster/channel.hpp"
#include "cluster/settings.hpp"

namespace mlcca::cluster {

/// Once, before anything else: what libcurl and its TLS library read and allocate.
[[nodiscard]] Result<void> prepare_http();

/// All calls share one connection, which is made by the first one. Each connection reads the files
/// of `settings` again. Nothing is ever sent twice.
[[nodiscard]] Result<std::unique_ptr<Channel>> open_http(sd_event* loop, const Settings& settings,
                                                         const std::string& endpoint);

}  // namespace mlcca::cluster
