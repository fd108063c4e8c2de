// SPDX-License-Identifier: BSD-2-Clause
// A store that programs in the kernel see only after everything that was stored before it.
#pragma once
#include <atomic>

namespace mlcca::gates {

template <class T>
void publish(T& word, T value) {
  std::atomic_ref<T>(word).store(value, std::memory_order_release);
}

}  // namespace mlcca::gates
