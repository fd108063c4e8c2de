// SPDX-License-Identifier: BSD-2-Clause
// What probes of the relay have in common: datagrams of the subject "B", and the times of events.
#pragma once
#include <arpa/inet.h>
#include <net/if.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/handle.hpp"

namespace mlcca::bench {

inline constexpr std::uint16_t kPort = 9999;
inline constexpr const char* kGroup = "239.66.0.1";
inline constexpr std::size_t kHeader = 9;  ///< octets of a datagram before the event

[[noreturn]] inline void give_up(const char* what) {
  std::perror(what);
  std::exit(1);  // NOLINT(concurrency-mt-unsafe)
}

template <class Address>
const sockaddr* generic_of(const Address& address) {
  return reinterpret_cast<const sockaddr*>(&address);  // NOLINT(*-reinterpret-cast)
}

/// In the group, on the interface of that address or name. What it sends is not received.
inline Fd udp_socket(const std::string& own, const std::string& interface) {
  Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int on = 1;
  const int off = 0;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (!interface.empty())
    ::setsockopt(socket.get(), SOL_SOCKET, SO_BINDTODEVICE, interface.c_str(),
                 static_cast<socklen_t>(interface.size() + 1));
  ip_mreqn request{};
  ::inet_pton(AF_INET, kGroup, &request.imr_multiaddr);
  if (!own.empty()) ::inet_pton(AF_INET, own.c_str(), &request.imr_address);
  if (!interface.empty())
    request.imr_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  if (::setsockopt(socket.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) != 0)
    give_up("membership");
  ::setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, &request, sizeof request);
  ::setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_LOOP, &off, sizeof off);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(kPort);
  if (::bind(socket.get(), generic_of(address), sizeof address) != 0) give_up("bind");
  return socket;
}

inline sockaddr_in group() {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(kPort);
  ::inet_pton(AF_INET, kGroup, &out.sin_addr);
  return out;
}

inline void print(const char* what, std::vector<std::uint64_t>& ns, std::size_t sent) {
  std::sort(ns.begin(), ns.end());
  if (ns.empty()) give_up("nothing came");
  std::printf("%s %zu of %zu, p50 %.1f us, p99 %.1f us, worst %.1f us\n", what, ns.size(), sent,
              static_cast<double>(ns[ns.size() / 2]) / 1e3,
              static_cast<double>(ns[ns.size() * 99 / 100]) / 1e3,
              static_cast<double>(ns.back()) / 1e3);
}

}  // namespace mlcca::bench
