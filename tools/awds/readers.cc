// SPDX-License-Identifier: BSD-2-Clause
#include "tools/awds/readers.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>

#include <cerrno>
#include <utility>

#include "base/system_error.hpp"

namespace mlcca::awds {

Result<void> Readers::start() {
  sd_event_source* raw = nullptr;
  const int e = sd_event_add_io(loop_, &raw, listening_.get(), EPOLLIN, on_connection, this);
  if (e < 0) return system_error("watching the socket", -e);
  source_.reset(raw);
  return {};
}

void Readers::send(std::span<const std::uint8_t> packet) const {
  // Accepts again, if there were no descriptors when a reader connected.
  sd_event_source_set_enabled(source_.get(), SD_EVENT_ON);
  // NOLINTBEGIN(bugprone-unused-return-value): who has hung up is noticed by on_hangup
  for (const auto& [fd, reader] : readers_)
    (void)::send(fd, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  // NOLINTEND(bugprone-unused-return-value)
}

int Readers::on_connection(sd_event_source*, int listening, std::uint32_t, void* self) noexcept {
  auto& readers = *static_cast<Readers*>(self);
  Fd socket(::accept4(listening, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  // Otherwise the socket would stay readable, and the loop would spin.
  if (!socket && errno != EAGAIN && errno != EINTR && errno != ECONNABORTED)
    sd_event_source_set_enabled(readers.source_.get(), SD_EVENT_OFF);
  if (!socket || readers.readers_.size() >= kMost) return 0;
  const int fd = socket.get();
  sd_event_source* raw = nullptr;
  // Readers send nothing; only the end of their connections is awaited.
  if (sd_event_add_io(readers.loop_, &raw, fd, EPOLLRDHUP, on_hangup, self) < 0) return 0;
  readers.readers_.insert_or_assign(fd, Reader{std::move(socket), Source(raw)});
  return 0;
}

int Readers::on_hangup(sd_event_source*, int fd, std::uint32_t, void* self) noexcept {
  static_cast<Readers*>(self)->readers_.erase(fd);
  sd_event_source_set_enabled(static_cast<Readers*>(self)->source_.get(), SD_EVENT_ON);
  return 0;
}

}  // namespace mlcca::awds
