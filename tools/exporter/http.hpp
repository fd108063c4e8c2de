// SPDX-License-Identifier: BSD-2-Clause
// The HTTP server of mlcca-exporter.
#pragma once
#include <microhttpd.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::exporter {

/// Answers GET /metrics over HTTP/1.1 by GNU libmicrohttpd, in the only thread of the program. The
/// resources that clients can use are bounded: 16 connections at once, one request and 20 s (1 s
/// while further ones wait) for each of them, and 16 KiB for the header of a request.
class Http {
 public:
  /// Makes the body of the answer to /metrics.
  using Page = std::function<std::string()>;

  /// Serves on `listening`, a listening socket that does not block. It is duplicated.
  static Result<std::unique_ptr<Http>> serve(const Fd& listening, Page page);

  /// A descriptor that is readable when turn() has something to do; -1 if only the time of
  /// patience() is to be waited for.
  [[nodiscard]] int fd() const { return rests_since_ ? -1 : fd_; }
  /// The longest time in ms after which turn() must be called.
  [[nodiscard]] int patience() const;
  void turn();
  /// Whether there is no connection.
  [[nodiscard]] bool is_idle() const { return since_.empty(); }

 private:
  explicit Http(Page page) : page_(std::move(page)) {}
  [[nodiscard]] bool is_awaited() const;
  static MHD_Result on_request(void* self, MHD_Connection* connection, const char* url,
                               const char* method, const char* version, const char* upload,
                               std::size_t* upload_size, void** state) noexcept;
  static void on_connection(void* self, MHD_Connection* connection, void** state,
                            MHD_ConnectionNotificationCode what) noexcept;

  Page page_;
  int fd_ = -1;
  int listening_ = -1;
  std::uint64_t accepted_ = 0;                ///< number of accepted connections so far
  std::optional<std::uint64_t> rests_since_;  ///< since when none can be accepted, monotonic ns
  /// Time at which each connection was accepted, monotonic ns, by socket.
  std::map<int, std::uint64_t> since_;
  std::unique_ptr<MHD_Daemon, FreeWith<MHD_stop_daemon>> daemon_;
};

}  // namespace mlcca::exporter
