// SPDX-License-Identifier: BSD-2-Clause
// What `price` needs of a program: a sender that times itself, our gate with many slots, and the
// peers that are programs. See usage().
#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "base/handle.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/gate.hpp"

namespace {

using mlcca::Fd;
using Words = std::span<char* const>;

int usage() {
  fmt::print(
      stderr,
      "usage: frames send INTERFACE ID COUNT          ns for each frame, as fast as it goes\n"
      "       frames pace INTERFACE ID COUNT US       one each US microseconds\n"
      "       frames gate INTERFACE SLOTS BPFFS       our gate, with subjects 0..SLOTS-1\n"
      "       frames reader INTERFACE SLOTS KIND      a socket with so many filters, never read\n"
      "                                               KIND: exact, masked, all (no filter)\n"
      "       frames filter INTERFACE SLOTS           reads everything, looks subjects up\n"
      "       frames relay INTERFACE SLOTS TO         the same, and sends what it knows to TO\n"
      "       frames count INTERFACE ID COUNT MS      frames of ID until so many, or MS without "
      "one\n"
      "reader, filter, relay and count print a line when they listen.\n");
  return 2;
}

[[noreturn]] void die(const std::string& what) {
  fmt::print(stderr, "frames: {}: {}\n", what, std::strerror(errno));
  std::exit(1);
}

std::int64_t now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * 1'000'000'000LL + t.tv_nsec;
}

std::uint32_t number(const char* text) {
  return static_cast<std::uint32_t>(std::strtoul(text, nullptr, 0));
}

