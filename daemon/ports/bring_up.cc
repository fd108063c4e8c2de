// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/bring_up.hpp"

namespace mlcca {

Result<void> bring_up(const net::Link& link, const core::Port& port, net::Links& links) {
  const bool set_rates = link.kind == "can" && port.bitrate != 0 &&
                         (link.bitrate != port.bitrate ||
                          (port.data_bitrate != 0 && link.data_bitrate != port.data_bitrate));
  Result<void> done;
  if (set_rates) {
    if (link.up) done = links.set_up(link.ifindex, false);
    if (done) done = links.set_bitrates(link.ifindex, port.bitrate, port.data_bitrate);
  }
  if (done && (!link.up || set_rates)) done = links.set_up(link.ifindex, true);
  return done;
}

}  // namespace mlcca
