// SPDX-License-Identifier: BSD-2-Clause
// The interfaces as the kernel has them (rtnetlink), and the few things we set on them.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/result.hpp"

struct nl_sock;

namespace mlcca::net {

struct Link {
  int ifindex = 0;
  std::string name;
  std::string kind;  ///< "can", "vcan", "vxcan", …; empty: a device without rtnl_link_ops
  std::string alias;
  bool is_can = false;             ///< ARPHRD_CAN
  bool up = false;                 ///< administratively
  std::string can_state;           ///< "error-active", "error-warning", "error-passive", "bus-off",
                                   ///< "stopped", "sleeping"; empty: the driver has none
  std::uint32_t bitrate = 0;       ///< bit/s, 0: unknown
  std::uint32_t data_bitrate = 0;  ///< bit/s, 0: unknown or classic only

  bool operator==(const Link&) const = default;
};

/// Counters of an interface since it was made.
struct Traffic {
  std::uint64_t sent_frames = 0;
  std::uint64_t sent_bytes = 0;
  std::uint64_t received_frames = 0;
  std::uint64_t received_bytes = 0;
  std::uint64_t send_drops = 0;  ///< frames
};

/// By ifindex.
using LinkTable = std::map<int, Link>;

class Links {
 public:
  /// Joins the groups of links and of traffic control first and reads the table then, so that no
  /// change is missed.
  static Result<Links> open();
  Links(Links&&) noexcept;
  Links& operator=(Links&&) noexcept;
  ~Links();

  /// Readable when something changed.
  [[nodiscard]] int fd() const;
  /// Takes all notifications off the socket and reads the table anew. True if it differs.
  Result<bool> refresh();
  [[nodiscard]] const LinkTable& table() const { return table_; }
  /// Of an interface, or its index where it is unknown.
  [[nodiscard]] std::string name_of(int ifindex) const {
    const auto known = table_.find(ifindex);
    return known != table_.end() ? known->second.name : std::to_string(ifindex);
  }
  /// A filter or a queueing discipline came, changed or went since the last call.
  [[nodiscard]] bool take_tc_changed() { return std::exchange(tc_changed_, false); }
  struct Moved {
    int ifindex = 0;  ///< that it had here
    std::string name;
  };
  /// Links that went to another network namespace since the last call.
  [[nodiscard]] std::vector<Moved> take_moved() { return std::exchange(moved_, {}); }

  /// Asks the kernel now.
  [[nodiscard]] Result<Traffic> traffic(int ifindex);

  /// Bit rates in bit/s, 0 leaves one alone. The interface must be down.
  Result<void> set_bitrates(int ifindex, std::uint32_t bitrate, std::uint32_t data_bitrate);
  Result<void> set_up(int ifindex, bool up);

 private:
  struct FreeSocket {
    void operator()(nl_sock* socket) const noexcept;
  };
  using Socket = std::unique_ptr<nl_sock, FreeSocket>;
  Links(Socket notices, Socket requests);
  Result<LinkTable> read();
  void take_notices(const char* notices, std::size_t size);

  Socket notices_;
  Socket requests_;
  LinkTable table_;
  bool tc_changed_ = false;
  std::vector<Moved> moved_;
};

}  // namespace mlcca::net
