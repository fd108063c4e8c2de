// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/live.hpp"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/can/raw.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/if_packet.h>
#include <linux/rtnetlink.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <thread>
#include <utility>

#include "base/clock.hpp"
#include "base/handle.hpp"
#include "base/system_error.hpp"
#include "relay/layers/sockets.hpp"
#include "tools/learn/packet_socket.hpp"

namespace mlcca::learn {
namespace {

constexpr int kBuffer = 16 * 1024 * 1024;  // bytes; a second of a bus many times over
constexpr std::size_t kBatch = 256;        // frames that are read from a socket at once
/// Rounds of reading at the end: most of what a socket can hold, though more may arrive meanwhile.
constexpr std::size_t kLastRounds = 64;
constexpr int kAsk = 100;  // ms between calls of `stop`
/// Frames gather in the kernel, which notes their times, and few system calls read them. A bus of
/// 1 Mbit/s brings 40 meanwhile, and a socket without CAP_NET_ADMIN holds some 500.
constexpr std::chrono::milliseconds kGather{5};

template <class T>
bool set(const Fd& socket, int level, int option, const T& value) {
  return ::setsockopt(socket.get(), level, option, &value, sizeof value) == 0;
}

/// The index of an interface; 0 if there is none.
int index_of(const std::string& name) {
  const Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  if (name.size() >= sizeof request.ifr_name) return 0;
  name.copy(request.ifr_name, name.size());
  return ::ioctl(socket.get(), SIOCGIFINDEX, &request) == 0 ? request.ifr_ifindex : 0;
}

/// A frame with its own buffer, so that frames of several sockets can be sorted.
struct Read {
  Frame frame;  ///< its data begins at index `begin` of `bytes`
  std::array<std::uint8_t, kFrameRead> bytes{};
  std::size_t begin = 0;
};

struct Listened {
  Fd socket;
  std::uint32_t number = 0;
  bool ethernet = false;
  std::uint64_t lost = 0;
};

/// Decodes a CAN frame from the bytes; false if it is an error frame.
bool read_can(std::size_t bytes, int flags, Read& one) {
  canfd_frame frame{};
  std::memcpy(&frame, one.bytes.data(), sizeof frame);
  one.frame.id = frame.can_id;
  one.frame.fd = bytes == CANFD_MTU;
  one.frame.local = (flags & MSG_DONTROUTE) != 0;
  one.begin = offsetof(canfd_frame, data);
  one.frame.data = std::span(one.bytes).subspan(one.begin, std::min<std::size_t>(frame.len, 64));
  return (frame.can_id & CAN_ERR_FLAG) == 0;
}

bool read_ethernet_frame(std::size_t bytes, unsigned type, Read& one) {
  const auto all = std::span<const std::uint8_t>(one.bytes).first(std::min(bytes, kFrameRead));
  if (!read_packet(all, type, one.frame)) return false;
  one.begin = static_cast<std::size_t>(one.frame.data.data() - one.bytes.data());
  return true;
}

/// The type of a device, ARPHRD_*; 0 if it is not known.
unsigned device_type(const std::string& name) {
  const Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  name.copy(request.ifr_name, sizeof request.ifr_name - 1);
  return ::ioctl(socket.get(), SIOCGIFHWADDR, &request) == 0 ? request.ifr_hwaddr.sa_family : 0U;
}

Result<Fd> open_can_socket(const std::string& name) {
  Fd socket(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  if (!socket) return system_error(name + ": socket");
  const int on = 1;
  static_cast<void>(set(socket, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, on));
  return socket;
}

Result<void> bind_can_socket(const Fd& socket, const std::string& name, int index) {
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::bind(socket.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
    return system_error(name + ": bind");
  return {};
}

/// Makes the kernel state the time of each frame and the number of lost ones.
Result<void> ask(const Fd& socket) {
  if (!set(socket, SOL_SOCKET, SO_RCVBUFFORCE, kBuffer))
    static_cast<void>(set(socket, SOL_SOCKET, SO_RCVBUF, kBuffer));
  return relay::ask_for_times(socket);
}

class Sockets final : public Listener {
 public:
  Result<void> add(const std::string& name, Interfaces& numbers) {
    const auto medium = medium_of(name);
    if (!medium) return std::unexpected(medium.error());
    const bool ethernet = *medium == Medium::ethernet;
    const int index = index_of(name);
    if (index == 0) return fail(name + ": there is no such interface");  // it has gone meanwhile
    auto socket = ethernet ? open_packet_socket(name) : open_can_socket(name);
    if (!socket) return std::unexpected(socket.error());
    // Frames arrive from bind() on. All of them shall have their time, and room in the buffer.
    if (const auto asked = ask(*socket); !asked) return fail(name + ": " + asked.error().text);
    const auto bound =
        ethernet ? bind_packet_socket(*socket, name, index) : bind_can_socket(*socket, name, index);
    if (!bound) return bound;
    const auto number = numbers.number_of(name, *medium);
    if (number == Interfaces::kMost)
      return fail(fmt::format("{}: {} interfaces are the most", name, Interfaces::kMost));
    all_.push_back({std::move(*socket), number, ethernet, 0});
    return {};
  }

  Result<void> listen(std::uint64_t ns, const std::function<bool()>& stop,
                      const OnFrame& on_frame) override {
    const std::uint64_t end = monotonic_ns() + ns;
    std::vector<pollfd> polled;
    polled.reserve(all_.size());
    for (const Listened& one : all_) polled.push_back({one.socket.get(), POLLIN, 0});
    while (monotonic_ns() < end && !stop()) {
      if (::poll(polled.data(), polled.size(), kAsk) < 0 && errno != EINTR)
        return system_error("poll");
      if (!read_all(on_frame)) return system_error("recvmsg");
      if (!more_) std::this_thread::sleep_for(kGather);
    }
    // What has gathered until now belongs to the time that is over.
    more_ = true;
    for (std::size_t i = 0; more_ && i < kLastRounds; ++i)
      if (!read_all(on_frame)) return system_error("recvmsg");
    return {};
  }

  [[nodiscard]] std::uint64_t lost() const override {
    std::uint64_t sum = 0;
    for (const Listened& one : all_) sum += one.lost;
    return sum;
  }

 private:
  /// Reads from each socket once, and passes the frames on in order of time. False if a socket
  /// fails; then errno says why.
  bool read_all(const OnFrame& on_frame) {
    batch_.clear();
    more_ = false;
    for (Listened& one : all_)
      if (!read(one)) return false;
    std::ranges::stable_sort(batch_, {}, [](const Read& one) { return one.frame.ns; });
    for (Read& one : batch_) {
      // The span referred to the element from which the frame was copied.
      one.frame.data = std::span(one.bytes).subspan(one.begin, one.frame.data.size());
      on_frame(one.frame);
    }
    return true;
  }

  bool read(Listened& from) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      Read& one = batch_.emplace_back();
      sockaddr_ll sender{};
      const relay::Received got =
          relay::receive_into(from.socket, one.bytes.data(), one.bytes.size(),
                              from.ethernet ? &sender : nullptr, from.ethernet ? sizeof sender : 0);
      // An interface that goes down stays in the set, because it may come up again.
      if (got.size < 0) {
        batch_.pop_back();
        return errno == EAGAIN || errno == EINTR || errno == ENETDOWN || errno == ENODEV;
      }
      const auto bytes = static_cast<std::size_t>(got.size);
      one.frame.interface = from.number;
      one.frame.ns = got.beside.unix_ns;
      if (got.beside.says_dropped) from.lost = got.beside.dropped;
      if (!(from.ethernet ? read_ethernet_frame(bytes, sender.sll_pkttype, one)
                          : read_can(bytes, got.flags, one)))
        batch_.pop_back();
    }
    more_ = true;
    return true;
  }

  std::vector<Listened> all_;
  std::vector<Read> batch_;
  bool more_ = false;  ///< a socket may have more than was read at once
};

/// The payload of the attribute of that type; nullopt if there is none.
std::optional<std::span<const std::uint8_t>> attribute(std::span<const std::uint8_t> all,
                                                       std::uint16_t type) {
  while (all.size() >= sizeof(rtattr)) {
    rtattr head{};
    std::memcpy(&head, all.data(), sizeof head);
    if (head.rta_len < sizeof head || head.rta_len > all.size()) return std::nullopt;
    if ((head.rta_type & NLA_TYPE_MASK) == type)
      return all.subspan(sizeof head, head.rta_len - sizeof head);
    all = all.subspan(std::min<std::size_t>(RTA_ALIGN(head.rta_len), all.size()));
  }
  return std::nullopt;
}

/// The first four bytes of an attribute: an integer, or the bit rate in a struct can_bittiming.
std::uint32_t first_number(std::span<const std::uint8_t> data, std::uint16_t type) {
  const auto found = attribute(data, type);
  std::uint32_t number = 0;
  if (found && found->size() >= sizeof number) std::memcpy(&number, found->data(), sizeof number);
  return number;
}

}  // namespace

bool is_interface(const std::string& name) { return index_of(name) != 0; }

Result<Medium> medium_of(const std::string& interface) {
  if (!is_interface(interface)) return fail(interface + ": there is no such interface");
  switch (device_type(interface)) {
    case ARPHRD_CAN:
      return Medium::can;
    case ARPHRD_ETHER:
      return Medium::ethernet;
    case ARPHRD_IEEE802154:
      return fail(interface + ": traffic of IEEE 802.15.4 is not learned yet");
    default:
      return fail(interface + ": is neither a CAN nor an Ethernet interface");
  }
}

bool is_up(const std::string& interface) {
  const Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  interface.copy(request.ifr_name, sizeof request.ifr_name - 1);
  return ::ioctl(socket.get(), SIOCGIFFLAGS, &request) == 0 &&
         (static_cast<unsigned>(request.ifr_flags) & IFF_UP) != 0;
}

namespace {

/// What the kernel states about an interface: the attributes of its link. Empty if it cannot be
/// asked.
std::vector<std::uint8_t> link_of(const std::string& interface) {
  const Fd socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
  struct {
    nlmsghdr head;
    ifinfomsg link;
  } request{};
  request.head.nlmsg_len = sizeof request;
  request.head.nlmsg_type = RTM_GETLINK;
  request.head.nlmsg_flags = NLM_F_REQUEST;
  request.link.ifi_index = index_of(interface);
  const timeval patience{.tv_sec = 1, .tv_usec = 0};
  if (!socket || request.link.ifi_index == 0 || !set(socket, SOL_SOCKET, SO_RCVTIMEO, patience) ||
      ::send(socket.get(), &request, sizeof request, 0) < 0)
    return {};
  std::vector<std::uint8_t> reply(65'536);
  const ssize_t n = ::recv(socket.get(), reply.data(), reply.size(), 0);
  constexpr std::size_t heads = sizeof(nlmsghdr) + sizeof(ifinfomsg);
  if (n < static_cast<ssize_t>(heads)) return {};
  nlmsghdr head{};
  std::memcpy(&head, reply.data(), sizeof head);
  if (head.nlmsg_type != RTM_NEWLINK) return {};
  return {reply.begin() + heads, reply.begin() + n};
}

}  // namespace

Rates rates_of(const std::string& interface) {
  const auto link = link_of(interface);
  Rates out{.queue_length = first_number(link, IFLA_TXQLEN)};
  const auto info = attribute(link, IFLA_LINKINFO);
  if (const auto data = info ? attribute(*info, IFLA_INFO_DATA) : std::nullopt) {
    out.bitrate = first_number(*data, IFLA_CAN_BITTIMING);
    out.data_bitrate = first_number(*data, IFLA_CAN_DATA_BITTIMING);
  }
  return out;
}

std::uint64_t received_on(const std::string& interface) {
  const auto link = link_of(interface);
  const auto found = attribute(link, IFLA_STATS64);
  rtnl_link_stats64 counted{};
  constexpr std::size_t needed = sizeof counted.rx_packets;  // it is the first
  if (!found || found->size() < needed) return 0;
  std::memcpy(&counted.rx_packets, found->data(), needed);
  return counted.rx_packets;
}

Result<std::unique_ptr<Listener>> Listener::open(const std::vector<std::string>& interfaces,
                                                 Interfaces& numbers) {
  auto out = std::make_unique<Sockets>();
  for (const std::string& name : interfaces)
    if (const auto added = out->add(name, numbers); !added) return std::unexpected(added.error());
  return out;
}

}  // namespace mlcca::learn
