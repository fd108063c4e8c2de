// SPDX-License-Identifier: BSD-2-Clause
// A server on the loopback that answers on the loop of the test.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "base/handle.hpp"

namespace mlcca::test {

class Server {
 public:
  /// What to send after the given line; an empty text closes the connection.
  using Answer = std::function<std::string(const std::string& line)>;

  /// `greeting` is sent to whoever connects. `closes`: after each answer.
  Server(sd_event* loop, std::string greeting, bool closes, Answer answer);

  /// "127.0.0.1:PORT", the same for the life of this object.
  [[nodiscard]] std::string endpoint() const;
  void send_all(const std::string& text);
  /// Hangs up; whoever connects later is served.
  void drop_all() { clients_.clear(); }

 private:
  using Source = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_disable_unref>>;
  struct Client {
    Fd socket;
    Source source;
    std::string input;
  };
  static int on_connection(sd_event_source*, int fd, std::uint32_t, void* self);
  static int on_input(sd_event_source*, int fd, std::uint32_t, void* self);

  sd_event* loop_;
  std::string greeting_;
  bool closes_;
  Answer answer_;
  Fd listening_;
  Source source_;
  std::map<int, Client> clients_;
};

}  // namespace mlcca::test
