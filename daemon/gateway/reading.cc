// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/reading.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <system_error>
#include <thread>
#include <utility>

#include "base/clock.hpp"

namespace mlcca {

bool Reading::begin(std::function<void()> work, std::function<void()> done) {
  if (busy()) return false;
  auto ended = std::make_shared<Fd>(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  sd_event_source* raw = nullptr;
  if (!*ended || sd_event_add_io(loop_, &raw, ended->get(), EPOLLIN, on_end, this) < 0)
    return false;
  source_.reset(raw);
  ended_ = ended;
  try {
    std::thread([work = std::move(work), ended = std::move(ended)]() mutable {
      work();
      work = nullptr;
      const std::uint64_t one = 1;
      static_cast<void>(::write(ended->get(), &one, sizeof one) < 0);
    }).detach();
  } catch (const std::system_error&) {  // no thread could be made
    source_.reset();
    return false;
  }
  begun_ = monotonic_ns();
  done_ = std::move(done);
  return true;
}

void Reading::forget() { done_ = nullptr; }

int Reading::on_end(sd_event_source*, int, std::uint32_t, void* self) noexcept {
  auto& reading = *static_cast<Reading*>(self);
  reading.source_.reset();
  reading.ended_.reset();
  if (auto done = std::exchange(reading.done_, nullptr)) done();
  return 0;
}

}  // namespace mlcca
