// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/patience.hpp"

#include <chrono>
#include <csignal>
#include <system_error>

#include "base/clock.hpp"

namespace mlcca {
namespace {

constexpr std::chrono::milliseconds kSlice(20);

}  // namespace

Patience::~Patience() {
  if (!thread_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

/// Blocks all signals in the thread, because the loop handles them. False if there is no thread.
bool Patience::start() {
  if (thread_.joinable()) return true;
  sigset_t all{};
  sigset_t before{};
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  bool started = true;
  try {
    thread_ = std::thread([this] { serve(); });
  } catch (const std::system_error&) {
    started = false;
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return started;
}

void Patience::serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ends_ || work_ != nullptr; });
    if (work_ == nullptr) return;
    const auto* const work = work_;
    lock.unlock();
    (*work)();
    lock.lock();
    work_ = nullptr;
    changed_.notify_all();
  }
}

/// If `longest` is 0, the caller does the work itself, without a thread.
void Patience::run(const std::function<void()>& work) {
  if (longest_ == 0 || !start()) {
    work();
    return;
  }
  std::unique_lock lock(mutex_);
  work_ = &work;
  changed_.notify_all();
  const std::uint64_t begin = monotonic_ns();
  while (!changed_.wait_for(lock, kSlice, [this] { return work_ == nullptr; })) {
    if (monotonic_ns() - begin > longest_) continue;
    lock.unlock();
    meanwhile_();
    lock.lock();
  }
}

}  // namespace mlcca
