// SPDX-License-Identifier: BSD-2-Clause
// The choice of the member of the store that is asked.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace mlcca::cluster {

/// Chooses the member of the store that is asked. After a failure it is the next member, at once
/// until all have failed; then after a pause, which doubles each time.
class StoreMembers {
 public:
  explicit StoreMembers(std::vector<std::string> all) : all_(std::move(all)) {}

  [[nodiscard]] const std::string& current() const { return all_[at_]; }
  [[nodiscard]] std::size_t count() const { return all_.size(); }
  void succeeded() {
    failures_ = 0;
    pause_ = kFirstPause;
  }
  /// Records a failure and goes to the next member. Returns the µs to wait before it is tried.
  std::uint64_t failed() {
    at_ = (at_ + 1) % all_.size();
    if (++failures_ < all_.size()) return 0;
    failures_ = 0;
    return std::exchange(pause_, std::min(2 * pause_, kLongestPause));
  }

 private:
  static constexpr std::uint64_t kFirstPause = 200'000;      // µs
  static constexpr std::uint64_t kLongestPause = 3'200'000;  // µs

  std::vector<std::string> all_;
  std::size_t at_ = 0;
  std::size_t failures_ = 0;  ///< members that failed since the latest success or pause
  std::uint64_t pause_ = kFirstPause;
};

}  // namespace mlcca::cluster
