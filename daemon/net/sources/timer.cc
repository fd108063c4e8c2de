// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/timer.hpp"

#include <cstring>
#include <ctime>
#include <utility>

namespace mlcca::net {
namespace {

constexpr std::uint64_t kAccuracy = 10'000;  // µs

}  // namespace

std::uint64_t time_of(sd_event* loop) {
  std::uint64_t micros = 0;
  // NOLINTNEXTLINE(bugprone-unused-return-value): it fails for clocks that it does not know
  (void)sd_event_now(loop, CLOCK_MONOTONIC, &micros);
  return micros * 1000;
}

void stamp(core::mesh::Snapshot& snapshot, std::uint64_t taken) {
  for (auto& sample : snapshot.links) sample.taken = taken;
}

std::string error_words(const std::string& what, int error) {
  return what + ": " + std::strerror(error);  // NOLINT(concurrency-mt-unsafe): one thread
}

Result<void> Timer::start(sd_event* loop, std::function<void()> call) {
  call_ = std::move(call);
  sd_event_source* raw = nullptr;
  const int e =
      sd_event_add_time_relative(loop, &raw, CLOCK_MONOTONIC, 0, kAccuracy, on_time, this);
  if (e < 0) return fail(error_words("timer", -e));
  source_.reset(raw);
  return {};
}

void Timer::set(std::uint64_t micros) {
  sd_event_source_set_time_relative(source_.get(), micros);
  sd_event_source_set_enabled(source_.get(), SD_EVENT_ONESHOT);
}

int Timer::on_time(sd_event_source*, std::uint64_t, void* self) noexcept {
  static_cast<Timer*>(self)->call_();
  return 0;
}

Result<void> Pace::start(sd_event* loop, std::function<void()> call) {
  loop_ = loop;
  call_ = std::move(call);
  return timer_.start(loop, [this] {
    if (asked_) go();
  });
}

void Pace::ask() {
  const std::uint64_t now = time_of(loop_);
  if (now >= next_) {
    go();
  } else if (!asked_) {
    asked_ = true;
    timer_.set((next_ - now) / 1000 + 1);
  }
}

void Pace::go() {
  asked_ = false;
  next_ = time_of(loop_) + kLeastPause * 1000;
  call_();
}

}  // namespace mlcca::net
