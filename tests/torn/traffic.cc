// SPDX-License-Identifier: BSD-2-Clause
// Numbered frames between namespaces, and which of them arrived: see usage(). One thread for each
// namespace sends, one in all receives; commands come by standard input.
#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "base/handle.hpp"

namespace {

using mlcca::Fd;
using Time = std::int64_t;                     // CLOCK_MONOTONIC, ns
constexpr std::size_t kProof = 50;             // frames that show whether a flow has stopped
constexpr Time kLongestWait = 60'000'000'000;  // for them, ns

int usage() {
  fmt::print(
      stderr,
      "usage: traffic PAUSE-US FLOW...\n"
      "  FLOW: NAME,KIND,FROM-NAMESPACE,INTERFACE,TO-NAMESPACE,ID; - is this namespace\n"
      "    KIND can: ID is a 29-bit identifier; frames leave by INTERFACE\n"
      "    KIND udp: ID is a 64-bit subject; datagrams go to the broadcast address INTERFACE\n"
      "  Every flow sends a frame, then all pause.\n"
      "commands, each answered in one line; times are CLOCK_MONOTONIC in ns, 0 as END is for "
      "ever:\n"
      "  passes FLOW MS          `yes TIME`: one that was sent after TIME, now, arrived within MS; "
      "or "
      "`no`\n"
      "  stopped FLOW MS         `yes TIME`: of at least 50 sent after TIME, now, none arrived by "
      "MS "
      "after the 50th; `no TIME`: one arrived at TIME; `unknown N`: only N were sent in 60 s\n"
      "  lost FLOW BEGIN END     number, first and last of those sent between and never seen\n"
      "  wrong FLOW BEGIN END    number, first and last of those sent and seen between\n"
      "  counts FLOW             sent, not taken by the kernel, arrived, arrived again\n"
      "  drain MS FLOW...        stops sending, until the last of each FLOW arrived, at most MS\n");
  return 2;
}

[[noreturn]] void die(const std::string& what) {
  fmt::print(stderr, "traffic: {}: {}\n", what, std::strerror(errno));
  std::exit(1);
}

Time now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * 1'000'000'000LL + t.tv_nsec;
}

void pause_for(Time ns) {
  const timespec t{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
  nanosleep(&t, nullptr);
}

void enter(const std::string& space) {
  if (space == "-") return;
  const Fd fd(open(("/run/netns/" + space).c_str(), O_RDONLY | O_CLOEXEC));
  if (!fd || setns(fd.get(), CLONE_NEWNET) != 0) die(space);
}

/// Frames of one sender stay in their order, as each CPU has a queue of its own for them.
void stay_on(std::size_t cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cpu % std::max(1U, std::thread::hardware_concurrency()), &set);
  sched_setaffinity(0, sizeof set, &set);
}

struct Sent {
  Time before = 0;
  Time after = 0;    ///< 0: the kernel did not take it
  Time arrived = 0;  ///< 0: it has not
};

struct Flow {
  std::string name, kind, from, interface, to;
  std::uint64_t id = 0;
  std::uint8_t index = 0;
  Fd socket;
  std::mutex lock;
  std::deque<Sent> sent;
  std::uint64_t again = 0;
};

constexpr std::uint8_t kMagic = 0xa7;
constexpr std::uint16_t kPort = 9999;

struct [[gnu::packed]] Payload {
  std::uint8_t magic = kMagic;
  std::uint8_t flow = 0;
  std::uint16_t reserved = 0;
  std::uint32_t number = 0;
};

/// 0: there is none. if_nametoindex(3) would have the kernel run modprobe for a name that it does
/// not know, each time for a third of a second on an emulated processor, and the sender with it.
int index_of(const std::string& interface) {
  const std::unique_ptr<struct if_nameindex, decltype(&if_freenameindex)> all(if_nameindex(),
                                                                              if_freenameindex);
  int found = 0;
  for (const auto* one = all.get(); one != nullptr && one->if_index != 0; ++one)
    if (interface == one->if_name) found = static_cast<int>(one->if_index);
  return found;
}

