// SPDX-License-Identifier: BSD-2-Clause
// What may hang on a disk is done on a thread, and waited for. Nothing else happens meanwhile but
// heart-beats: whoever loads the disk does not close the gates by it.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

namespace mlcca {

class Patience {
 public:
  /// So long, in nanoseconds, `meanwhile` is called. What hangs longer hangs the caller: then no
  /// heart-beat is given, and the gates close.
  static constexpr std::uint64_t kLongest = 30'000'000'000;

  /// `meanwhile` is called every 20 ms while something takes longer.
  explicit Patience(std::function<void()> meanwhile, std::uint64_t longest = kLongest)
      : meanwhile_(std::move(meanwhile)), longest_(longest) {}
  Patience(const Patience&) = delete;
  Patience& operator=(const Patience&) = delete;
  Patience(Patience&&) = delete;
  Patience& operator=(Patience&&) = delete;
  ~Patience();

  /// What `work` gives. It may use whatever the caller may, for the caller waits; `meanwhile` may
  /// use nothing of that. Where there is no thread to be had the caller does it itself.
  template <class Work>
  auto wait_for(const Work& work) {
    std::optional<std::invoke_result_t<Work>> result;
    run([&] { result.emplace(work()); });
    return std::move(*result);
  }

 private:
  void run(const std::function<void()>& work);
  bool start();
  void serve();

  std::function<void()> meanwhile_;
  std::uint64_t longest_;
  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void()>* work_ = nullptr;  ///< under way, or to be done
  bool ends_ = false;
  std::thread thread_;  ///< from the first work on
};

}  // namespace mlcca
