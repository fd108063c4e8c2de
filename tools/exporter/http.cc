// SPDX-License-Identifier: BSD-2-Clause
#include "tools/exporter/http.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string_view>

#include "base/clock.hpp"
#include "tools/exporter/exposition.hpp"

namespace mlcca::exporter {
namespace {

constexpr unsigned kConnections = 16;
constexpr unsigned kQuiet = 10;         // s without any traffic of the connection
constexpr std::uint64_t kLongest = 20;  // s for a connection, whatever is sent
constexpr std::uint64_t kWaitedFor =
    1;  // s for a connection while another one waits to be accepted
constexpr std::size_t kRequestMemory = 16UL * 1024;
constexpr std::uint64_t kSecond = 1'000'000'000;  // ns
constexpr int kRound = 1000;                      // ms

constexpr std::string_view kNotFound = "Metrics are at /metrics.\n";
constexpr std::string_view kNotAllowed = "Only GET and HEAD are possible.\n";

MHD_Result answer(MHD_Connection* connection, unsigned status, std::string_view body,
                  const char* content_type) {
  const std::unique_ptr<MHD_Response, FreeWith<MHD_destroy_response>> response(
      // The function copies the bytes, although its parameter is not const.
      MHD_create_response_from_buffer(body.size(),
                                      const_cast<char*>(body.data()),  // NOLINT(*-const-cast)
                                      MHD_RESPMEM_MUST_COPY));
  if (!response) return MHD_NO;
  MHD_add_response_header(response.get(), MHD_HTTP_HEADER_CONTENT_TYPE, content_type);
  // A connection has one request, so its time limit is that of the request.
  MHD_add_response_header(response.get(), MHD_HTTP_HEADER_CONNECTION, "close");
  if (status == MHD_HTTP_METHOD_NOT_ALLOWED)
    MHD_add_response_header(response.get(), MHD_HTTP_HEADER_ALLOW, "GET, HEAD");
  return MHD_queue_response(connection, status, response.get());
}

}  // namespace

MHD_Result Http::on_request(void* self, MHD_Connection* connection, const char* url,
                            const char* method, const char* /*version*/, const char* /*upload*/,
                            std::size_t* upload_size,  // NOLINT(readability-non-const-parameter)
                            void** state) noexcept {
  constexpr const char* text = "text/plain; charset=utf-8";
  const std::string_view asked(method);
  // Checked at once, before a body has come.
  if (asked != MHD_HTTP_METHOD_GET && asked != MHD_HTTP_METHOD_HEAD)
    return answer(connection, MHD_HTTP_METHOD_NOT_ALLOWED, kNotAllowed, text);
  // The first call comes after the header, the last one when the request is complete.
  static char seen = 0;
  if (*state == nullptr) {
    *state = &seen;
    return MHD_YES;
  }
  if (*upload_size != 0) return MHD_NO;  // the body of a GET
  if (std::string_view(url) != "/metrics")
    return answer(connection, MHD_HTTP_NOT_FOUND, kNotFound, text);
  return answer(connection, MHD_HTTP_OK, static_cast<Http*>(self)->page_(), kContentType);
}

void Http::on_connection(void* self, MHD_Connection* connection, void** /*state*/,
                         MHD_ConnectionNotificationCode what) noexcept {
  const auto* info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
  if (info == nullptr) return;
  auto& http = *static_cast<Http*>(self);
  if (what == MHD_CONNECTION_NOTIFY_STARTED) {
    ++http.accepted_;
    http.since_[info->connect_fd] = monotonic_ns();
  } else {
    http.since_.erase(info->connect_fd);
  }
}

Result<std::unique_ptr<Http>> Http::serve(const Fd& listening, Page page) {
  std::unique_ptr<Http> http(new Http(std::move(page)));
  // MHD_stop_daemon closes the descriptor that it is given.
  const int given = ::fcntl(listening.get(), F_DUPFD_CLOEXEC, 0);  // NOLINT(*-vararg)
  http->daemon_.reset(MHD_start_daemon(                            // NOLINT(*-vararg)
      MHD_USE_EPOLL, 0, nullptr, nullptr, on_request, http.get(), MHD_OPTION_LISTEN_SOCKET, given,
      MHD_OPTION_CONNECTION_LIMIT, kConnections, MHD_OPTION_CONNECTION_TIMEOUT, kQuiet,
      MHD_OPTION_CONNECTION_MEMORY_LIMIT, kRequestMemory, MHD_OPTION_NOTIFY_CONNECTION,
      on_connection, http.get(), MHD_OPTION_END));
  if (!http->daemon_)
    // NOLINTNEXTLINE(concurrency-mt-unsafe): one thread
    return fail(std::string("cannot serve HTTP: ") + std::strerror(errno));
  const auto* info = MHD_get_daemon_info(http->daemon_.get(), MHD_DAEMON_INFO_EPOLL_FD);
  if (info == nullptr) return fail("cannot serve HTTP: no descriptor to wait for");
  http->fd_ = info->epoll_fd;
  http->listening_ = given;
  return http;
}

int Http::patience() const {
  std::uint64_t ms = kRound;
  if (MHD_UNSIGNED_LONG_LONG wanted = 0; MHD_get_timeout(daemon_.get(), &wanted) == MHD_YES)
    ms = std::min<std::uint64_t>(ms, wanted);
  return static_cast<int>(ms);
}

/// Whether a connection waits to be accepted.
bool Http::is_awaited() const {
  pollfd waiting{.fd = listening_, .events = POLLIN, .revents = 0};
  return ::poll(&waiting, 1, 0) > 0;
}

void Http::turn() {
  const std::uint64_t now = monotonic_ns();
  if (rests_since_ && now - *rests_since_ < kSecond) return;
  rests_since_.reset();
  // Connections that are too old are shut down here, because the limit of libmicrohttpd starts
  // again with each byte.
  const bool awaited = is_awaited();
  const std::uint64_t longest = awaited && since_.size() >= kConnections ? kWaitedFor : kLongest;
  for (const auto& [connection, since] : since_)
    if (now - since > longest * kSecond) ::shutdown(connection, SHUT_RDWR);
  const std::uint64_t accepted = accepted_;
  MHD_run(daemon_.get());
  // It accepted nothing, for lack of descriptors or memory. While there are connections,
  // libmicrohttpd waits for the end of one. Without any, the socket would stay readable, and the
  // loop would spin.
  if (awaited && accepted_ == accepted && is_idle() && is_awaited()) rests_since_ = now;
}

}  // namespace mlcca::exporter
