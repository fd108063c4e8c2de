// SPDX-License-Identifier: BSD-2-Clause
// Events of a channel that a gateway would carry on although it was not admitted for them, because
// they look like those of another publisher: around a ring of gateways they would go on for ever.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/model/members.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// Events that a gateway sends on a network whose frames carry the subject come from its address.
/// Who takes events there without regard to their address takes these, too.
[[nodiscard]] bool takes_any_sender(const System& system, const Publisher& publisher,
                                    const Route& route, std::size_t gateway);

/// A gateway that would carry events of one publisher on as those of another one, by what is
/// granted of the verdicts; nothing: none would. All verdicts are of one channel.
[[nodiscard]] std::optional<std::size_t> find_echo(const System& system, const Members& members,
                                                   std::span<const Verdict> verdicts);

/// What gateways have sent of each publisher of a channel so far: each of its events is on a
/// network once.
class Carriers {
 public:
  explicit Carriers(const System& system) : system_(system) {}

  /// The first network of the route that the publisher's events reach by another way already, or
  /// are sent on.
  [[nodiscard]] std::optional<Place> twice(std::size_t publisher, const Route& route) const;
  void add(std::size_t publisher, const Route& route);

 private:
  struct Sent {
    std::size_t publisher = 0;
    std::size_t network = 0;
    std::size_t gateway = 0;
    auto operator<=>(const Sent&) const = default;
  };
  void each(std::size_t publisher, const Route& route, auto sends) const;

  const System& system_;
  std::vector<Sent> sent_;  ///< sorted
};

}  // namespace mlcca::core
