// SPDX-License-Identifier: BSD-2-Clause
// The socket that mlccad connects to.
#pragma once
#include <sys/types.h>
#include <systemd/sd-event.h>

#include <array>
#include <functional>
#include <set>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "cluster/bridge.hpp"
#include "daemon/cluster/wire.hpp"
#include "daemon/net/sources/timer.hpp"

namespace mlcca::cluster {

/// One connection at a time: a new one ends the former. It must be of root, of the owner of the
/// socket, or of the user who runs this. What is not understood ends it. Where descriptors or
/// memory are lacking for one, it is tried again a second later, and when the former one ends.
class Server {
 public:
  using Log = std::function<void(const std::string&)>;
  Server(sd_event* loop, Fd listening, Bridge& bridge, Log log);

  [[nodiscard]] Result<void> start();

 private:
  static int on_connection(sd_event_source*, int, std::uint32_t, void* self) noexcept;
  static int on_io(sd_event_source*, int, std::uint32_t events, void* self) noexcept;
  void accept();
  void rest(int error);
  void receive();
  bool take(std::size_t size);
  void send();
  void listen_for(bool output);
  void end(const std::string& why);

  sd_event* loop_;
  Fd listening_;
  Bridge& bridge_;
  Log log_;
  std::set<uid_t> trusted_;
  net::EventSource connections_;
  net::Timer accept_again_;
  bool rests_ = false;  ///< no connection can be taken: it was said
  Fd socket_;
  net::EventSource io_;
  wire::ReaderOfGateway reader_;
  std::array<char, wire::kMaxMessage> buffer_{};
  bool full_ = false;  ///< mlccad does not read as fast as we send
};

}  // namespace mlcca::cluster
