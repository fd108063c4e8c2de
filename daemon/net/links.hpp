// SPDX-License-Identifier: BSD-2-Clause
// The interfaces of the kernel (rtnetlink), and the few settings that we change.
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

/// One interface.
struct Link {
  int ifindex = 0;
  std::string name;
  std::string kind;  ///< "can", "vcan", "vxcan", …; empty: a device without rtnl_link_ops
  std::string alias;
  bool is_can = false;             ///< ARPHRD_CAN
  bool is_ethernet = false;        ///< ARPHRD_ETHER
  bool is_wpan = false;            ///< ARPHRD_IEEE802154
  bool up = false;                 ///< administratively up
  bool running = false;            ///< up, and its medium is there: it has a carrier
  std::string can_state;           ///< "error-active", "error-warning", "error-passive", "bus-off",
                                   ///< "stopped", "sleeping"; empty: the driver has none
  std::uint32_t bitrate = 0;       ///< bit/s, 0: unknown
  std::uint32_t data_bitrate = 0;  ///< bit/s, 0: unknown or classic only

  bool operator==(const Link&) const = default;
};

/// Counters of an interface since it was created.
struct Traffic {
  std::uint64_t sent_frames = 0;
  std::uint64_t sent_bytes = 0;
  std::uint64_t received_frames = 0;
  std::uint64_t received_bytes = 0;
  std::uint64_t send_drops = 0;  ///< frames
};

/// The interfaces by index.
using InterfaceTable = std::map<int, Link>;

/// The kernel's answer to a request for one interface by its index.
enum class Presence : std::uint8_t {
  there,
  gone,     ///< this network namespace has no interface with this index
  unknown,  ///< the kernel has not answered
};

/// A table of all interfaces, which follows the notifications of rtnetlink.
class Links final : public LinkMonitor {
 public:
  /// Joins the groups of links and of traffic control first and then reads the table, so that no
  /// change is missed.
  static Result<Links> open();

  /// Readable if something has changed.
  [[nodiscard]] int fd() const override { return notices_.get(); }
  /// Reads the notifications and the table again. True if it differs, or an interface has gone.
  /// After an error the table is unchanged.
  Result<bool> refresh() override;
  /// Why the table may be out of date, so that refresh() is to be called soon; empty if it could be
  /// read.
  [[nodiscard]] const std::string& problem() const override { return problem_; }
  [[nodiscard]] const InterfaceTable& table() const { return table_; }
  /// The name of an interface; its index in digits if it is unknown.
  [[nodiscard]] std::string name_of(int ifindex) const override {
    const auto known = table_.find(ifindex);
    return known != table_.end() ? known->second.name : std::to_string(ifindex);
  }
  /// Whether a filter or a queueing discipline has appeared, changed or gone since the last call.
  [[nodiscard]] bool take_tc_changed() override { return std::exchange(tc_changed_, false); }
  struct Moved {
    int ifindex = 0;  ///< that it had in this namespace
    std::string name;
  };
  /// The interfaces that have moved to another network namespace since the last call.
  [[nodiscard]] std::vector<Moved> take_moved() { return std::exchange(moved_, {}); }
  /// The interfaces that have gone since the last call, as the kernel has reported for each.
  /// Another interface may have such an index now.
  [[nodiscard]] std::set<int> take_gone() { return std::exchange(gone_, {}); }

  /// Asks the kernel for one interface.
  [[nodiscard]] Presence presence(int ifindex);
  [[nodiscard]] Result<Traffic> traffic(int ifindex);

  /// Sets bit rates in bit/s; 0 leaves a rate unchanged. The interface must be down.
  Result<void> set_bitrates(int ifindex, std::uint32_t bitrate, std::uint32_t data_bitrate);
  Result<void> set_up(int ifindex, bool up);

 private:
  explicit Links(Fd notices) : notices_(std::move(notices)) {}
  Result<InterfaceTable> read();
  void receive();
  void take_notices(const char* notices, std::size_t size);

  Fd notices_;
  Rtnl kernel_;
  InterfaceTable table_;
  std::vector<char> received_;
  std::string problem_;
  bool tc_changed_ = false;
  std::vector<Moved> moved_;
  std::set<int> gone_;
};

}  // namespace mlcca::net
