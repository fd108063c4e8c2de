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
inline constexpr std::size_t kHeader = 9;  ///< octets of a datagram before the event

[[noreturn]] inline void give_up(const char* what) {
  std::perror(what);
  std::exit(1);  // NOLINT(concurrency-mt-unsafe)
}

template <class Address>
const sockaddr* generic_of(const Address& address) {
  return reinterpret_cast<const sockaddr*>(&address);  // NOLINT(*-reinterpret-cast)
}

/// The group of a subject that is one character and seven octets of 0.
inline sockaddr_in group(char subject = 'B') {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(kPort);
  out.sin_addr.s_addr = htonl(239U << 24U | static_cast<std::uint32_t>(subject) << 16U | 1U);
  return out;
}

/// A mebibyte, as the relay asks for and gets as much of as others; root gets more.
inline void widen(const Fd& socket) {
  constexpr int asked = 1 << 20;
  constexpr int of_root = 16 << 20;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUF, &asked, sizeof asked);
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUFFORCE, &of_root, sizeof of_root);
}

/// On the interface of that address or name.
inline ip_mreqn membership(const std::string& own, const std::string& interface, char subject) {
  ip_mreqn request{};
  request.imr_multiaddr = group(subject).sin_addr;
  if (!own.empty()) ::inet_pton(AF_INET, own.c_str(), &request.imr_address);
  if (!interface.empty())
    request.imr_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  return request;
}

inline void join(const Fd& socket, const ip_mreqn& request) {
  if (::setsockopt(socket.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) != 0)
    give_up("membership");
}

/// In the group, on the interface of that address or name. What it sends is not received there.
inline Fd udp_socket(const std::string& own, const std::string& interface, char subject = 'B') {
  Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int on = 1;
  const int off = 0;
  widen(socket);
  ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (!interface.empty())
    ::setsockopt(socket.get(), SOL_SOCKET, SO_BINDTODEVICE, interface.c_str(),
                 static_cast<socklen_t>(interface.size() + 1));
  const ip_mreqn request = membership(own, interface, subject);
  join(socket, request);
  ::setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, &request, sizeof request);
  ::setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_LOOP, &off, sizeof off);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(kPort);
  if (!socket || ::bind(socket.get(), generic_of(address), sizeof address) != 0) give_up("bind");
  return socket;
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
