// SPDX-License-Identifier: BSD-2-Clause
// The interfaces as the kernel has them (rtnetlink), and the few things we set on them.
#pragma once
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/net/rtnl.hpp"
#include "daemon/outside/link_monitor.hpp"

namespace mlcca::net {

struct Link {
  int ifindex = 0;
  std::string name;
  std::string kind;  ///< "can", "vcan", "vxcan", …; empty: a device without rtnl_link_ops
  std::string alias;
  bool is_can = false;             ///< ARPHRD_CAN
  bool is_ethernet = false;        ///< ARPHRD_ETHER
  bool is_wpan = false;            ///< ARPHRD_IEEE802154
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

/// What the kernel says when it is asked for one interface by its number.
enum class Presence : std::uint8_t {
  there,
  gone,     ///< no interface of this network namespace has the number
  unknown,  ///< it has not answered
};

class Links final : public LinkMonitor {
 public:
  /// Joins the groups of links and of traffic control first and reads the table then, so that no
  /// change is missed.
  static Result<Links> open();

  /// Readable when something changed.
  [[nodiscard]] int fd() const override { return notices_.get(); }
  /// Takes the notifications off the socket and reads the table again. True if it differs, or an
  /// interface has gone. After an error the table is what it was.
  Result<bool> refresh() override;
  /// Why the table may not be what is there: refresh() soon. Empty: it could be read.
  [[nodiscard]] const std::string& problem() const override { return problem_; }
  [[nodiscard]] const LinkTable& table() const { return table_; }
  /// Of an interface, or its index where it is unknown.
  [[nodiscard]] std::string name_of(int ifindex) const override {
    const auto known = table_.find(ifindex);
    return known != table_.end() ? known->second.name : std::to_string(ifindex);
  }
  /// A filter or a queueing discipline came, changed or went since the last call.
  [[nodiscard]] bool take_tc_changed() override { return std::exchange(tc_changed_, false); }
  struct Moved {
    int ifindex = 0;  ///< that it had here
    std::string name;
  };
  /// Links that went to another network namespace since the last call.
  [[nodiscard]] std::vector<Moved> take_moved() { return std::exchange(moved_, {}); }
  /// Interfaces that have gone since the last call, as the kernel has reported of each; another one
  /// may have such a number now.
  [[nodiscard]] std::set<int> take_gone() { return std::exchange(gone_, {}); }

  /// Asks the kernel now.
  [[nodiscard]] Presence presence(int ifindex);
  [[nodiscard]] Result<Traffic> traffic(int ifindex);

  /// Bit rates in bit/s, 0 leaves one alone. The interface must be down.
  Result<void> set_bitrates(int ifindex, std::uint32_t bitrate, std::uint32_t data_bitrate);
  Result<void> set_up(int ifindex, bool up);

 private:
  explicit Links(Fd notices) : notices_(std::move(notices)) {}
  Result<LinkTable> read();
  void receive();
  void take_notices(const char* notices, std::size_t size);

  Fd notices_;
  Rtnl kernel_;
  LinkTable table_;
  std::vector<char> received_;
  std::string problem_;
  bool tc_changed_ = false;
  std::vector<Moved> moved_;
  std::set<int> gone_;
};

}  // namespace mlcca::net