/// Bound to an interface; its own frames do not come back to it.
Fd can_socket(const std::string& interface) {
  Fd fd(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  const int off = 0;
  if (setsockopt(fd.get(), SOL_CAN_RAW, CAN_RAW_LOOPBACK, &off, sizeof(off)) != 0 ||
      bind(fd.get(), reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0)
    die(interface);
  return fd;
}

can_frame frame_of(std::uint32_t id) {
  can_frame frame{};
  frame.can_id = CAN_EFF_FLAG | id;
  frame.can_dlc = 8;
  return frame;
}

int send(const std::string& interface, std::uint32_t id, std::uint32_t count) {
  constexpr std::size_t batch = 64;
  const Fd fd = can_socket(interface);
  can_frame frame = frame_of(id);
  iovec data{&frame, sizeof(frame)};
  std::array<mmsghdr, batch> messages{};
  for (auto& m : messages) {
    m.msg_hdr.msg_iov = &data;
    m.msg_hdr.msg_iovlen = 1;
  }
  const std::int64_t start = now();
  for (std::uint32_t sent = 0; sent < count;) {
    const int n = sendmmsg(fd.get(), messages.data(), batch, 0);
    if (n <= 0 && errno != ENOBUFS) die("sendmmsg");
    if (n > 0) sent += static_cast<std::uint32_t>(n);
  }
  fmt::print("{:.1f}\n", static_cast<double>(now() - start) / count);
  return 0;
}

int pace(const std::string& interface, std::uint32_t id, std::uint32_t count, std::uint32_t us) {
  const Fd fd = can_socket(interface);
  const can_frame frame = frame_of(id);
  std::int64_t next = now();
  for (std::uint32_t i = 0; i < count; ++i) {
    next += us * 1000LL;
    const timespec until{next / 1'000'000'000, next % 1'000'000'000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
    if (write(fd.get(), &frame, sizeof(frame)) != sizeof(frame)) die("write");
  }
  return 0;
}

int gate(const std::string& interface, std::uint32_t slots, const std::string& bpffs) {
  using namespace mlcca::gates;
  auto control = Control::create(bpffs);
  if (!control) die(control.error().text);
  static_cast<void>(control->set_grace(kForEver));
  if (const auto alive = control->beat(0); !alive) die(alive.error().text);
  control->open();
  GateConfig config;
  config.ifindex = if_nametoindex(interface.c_str());
  config.name = interface;
  config.profile = mlcca::core::Profile::famouso;
  auto gate = Gate::attach(config, *control);
  if (!gate) die(gate.error().text);
  SlotChanges changes;
  for (std::uint32_t i = 0; i < slots; ++i) {
    SlotSpec s;
    s.pass = true;
    s.id = CAN_EFF_FLAG | i;
    s.mask = CAN_EFF_FLAG | CAN_RTR_FLAG | GATE_ETAG_MASK;
    changes.add.push_back(s);
  }
  if (const auto done = gate->apply(changes); !done) die(done.error().text);
  return 0;
}

void listening() {
  fmt::print("listening\n");
  std::fflush(stdout);
}

int reader(const std::string& interface, std::uint32_t slots, const std::string& kind) {
  constexpr std::size_t at_once = CAN_RAW_FILTER_MAX;
  std::vector<Fd> sockets;
  std::vector<can_filter> filters;
  for (std::uint32_t i = 0; i < slots; ++i)
    filters.push_back({CAN_EFF_FLAG | i, kind == "exact"
                                             ? CAN_EFF_FLAG | CAN_EFF_MASK | CAN_RTR_FLAG
                                             : CAN_EFF_FLAG | GATE_ETAG_MASK});
  if (kind == "all") filters = {{0, 0}};
  for (std::size_t at = 0; at < filters.size(); at += at_once) {
    const auto part = std::span(filters).subspan(at, std::min(at_once, filters.size() - at));
    sockets.push_back(can_socket(interface));
    if (setsockopt(sockets.back().get(), SOL_CAN_RAW, CAN_RAW_FILTER, part.data(),
                   static_cast<socklen_t>(part.size_bytes())) != 0)
      die("CAN_RAW_FILTER");
  }
  listening();
  pause();
  return 0;
}

int filter(const std::string& interface, std::uint32_t slots, const std::string& to) {
  std::unordered_set<std::uint32_t> known;
  for (std::uint32_t i = 0; i < slots; ++i) known.insert(i);
  const Fd in = can_socket(interface);
  const Fd out = to.empty() ? Fd() : can_socket(to);
  listening();
  can_frame frame{};
  std::uint64_t passed = 0;
  while (read(in.get(), &frame, sizeof(frame)) == sizeof(frame)) {
    if (!known.contains(frame.can_id & GATE_ETAG_MASK)) continue;
    ++passed;
    if (!to.empty() && write(out.get(), &frame, sizeof(frame)) < 0 && errno != ENOBUFS)
      die("write");
  }
  return passed > 0 ? 0 : 1;
}

int count(const std::string& interface, std::uint32_t id, std::uint32_t wanted, std::uint32_t ms) {
  const Fd fd = can_socket(interface);
  const can_filter only{CAN_EFF_FLAG | id, CAN_EFF_FLAG | CAN_EFF_MASK};
  const timeval timeout{ms / 1000, ms % 1000 * 1000L};
  const int room = 8 << 20;
  setsockopt(fd.get(), SOL_CAN_RAW, CAN_RAW_FILTER, &only, sizeof(only));
  setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout));
  setsockopt(fd.get(), SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof(room));
  listening();
  can_frame frame{};
  std::uint32_t seen = 0;
  while (seen < wanted && read(fd.get(), &frame, sizeof(frame)) == sizeof(frame)) ++seen;
  fmt::print("{}\n", seen);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const Words words(argv, static_cast<std::size_t>(argc));
  const std::string verb = argc > 1 ? words[1] : "";
  if (verb == "send" && argc == 5) return send(words[2], number(words[3]), number(words[4]));
  if (verb == "pace" && argc == 6)
    return pace(words[2], number(words[3]), number(words[4]), number(words[5]));
  if (verb == "gate" && argc == 5) return gate(words[2], number(words[3]), words[4]);
  if (verb == "reader" && argc == 5) return reader(words[2], number(words[3]), words[4]);
  if (verb == "filter" && argc == 4) return filter(words[2], number(words[3]), "");
  if (verb == "relay" && argc == 5) return filter(words[2], number(words[3]), words[4]);
  if (verb == "count" && argc == 6)
    return count(words[2], number(words[3]), number(words[4]), number(words[5]));
  return usage();
}
