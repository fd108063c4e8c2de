// SPDX-License-Identifier: BSD-2-Clause
// The server of the control socket of mlcca-cluster, to which mlccad connects.
#pragma once
#include <sys/types.h>
#include <systemd/sd-event.h>

#include <array>
#include <functional>
#include <set>
#include <string>

#include "base/handle.hpp"
#include "base/loop_timer.hpp"
#include "base/result.hpp"
#include "cluster/bridge.hpp"
#include "daemon/cluster/wire.hpp"

namespace mlcca::cluster {

/// Accepts the connection of mlccad and passes its messages to the Bridge. There is one connection
/// at a time, and a new one ends the former. The peer must be root, the owner of the socket, or the
/// user who runs this program. A message that cannot be understood ends the connection. If
/// descriptors or memory are lacking for a connection, it is accepted one second later, or when the
/// former one ends.
class DaemonServer {
 public:
  using Log = std::function<void(const std::string&)>;
  DaemonServer(sd_event* loop, Fd listening, Bridge& bridge, Log log);

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
  EventSource connections_;
  LoopTimer accept_again_;
  bool rests_ = false;  ///< no connection can be accepted, and that was logged
  Fd socket_;
  EventSource io_;
  wire::ReaderOfGateway reader_;
  std::array<char, wire::kMaxMessage> buffer_{};
  bool full_ = false;  ///< the socket is full, because mlccad does not read fast enough
};

}  // namespace mlcca::cluster
