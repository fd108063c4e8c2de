// SPDX-License-Identifier: BSD-2-Clause
// Implements Channel over HTTP/2 and TLS, by libcurl in the event loop.
#pragma once
#include <systemd/sd-event.h>

#include <memory>
#include <string>

#include "base/result.hpp"
#include "cluster/channel.hpp"
#include "cluster/settings.hpp"

namespace mlcca::cluster {

/// Must be called once before the sandbox is entered: it lets libcurl and its TLS library read and
/// allocate what they need.
[[nodiscard]] Result<void> prepare_http();

/// Opens a channel to `endpoint`. All its calls share one connection, which the first call makes.
/// Each connection reads the certificate files of `settings` again. No request is sent twice.
[[nodiscard]] Result<std::unique_ptr<Channel>> open_http(sd_event* loop, const Settings& settings,
                                                         const std::string& endpoint);

}  // namespace mlcca::cluster
