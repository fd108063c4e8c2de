// SPDX-License-Identifier: BSD-2-Clause
// Receivers of programs on the gateway that a former daemon has stated and the present one has not.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client/shared_endpoints.hpp"

namespace mlcca::client {

/// Until when events are still sent to receivers that the daemon does not state. After a restart of
/// the daemon, their programs may not have found it yet.
class FormerReceivers {
 public:
  /// A channel that publishes; its entries end with it.
  using Publisher = std::weak_ptr<const void>;

  /// From now on the publisher has exactly these former receivers. One that it had before keeps its
  /// end; the others get `until` (CLOCK_MONOTONIC, ns).
  void keep(const Publisher& publisher, const std::vector<SharedEndpoint>& receivers,
            std::uint64_t until);
  /// When events end to be sent to the receiver (CLOCK_MONOTONIC, ns); later it learns only how
  /// many there were. Nullopt: it is not a former one.
  [[nodiscard]] std::optional<std::uint64_t> until(const Publisher& publisher,
                                                   const SharedEndpoint& receiver) const;
  [[nodiscard]] bool empty() const { return all_.empty(); }
  /// Nothing receives there any more. Returns false if it is not a former receiver.
  bool forget(const Publisher& publisher, const SharedEndpoint& receiver);

 private:
  struct Former {
    Publisher publisher;
    SharedEndpoint receiver;
    std::uint64_t until = 0;
    [[nodiscard]] bool is(const Publisher& of, const SharedEndpoint& at) const;
  };

  std::vector<Former> all_;
};

}  // namespace mlcca::client
