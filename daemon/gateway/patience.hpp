// SPDX-License-Identifier: BSD-2-Clause
// Runs calls that may hang on a disk on a thread, and waits for them. Meanwhile only heart-beats
// are given, so that a program that loads the disk does not close the gates by it.
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
  /// ns for which `meanwhile` is called. A call that hangs longer hangs the caller: then no
  /// heart-beat is given, and the gates close.
  static constexpr std::uint64_t kLongest = 30'000'000'000;

  /// `meanwhile` is called every 20 ms while a call takes longer than that.
  explicit Patience(std::function<void()> meanwhile, std::uint64_t longest = kLongest)
      : meanwhile_(std::move(meanwhile)), longest_(longest) {}
  Patience(const Patience&) = delete;
  Patience& operator=(const Patience&) = delete;
  Patience(Patience&&) = delete;
  Patience& operator=(Patience&&) = delete;
  ~Patience();

  /// Returns the result of `work`, which may use all data of the caller, because the caller waits.
  /// `meanwhile` may use none of these. If no thread can be made, the caller runs `work` itself.
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
  const std::function<void()>* work_ = nullptr;  ///< the call that is under way or to be done
  bool ends_ = false;
  std::thread thread_;  ///< started with the first call
};

}  // namespace mlcca
