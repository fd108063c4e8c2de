// SPDX-License-Identifier: BSD-2-Clause
// Times of events through a relay, and between programs on one gateway, with a peer of each that
// does nothing but the system calls.
//   probe delay SEND-ADDRESS RECEIVE-ADDRESS OUT-NAMESPACE COUNT
//       one way, through whoever carries it
//   probe rate RECEIVE-ADDRESS OUT-NAMESPACE COUNT GAP-NS SEND-ADDRESS...
//       COUNT events of 8 octets from each address, of the subjects "P", "Q", …, one in GAP-NS each
//   probe forward FROM-INTERFACE TO-INTERFACE [SUBJECT]
//       the peer: recv and sendto, until it is killed
//   probe local SOCKET COUNT
//       publish() to a handler, and its peer
//   probe announce SOCKET COUNT
//       announce() of the channels idle0, idle1, …, each to its verdict, which is in force when it
//       returns; and what a channel then takes of memory while nothing is sent
#include <arpa/inet.h>
#include <fcntl.h>
#include <malloc.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.hpp"
#include "base/handle.hpp"
#include "base/unix_address.hpp"
#include "mlcca/client/client.hpp"
#include "tests/bench/relay/udp.hpp"

namespace {

using namespace mlcca;         // NOLINT(google-build-using-namespace): a bench
using namespace mlcca::bench;  // NOLINT(google-build-using-namespace)

struct Stamp {
  std::uint64_t number = 0;
  std::uint64_t ns = 0;
};

int delay(char** argv) {
  const std::size_t count = std::strtoul(argv[3], nullptr, 10);
  const Fd out = udp_socket(argv[0], "");
  const Fd other(::open(argv[2], O_RDONLY | O_CLOEXEC));
  if (::setns(other.get(), CLONE_NEWNET) != 0) give_up("setns");
  const Fd in = udp_socket(argv[1], "");
  timeval patience{.tv_sec = 2, .tv_usec = 0};
  ::setsockopt(in.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::vector<std::uint64_t> times;
  std::thread receiver([&] {
    std::array<char, 2048> buffer{};
    while (times.size() < count) {
      const ssize_t n = ::recv(in.get(), buffer.data(), buffer.size(), 0);
      const std::uint64_t now = monotonic_ns();
      if (n < 0) return;
      Stamp stamp;
      std::memcpy(&stamp, buffer.data() + kHeader, sizeof stamp);
      times.push_back(now - stamp.ns);
    }
  });
  std::array<char, kHeader + sizeof(Stamp)> event{'B'};
  const sockaddr_in to = group();
  for (std::size_t i = 0; i < count; ++i) {
    const Stamp stamp{i, monotonic_ns()};
    std::memcpy(event.data() + kHeader, &stamp, sizeof stamp);
    ::sendto(out.get(), event.data(), event.size(), 0, generic_of(to), sizeof to);
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  receiver.join();
  print("through", times, count);
  return 0;
}

/// Reads what has come, a pause apart, so that it takes little of the processor that is measured.
std::size_t count_until_silent(const Fd& socket) {
  constexpr auto pause = std::chrono::milliseconds(2);
  constexpr auto silence = std::chrono::seconds(2);
  std::array<char, 2048> buffer{};
  std::size_t count = 0;
  auto last = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - last < silence) {
    while (::recv(socket.get(), buffer.data(), buffer.size(), MSG_DONTWAIT) > 0) {
      ++count;
      last = std::chrono::steady_clock::now();
    }
    std::this_thread::sleep_for(pause);
  }
  return count;
}

/// Sends on each socket in turn, evenly spaced, and returns the time from the first to the last.
std::uint64_t send_evenly(const std::vector<Fd>& sockets, std::size_t count, std::uint64_t gap) {
  std::array<char, kHeader + 8> event{};
  const std::uint64_t began = monotonic_ns();
  for (std::size_t i = 0; i < count * sockets.size(); ++i) {
    while (monotonic_ns() < began + i * gap / sockets.size()) {
    }
    const auto which = i % sockets.size();
    event[0] = static_cast<char>('P' + which);
    const sockaddr_in to = group(event[0]);
    ::sendto(sockets[which].get(), event.data(), event.size(), 0, generic_of(to), sizeof to);
  }
  return monotonic_ns() - began;
}

int rate(int addresses, char** argv) {
  const std::size_t count = std::strtoul(argv[2], nullptr, 10);
  const std::uint64_t gap = std::strtoull(argv[3], nullptr, 10);
  std::vector<Fd> out;
  for (int i = 0; i < addresses; ++i)
    out.push_back(udp_socket(argv[4 + i], "", static_cast<char>('P' + i)));
  const Fd other(::open(argv[1], O_RDONLY | O_CLOEXEC));
  if (::setns(other.get(), CLONE_NEWNET) != 0) give_up("setns");
  const Fd in = udp_socket(argv[0], "", 'P');
  for (int i = 1; i < addresses; ++i) join(in, membership(argv[0], "", static_cast<char>('P' + i)));
  std::size_t arrived = 0;
  std::thread receiver([&] { arrived = count_until_silent(in); });
  const std::uint64_t took = send_evenly(out, count, gap);
  receiver.join();
  const std::size_t sent = count * out.size();
  std::printf("%zu of %zu events, %.0f a second\n", arrived, sent,
              static_cast<double>(sent) * 1e9 / static_cast<double>(took));
  return 0;
}

int forward(int argc, char** argv) {
  const char subject = argc > 2 ? *argv[2] : 'B';
  const Fd in = udp_socket("", argv[0], subject);
  const Fd out = udp_socket("", argv[1], subject);
  const sockaddr_in to = group(subject);
  std::array<char, 8192> buffer{};
  for (;;) {
    const ssize_t n = ::recv(in.get(), buffer.data(), buffer.size(), 0);
    if (n > 0)
      ::sendto(out.get(), buffer.data(), static_cast<std::size_t>(n), 0, generic_of(to), sizeof to);
  }
}

void local_peer(std::size_t count) {
  std::array<int, 2> pair{};
  if (::socketpair(AF_UNIX, SOCK_DGRAM, 0, pair.data()) != 0) give_up("socketpair");
  const Fd a(pair[0]);
  const Fd b(pair[1]);
  std::vector<std::uint64_t> times;
  std::thread receiver([&] {
    pollfd waits{.fd = b.get(), .events = POLLIN, .revents = 0};
    while (times.size() < count) {
      ::poll(&waits, 1, -1);
      Stamp stamp;
      if (::recv(b.get(), &stamp, sizeof stamp, MSG_DONTWAIT) == sizeof stamp)
        times.push_back(monotonic_ns() - stamp.ns);
    }
  });
  for (std::size_t i = 0; i < count; ++i) {
    const Stamp stamp{i, monotonic_ns()};
    ::send(a.get(), &stamp, sizeof stamp, 0);
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  receiver.join();
  print("datagram", times, count);
}

int local(char** argv) {
  const std::size_t count = std::strtoul(argv[1], nullptr, 10);
  client::Options options;
  options.socket = argv[0];
  std::vector<std::uint64_t> times;
  std::thread receiver([&] {
    client::Client client(options);
    client::SubscriberChannel subscriber(client, "here");
    subscriber.on_event([&](const client::Event& event) {
      Stamp stamp;
      std::memcpy(&stamp, event.data, sizeof stamp);
      if (stamp.ns != 0) times.push_back(monotonic_ns() - stamp.ns);
    });
    subscriber.subscribe();
    while (times.size() < count) client.wait(std::chrono::seconds(1));
  });
  client::Client client(options);
  client::PublisherChannel publisher(client, "here");
  publisher.announce();
  Stamp stamp;
  const auto send = [&] { return publisher.publish(&stamp, sizeof stamp); };
  while (send() != client::Published::sent) client.wait(std::chrono::milliseconds(20));
  for (std::size_t i = 0; i < count; ++i) {
    stamp = {i, monotonic_ns()};
    send();
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  receiver.join();
  print("publish", times, count);
  local_peer(count);
  return 0;
}

/// Bytes that this process holds in its heap.
std::size_t heap_bytes() {
  const auto info = ::mallinfo2();
  return info.uordblks + info.hblkhd;
}

int announce(char** argv) {
  const std::size_t count = std::strtoul(argv[1], nullptr, 10);
  client::Options options;
  options.socket = argv[0];
  client::Client client(options);
  std::vector<std::unique_ptr<client::PublisherChannel>> channels;
  channels.reserve(count);
  std::vector<std::uint64_t> times;
  times.reserve(count);
  std::size_t before = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == 1) before = heap_bytes();  // the first one brings the connection
    channels.push_back(
        std::make_unique<client::PublisherChannel>(client, "idle" + std::to_string(i)));
    const std::uint64_t began = monotonic_ns();
    const auto answer = channels.back()->announce();
    times.push_back(monotonic_ns() - began);
    if (answer->state != client::State::granted) give_up(answer->reason.c_str());
  }
  client.process();
  if (count > 1)
    std::printf("memory %zu bytes for each channel in the program\n",
                (heap_bytes() - before) / (count - 1));
  print("announce", times, count);
  std::fflush(stdout);
  ::pause();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "delay" && argc == 6) return delay(argv + 2);
  if (what == "rate" && argc > 6) return rate(argc - 6, argv + 2);
  if (what == "forward" && (argc == 4 || argc == 5)) return forward(argc - 2, argv + 2);
  if (what == "local" && argc == 4) return local(argv + 2);
  if (what == "announce" && argc == 4) return announce(argv + 2);
  std::fputs("probe delay|rate|forward|local|announce …, see the head of its source\n", stderr);
  return 2;
}
