// SPDX-License-Identifier: BSD-2-Clause
// GET /metrics over HTTP/1.1, by GNU libmicrohttpd, in the one thread of the program. A request has
// at most 16 KiB in front of its body, a connection one request and 20 s, and there are at most 16
// connections at once: whoever can reach the port cannot hold more.
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

class Http {
 public:
  /// What a request of /metrics is answered with.
  using Page = std::function<std::string()>;

  /// Answers at `listening`, which does not block.
  static Result<std::unique_ptr<Http>> serve(const Fd& listening, Page page);

  /// Can be read when turn() has something to do. -1: nothing is to be waited for but patience().
  [[nodiscard]] int fd() const { return rests_since_ ? -1 : fd_; }
  /// ms until turn() has something to do in any case.
  [[nodiscard]] int patience() const;
  void turn();
  /// Nobody is connected.
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
  std::uint64_t accepted_ = 0;                ///< connections
  std::optional<std::uint64_t> rests_since_;  ///< none can be accepted, monotonic ns
  std::map<int, std::uint64_t> since_;        ///< when each connection was made, monotonic ns
  std::unique_ptr<MHD_Daemon, FreeWith<MHD_stop_daemon>> daemon_;
};

}  // namespace mlcca::exporter
