// SPDX-License-Identifier: BSD-2-Clause
// What is between mlcca-cluster and a member of the store, and a reader that is slow.
#pragma once
#include <systemd/sd-event.h>

#include <array>
#include <cstdint>
#include <limits>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/handle.hpp"
#include "base/loop_timer.hpp"
#include "daemon/cluster/wire.hpp"

namespace mlcca::test {

/// A port whose connections go on to another one of the loopback.
class Tunnel {
 public:
  Tunnel(sd_event* loop, int to);
  [[nodiscard]] int port() const { return port_; }
  /// The server takes what comes, and its next octets end the connection instead of arriving: as
  /// if the server had closed it, or by a reset.
  void cut_at_next_answer(bool resets) {
    cuts_ = true;
    resets_ = resets;
  }
  /// After so many octets of the server nothing goes on in either direction, of each connection,
  /// and the client can send. `half_closes`: the client is told that no more octets will come.
  /// Without a number: of the present connections, from now on.
  void fall_silent(std::size_t after, bool half_closes);
  void fall_silent(bool half_closes);
  [[nodiscard]] std::size_t octets_of_server() const { return octets_of_server_; }
  [[nodiscard]] std::size_t connections() const { return pairs_.size(); }
  /// Nothing goes on in either direction, of new connections neither.
  void hold(bool holds);

 private:
  struct Pair {
    Fd client, server;
    EventSource from_client, from_server;
    std::size_t left = std::numeric_limits<std::size_t>::max();  ///< octets of the server
  };
  static int on_connection(sd_event_source*, int, std::uint32_t, void* self) noexcept;
  static int on_octets(sd_event_source*, int fd, std::uint32_t, void* self) noexcept;
  void accept();
  void pass(int fd);
  void silence(Pair& pair, bool half_closes);

  sd_event* loop_;
  int to_;
  int port_ = 0;
  bool cuts_ = false;
  bool resets_ = false;
  bool holds_ = false;
  std::size_t after_ = std::numeric_limits<std::size_t>::max();
  bool half_closes_ = false;
  std::size_t octets_of_server_ = 0;
  Fd listening_;
  EventSource connections_;
  std::list<Pair> pairs_;
};

/// Reads messages one by one, with as much credit as it is told to give.
class SlowReader {
 public:
  SlowReader(const std::string& socket, std::vector<std::string> prefixes);
  void give_credit(std::uint32_t entries);
  /// Reads up to the next one of its kind; false: it does not come.
  template <class Kind>
  bool read_until() {
    constexpr int most = 1000;  // messages
    for (int i = 0; i < most; ++i) {
      const auto message = next();
      if (!message) return false;
      if (std::holds_alternative<Kind>(*message)) return true;
    }
    return false;
  }
  [[nodiscard]] std::int64_t revision() const { return revision_; }
  [[nodiscard]] std::size_t entries() const { return entries_; }

 private:
  std::optional<ClusterMessage> next();

  Fd socket_;
  cluster::wire::ReaderOfStore reader_;
  std::array<char, cluster::wire::kMaxMessage> buffer_{};
  std::int64_t revision_ = 0;
  std::size_t entries_ = 0;  ///< since the latest snapshot began
};

}  // namespace mlcca::test
