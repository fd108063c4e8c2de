// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/progress.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace mlcca::tools::design {

void ProgressLine::show(std::string_view what, double done) {
  const auto now = now_();
  if (now < next_) return;
  next_ = now + kPause;
  shown_ = true;
  write_(fmt::format("\r{} {} %\x1b[K", what, static_cast<int>(std::clamp(done, 0.0, 1.0) * 100)));
}

void ProgressLine::erase() {
  if (shown_) write_("\r\x1b[K");
  shown_ = false;
}

}  // namespace mlcca::tools::design
