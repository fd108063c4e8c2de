// SPDX-License-Identifier: BSD-2-Clause
// What the bench of several gateways measures, and what its parts have in common.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "tests/bench/gateways/place.hpp"

namespace mlcca::bench {

/// An admission against one transaction of the store, the journal in memory and in `folder`.
void measure_admission(const std::string& folder);
/// Many gateways on one store.
void measure_many();
/// The one that forwards is killed.
void measure_forwarder();

/// "channel" from programs of root on a gateway to a network, by the key of its name: how long the
/// answer took, ms.
double admit(control::Client& client, const std::string& channel, const std::string& gateway,
             const std::string& network);
double release(control::Client& client, const std::string& channel);

/// Users gw1 and gw2 of test::Store may do this as well.
void grant(const test::Store& store, const std::string& user, const std::string& rights,
           const std::string& prefix);

/// "p50 … p99 …" of values in ms.
[[nodiscard]] std::string quantiles(const std::vector<double>& values);

}  // namespace mlcca::bench
