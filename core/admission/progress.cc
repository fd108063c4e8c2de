// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/progress.hpp"

#include <utility>

namespace mlcca::core {
namespace {

thread_local Progress* current = nullptr;

}  // namespace

Progress::Progress(std::function<void()> told)
    : told_(std::move(told)), before_(std::exchange(current, this)) {}

Progress::~Progress() { current = before_; }

void Progress::made() {
  if (current != nullptr) current->told_();
}

}  // namespace mlcca::core
