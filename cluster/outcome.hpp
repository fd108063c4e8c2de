// SPDX-License-Identifier: BSD-2-Clause
// What is known about a transaction whose call has failed.
#pragma once
#include "cluster/channel.hpp"
#include "core/cluster/store.hpp"

namespace mlcca::cluster {

/// Classifies a transaction whose call ended without an answer. Whatever is not certainly another
/// outcome is `unsure`: etcd may have carried it out although no answer came.
[[nodiscard]] core::cluster::Outcome outcome_of(const End& end);

}  // namespace mlcca::cluster