/// An interface that has gone leaves a socket that cannot send: a new one each time.
void open_sender(Flow& flow) {
  if (flow.kind == "udp") {
    flow.socket.reset(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const int yes = 1;
    setsockopt(flow.socket.get(), SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
    return;
  }
  flow.socket.reset(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index_of(flow.interface);
  setsockopt(flow.socket.get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0);
  if (address.can_ifindex == 0 ||
      bind(flow.socket.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
    flow.socket.reset();
}

bool send_one(Flow& flow, std::uint32_t number) {
  const Payload payload{.flow = flow.index, .number = number};
  if (!flow.socket) open_sender(flow);
  if (!flow.socket) return false;
  if (flow.kind == "can") {
    can_frame frame{};
    frame.can_id = CAN_EFF_FLAG | static_cast<std::uint32_t>(flow.id);
    frame.can_dlc = sizeof payload;
    std::memcpy(frame.data, &payload, sizeof payload);
    if (write(flow.socket.get(), &frame, sizeof frame) == sizeof frame) return true;
    if (errno != ENOBUFS) flow.socket.reset();
    return false;
  }
  std::array<char, 9 + sizeof payload> event{};
  for (unsigned i = 0; i < 8; ++i) event[i] = static_cast<char>(flow.id >> (56 - 8 * i));
  std::memcpy(event.data() + 9, &payload, sizeof payload);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kPort);
  to.sin_addr.s_addr = inet_addr(flow.interface.c_str());
  return sendto(flow.socket.get(), event.data(), event.size(), 0, reinterpret_cast<sockaddr*>(&to),
                sizeof to) == std::ssize(event);
}

class Traffic {
 public:
  Traffic(Time pause, const std::vector<std::string>& words) : pause_(pause) {
    for (const std::string& word : words) add(word);
    for (const auto& flow : flows_)
      if (Fd& fd = receivers_[flow->to + flow->kind]; !fd) fd = receiver(*flow);
    threads_.emplace_back([this] { receive(); });
    std::map<std::string, std::vector<Flow*>> spaces;
    for (const auto& flow : flows_) spaces[flow->from].push_back(flow.get());
    for (const auto& [space, of_it] : spaces)
      threads_.emplace_back([this, space, of_it, cpu = threads_.size()] {
        stay_on(cpu);
        send(space, of_it);
      });
  }
  Traffic(const Traffic&) = delete;
  Traffic& operator=(const Traffic&) = delete;
  ~Traffic() {
    sending_ = false;
    receiving_ = false;
    for (auto& thread : threads_) thread.join();
  }

  std::string answer(const std::string& line) {
    std::istringstream words(line);
    std::string verb, name;
    Time a = 0;
    Time b = 0;
    words >> verb;
    if (verb == "drain") {
      words >> a;
      sending_ = false;
      while (words >> name) drain(flow_of(name), now() + a * 1'000'000);
      return "yes";
    }
    words >> name >> a >> b;
    Flow& flow = flow_of(name);
    if (verb == "passes") return passes(flow, a);
    if (verb == "stopped") return stopped(flow, a);
    if (verb == "lost")
      return range(flow, [a, b](const Sent& s) {
        return s.before >= a && s.after != 0 && (b == 0 || s.after <= b) && s.arrived == 0;
      });
    if (verb == "wrong")
      return range(flow, [a, b](const Sent& s) {
        return s.before >= a && s.arrived != 0 && (b == 0 || s.arrived <= b);
      });
    if (verb == "counts") return counts(flow);
    return "what?";
  }

 private:
  void add(const std::string& word) {
    auto flow = std::make_unique<Flow>();
    std::istringstream parts(word);
    std::string id;
    for (std::string* part :
         {&flow->name, &flow->kind, &flow->from, &flow->interface, &flow->to, &id})
      std::getline(parts, *part, ',');
    flow->id = std::strtoull(id.c_str(), nullptr, 16);
    flow->index = static_cast<std::uint8_t>(flows_.size());
    flows_.push_back(std::move(flow));
  }

  static Fd receiver(const Flow& flow) {
    Fd fd;
    std::thread([&] {
      enter(flow.to);
      const bool can = flow.kind == "can";
      fd.reset(can ? ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)
                   : ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
      const int room = 64 << 20;
      if (setsockopt(fd.get(), SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room) != 0) die("buffer");
      sockaddr_can bus{};
      bus.can_family = AF_CAN;
      sockaddr_in port{};
      port.sin_family = AF_INET;
      port.sin_port = htons(kPort);
      if (bind(fd.get(),
               can ? reinterpret_cast<sockaddr*>(&bus) : reinterpret_cast<sockaddr*>(&port),
               can ? sizeof bus : sizeof port) != 0)
        die("bind in " + flow.to);
    }).join();
    return fd;
  }

  void receive() {
    std::vector<pollfd> polled;
    std::vector<std::string> where;
    for (const auto& [key, fd] : receivers_) {
      polled.push_back({.fd = fd.get(), .events = POLLIN, .revents = 0});
      where.push_back(key);
    }
    std::array<char, 2048> bytes{};
    while (receiving_) {
      if (poll(polled.data(), polled.size(), 50) <= 0) continue;
      for (std::size_t i = 0; i < polled.size(); ++i) {
        if ((polled[i].revents) == 0) continue;
        ssize_t size = 0;
        while ((size = recv(polled[i].fd, bytes.data(), bytes.size(), MSG_DONTWAIT)) > 0)
          take(where[i], bytes.data(), static_cast<std::size_t>(size));
      }
    }
  }

  void take(const std::string& where, const char* bytes, std::size_t size) {
    const std::size_t at = size == sizeof(can_frame) ? offsetof(can_frame, data) : 9;
    Payload payload;
    if (size < at + sizeof payload) return;
    std::memcpy(&payload, bytes + at, sizeof payload);
    if (payload.magic != kMagic || payload.flow >= flows_.size()) return;
    Flow& flow = *flows_[payload.flow];
    if (flow.to + flow.kind != where) return;
    const Time at_time = now();
    const std::scoped_lock hold(flow.lock);
    if (payload.number >= flow.sent.size()) return;
    Sent& sent = flow.sent[payload.number];
    if (sent.arrived != 0) ++flow.again;
    if (sent.arrived == 0) sent.arrived = at_time;
  }

  void send(const std::string& space, const std::vector<Flow*>& flows) {
    enter(space);
    while (sending_) {
      for (Flow* flow : flows) {
        std::uint32_t number = 0;
        {
          const std::scoped_lock hold(flow->lock);
          number = static_cast<std::uint32_t>(flow->sent.size());
          flow->sent.push_back({.before = now()});
        }
        const bool taken = send_one(*flow, number);
        const std::scoped_lock hold(flow->lock);
        if (taken) flow->sent[number].after = now();
      }
      pause_for(pause_);
    }
  }

  Flow& flow_of(const std::string& name) {
    for (const auto& flow : flows_)
      if (flow->name == name) return *flow;
    die("no flow " + name);
  }

  /// Whether one that was sent after `begin` has arrived, and when the latest of them did.
  static Time latest(Flow& flow, Time begin) {
    const std::scoped_lock hold(flow.lock);
    Time found = 0;
    for (auto s = flow.sent.rbegin(); s != flow.sent.rend() && s->before >= begin; ++s)
      found = std::max(found, s->arrived);
    return found;
  }

  static std::string passes(Flow& flow, Time ms) {
    const Time begin = now();
    while (now() < begin + ms * 1'000'000) {
      if (latest(flow, begin) != 0) return fmt::format("yes {}", begin);
      pause_for(1'000'000);
    }
    return "no";
  }

  static std::size_t sent_since(Flow& flow, Time begin) {
    const std::scoped_lock hold(flow.lock);
    const auto first =
        std::ranges::lower_bound(flow.sent, begin, {}, [](const Sent& s) { return s.before; });
    return static_cast<std::size_t>(flow.sent.end() - first);
  }

  /// A sender that has had no processor meanwhile proves nothing.
  static std::string stopped(Flow& flow, Time ms) {
    const Time begin = now();
    const Time limit = begin + kLongestWait;
    for (Time enough = 0; enough == 0 || now() < enough + ms * 1'000'000;) {
      if (const Time arrived = latest(flow, begin); arrived != 0)
        return fmt::format("no {}", arrived);
      const std::size_t sent = sent_since(flow, begin);
      if (enough == 0 && now() > limit) return fmt::format("unknown {}", sent);
      if (enough == 0 && sent >= kProof) enough = now();
      pause_for(5'000'000);
    }
    return fmt::format("yes {}", begin);
  }

  static std::string range(Flow& flow, auto bad) {
    const std::scoped_lock hold(flow.lock);
    std::uint64_t count = 0;
    std::size_t first = 0;
    std::size_t last = 0;
    for (std::size_t i = 0; i < flow.sent.size(); ++i)
      if (bad(flow.sent[i])) {
        if (count++ == 0) first = i;
        last = i;
      }
    if (count == 0) return "0";
    return fmt::format("{} {} {}", count, flow.sent[first].before, flow.sent[last].before);
  }

  static std::string counts(Flow& flow) {
    const std::scoped_lock hold(flow.lock);
    std::uint64_t refused = 0;
    std::uint64_t arrived = 0;
    for (const Sent& s : flow.sent) {
      if (s.after == 0) ++refused;
      if (s.arrived != 0) ++arrived;
    }
    return fmt::format("{} {} {} {}", flow.sent.size(), refused, arrived, flow.again);
  }

  static void drain(Flow& flow, Time end) {
    while (now() < end) {
      {
        const std::scoped_lock hold(flow.lock);
        if (flow.sent.empty() || flow.sent.back().arrived != 0) return;
      }
      pause_for(5'000'000);
    }
  }

  Time pause_;
  std::vector<std::unique_ptr<Flow>> flows_;
  std::map<std::string, Fd> receivers_;
  std::vector<std::thread> threads_;
  std::atomic<bool> sending_ = true;
  std::atomic<bool> receiving_ = true;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return usage();
  Traffic traffic(std::strtoll(argv[1], nullptr, 10) * 1000,
                  std::vector<std::string>(argv + 2, argv + argc));
  for (std::string line; std::getline(std::cin, line);)
    std::cout << traffic.answer(line) << std::endl;
}
