// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include "cluster/channel.hpp"
#include "core/cluster/store.hpp"

namespace mlcca::cluster {

/// Of a transaction whose call ended without an answer. What is not surely one of the others is
/// `unsure`: etcd may have carried it out and said nothing.
[[nodiscard]] core::cluster::Outcome outcome_of(const End& end);

}  // namespace mlcca::cluster
