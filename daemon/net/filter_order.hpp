// SPDX-License-Identifier: BSD-2-Clause
// The order of filters in the clsact hooks of an interface, and the frames that wait in its queue.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace mlcca::net {

/// One filter of tc.
struct Filter {
  std::uint32_t priority = 0;
  std::uint32_t handle = 0;
  std::string kind;           ///< "bpf", "flower", …
  std::string name;           ///< of a BPF program, as its loader has named it
  std::uint32_t program = 0;  ///< id of a BPF program
  bool operator==(const Filter&) const = default;
};

/// The filters of chain 0, in their order. Empty if there is no clsact.
[[nodiscard]] Result<std::vector<Filter>> all_filters(int ifindex, bool ingress);

/// The filters of chain 0 that run before the one with this priority and handle, in their order;
/// all of them if that one is not there. Empty if there is no clsact.
[[nodiscard]] Result<std::vector<Filter>> filters_before(int ifindex, bool ingress,
                                                         std::uint32_t priority,
                                                         std::uint32_t handle);

/// The state of the root queueing discipline.
struct Waiting {
  std::uint64_t frames = 0;   ///< in the root queueing discipline
  std::uint64_t dropped = 0;  ///< by this discipline so far
};
[[nodiscard]] Result<Waiting> waiting_in_queue(int ifindex);

}  // namespace mlcca::net
