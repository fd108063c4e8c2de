// SPDX-License-Identifier: BSD-2-Clause
#include "base/throttle.hpp"

#include <utility>

namespace mlcca {

Result<void> Throttle::start(sd_event* loop, std::function<void()> call) {
  loop_ = loop;
  call_ = std::move(call);
  return timer_.start(loop, [this] {
    if (asked_) go();
  });
}

void Throttle::ask() {
  const std::uint64_t now = loop_time(loop_);
  if (now >= next_) {
    go();
  } else if (!asked_) {
    asked_ = true;
    timer_.set((next_ - now) / 1000 + 1);
  }
}

void Throttle::go() {
  asked_ = false;
  next_ = loop_time(loop_) + kLeastPause * 1000;
  call_();
}

}  // namespace mlcca
