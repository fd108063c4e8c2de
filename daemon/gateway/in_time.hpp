// SPDX-License-Identifier: BSD-2-Clause
// Runs calls that may hang (looking up a user, a file system) on a thread, and waits for them for a
// limited time.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>

#include "base/clock.hpp"

namespace mlcca {

/// The result of `work`, which must share no data with others; nullopt after `limit_ns`. Then the
/// thread continues, and the program must end by std::_Exit. `meanwhile` is called every 20 ms.
template <class Work>
auto in_time(Work work, std::uint64_t limit_ns, const std::function<void()>& meanwhile)
    -> std::optional<std::invoke_result_t<Work>> {
  constexpr std::chrono::milliseconds slice(20);
  const auto shared = std::make_shared<Work>(std::move(work));
  std::promise<std::invoke_result_t<Work>> promise;
  auto future = promise.get_future();
  try {
    std::thread([shared, promise = std::move(promise)]() mutable {
      promise.set_value((*shared)());
    }).detach();
  } catch (const std::system_error&) {  // no thread could be made
    return (*shared)();
  }
  const std::uint64_t end = monotonic_ns() + limit_ns;
  for (;;) {
    // The deadline is read before the result, so that a result that is there counts even if this
    // process was delayed.
    const bool late = monotonic_ns() >= end;
    if (future.wait_for(slice) == std::future_status::ready) return future.get();
    if (late) return std::nullopt;
    meanwhile();
  }
}

}  // namespace mlcca
