// SPDX-License-Identifier: BSD-2-Clause
// awds-emulator INTERFACE NODES [BEACON_MS]: a chain of AWDS nodes 1 - 2 - … - NODES that all send
// on one interface: beacons, and topology floods with a copy for each node that relays them, in the
// periods of AWDS. Commands on standard input, until its end:
//   quality X Y Q   what X says of Y from now on, in its next flood
//   drop X          X stops sending; its neighbours notice after 8 beacons and flood at once
#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <sstream>

#include "base/handle.hpp"
#include "tests/tools/sources/proto_emulated.hpp"

namespace {

using mlcca::Fd;
using mlcca::test::Octets;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

class Emulator {
 public:
  Emulator(const char* interface, unsigned nodes, milliseconds beacons)
      : beacons_(beacons), socket_(::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    to_.sll_family = AF_PACKET;
    to_.sll_protocol = htons(0x8334);
    to_.sll_ifindex = static_cast<int>(::if_nametoindex(interface));
    to_.sll_halen = 6;
    std::fill_n(std::begin(to_.sll_addr), 6, 0xff);
    for (unsigned i = 1; i <= nodes; ++i) {
      alive_.insert(i);
      if (i > 1) qualities_[i][i - 1] = qualities_[i - 1][i] = 1;
    }
  }

  /// 1: the interface or the packet socket is not there.
  int run() {
    if (!socket_ || to_.sll_ifindex == 0) return 1;
    auto next_beacon = Clock::now();
    auto next_flood = next_beacon;
    while (true) {
      const auto now = Clock::now();
      if (now >= next_beacon) {
        send_beacons();
        next_beacon = now + beacons_;
      }
      if (notice_silence(now) || now >= next_flood) {
        send_floods();
        next_flood = now + period();
      }
      const auto wait = std::min(next_beacon, next_flood) - now;
      pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
      const auto ms = std::chrono::duration_cast<milliseconds>(wait).count() + 1;
      if (::poll(&input, 1, static_cast<int>(ms)) == 1 && !read_commands()) return 0;
    }
  }

 private:
  /// floor(800 n^2 / isqrt(16 n)) ms
  [[nodiscard]] milliseconds period() const {
    const auto n = static_cast<unsigned>(alive_.size());
    const auto root = static_cast<unsigned>(std::sqrt(16.0 * n));
    return milliseconds(root == 0 ? 1000 : 800 * n * n / root);
  }

  void send(const Octets& packet) const {
    const auto sent = ::sendto(socket_.get(), packet.data(), packet.size(), 0,
                               reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
    // An interface that is down or gone receives nothing: just like a radio that is switched off.
    if (sent < 0 && errno != ENETDOWN && errno != ENXIO) std::perror("send");
  }

  void send_beacons() {
    for (const unsigned node : alive_) {
      std::vector<unsigned> neighbours;
      for (const auto& [neighbour, quality] : qualities_[node]) neighbours.push_back(neighbour);
      const auto period_ms = static_cast<std::uint16_t>(beacons_.count());
      send(mlcca::test::beacon(node, sequence_[node]++, period_ms, neighbours));
    }
  }

  void send_floods() {
    const auto validity = static_cast<std::uint32_t>(3 * period().count());
    for (const unsigned node : alive_) {
      mlcca::test::TopologyFlood flood{.node = node,
                                       .sequence = sequence_[node]++,
                                       .last_hop = node,
                                       .ttl = 32,
                                       .validity_ms = validity,
                                       .qualities = qualities_[node],
                                       .name = "node" + std::to_string(node)};
      send(mlcca::test::topology(flood));
      for (const unsigned relay : alive_) {
        if (relay == node) continue;
        flood.last_hop = relay;
        flood.ttl = static_cast<std::uint8_t>(
            32 - std::abs(static_cast<int>(relay) - static_cast<int>(node)));
        send(mlcca::test::topology(flood));
      }
    }
  }

  /// True if a neighbour of a node that stopped sending has lost its link.
  bool notice_silence(Clock::time_point now) {
    bool lost = false;
    for (auto it = stopped_.begin(); it != stopped_.end();) {
      if (now - it->second < 8 * beacons_) {
        ++it;
        continue;
      }
      for (auto& [node, neighbours] : qualities_) lost |= neighbours.erase(it->first) > 0;
      it = stopped_.erase(it);
    }
    return lost;
  }

  /// False at the end of the input.
  bool read_commands() {
    std::array<char, 4096> chunk{};
    const auto size = ::read(STDIN_FILENO, chunk.data(), chunk.size());
    if (size <= 0) return false;
    input_.append(chunk.data(), static_cast<std::size_t>(size));
    for (auto end = input_.find('\n'); end != std::string::npos; end = input_.find('\n')) {
      obey(input_.substr(0, end));
      input_.erase(0, end + 1);
    }
    return true;
  }

  void obey(const std::string& line) {
    std::istringstream words(line);
    std::string verb;
    unsigned from = 0;
    unsigned to = 0;
    std::uint16_t quality = 0;
    words >> verb >> from;
    if (verb == "drop") {
      alive_.erase(from);
      stopped_[from] = Clock::now();
    } else if (verb == "quality" && words >> to >> quality) {
      qualities_[from][to] = quality;
    } else {
      std::fprintf(stderr, "unknown command: %s\n", line.c_str());
    }
  }

  milliseconds beacons_;
  Fd socket_;
  sockaddr_ll to_{};
  std::string input_;
  std::set<unsigned> alive_;
  std::map<unsigned, Clock::time_point> stopped_;
  std::map<unsigned, std::uint16_t> sequence_;
  std::map<unsigned, std::map<unsigned, std::uint16_t>> qualities_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("usage: awds-emulator INTERFACE NODES [BEACON_MS]\n", stderr);
    return 2;
  }
  const auto beacons = milliseconds(argc > 3 ? std::atoi(argv[3]) : 1400);
  return Emulator(argv[1], static_cast<unsigned>(std::atoi(argv[2])), beacons).run();
}
