// SPDX-License-Identifier: BSD-2-Clause
// Random systems of two gateways, and what is asked for at run time there.
#pragma once
#include "tests/core/shared/gateways.hpp"

namespace mlcca::core::testing {

inline constexpr std::size_t kChannels = 24;

/// Half of the channels are described with both ends; the others wait for someone.
inline System random_system(Random& random, bool media) {
  System system = networks(media);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto traffic = every((20 + below(random, 200)) * kMs, (60 + below(random, 400)) * kMs);
    add_channel(system, traffic);
    if (c >= kChannels / 2) continue;
    if (chance(random, 30)) {
      system.channels[c].priority = 1;
      system.channels[c].lower = {{0, every(400 * kMs, 900 * kMs), {}}};
    }
    const std::size_t from = below(random, 3);
    system.publishers.push_back(
        publisher(c, chance(random, 20) ? at(below(random, 2)) : on(from), traffic));
    system.subscribers.push_back(subscriber(c, on((from + 1 + below(random, 2)) % 3), traffic));
    system.publishers.back().lower = system.subscribers.back().lower = system.channels[c].lower;
  }
  return system;
}

/// On a channel that nobody else uses.
inline Admission random_admission(Random& random, const System& system, std::size_t gateway,
                                  AdmissionId id) {
  Admission a;
  a.id = id;
  a.channel = kChannels / 2 + below(random, kChannels / 4) * 2 + gateway;
  const auto traffic = every((15 + below(random, 120)) * kMs, (40 + below(random, 400)) * kMs);
  const std::size_t own = kOwn + gateway;
  a.publisher = publisher(a.channel, chance(random, 30) ? at(gateway) : on(own), traffic);
  a.subscriber = subscriber(a.channel, on(chance(random, 50) ? kShared : 3 - own), traffic);
  if (system.networks.size() > kAir && chance(random, 20)) a.subscriber->place = on(kAir);
  return a;
}

/// Who wants what the description has for others.
inline Admission late_subscriber(Random& random, const System& system, std::size_t gateway,
                                 AdmissionId id) {
  Admission a;
  a.id = id;
  a.channel = below(random, kChannels / 2);
  const EventChannel& channel = system.channels[a.channel];
  a.subscriber =
      subscriber(a.channel, on(chance(random, 40) ? kShared : kOwn + gateway), channel.attributes);
  a.subscriber->lower = channel.lower;
  a.subscriber->attributes.set(Attribute::deadline, (100 + below(random, 400)) * kMs);
  return a;
}

}  // namespace mlcca::core::testing
