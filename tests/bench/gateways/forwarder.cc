// SPDX-License-Identifier: BSD-2-Clause
// Two gateways between the same two Ethernets, each with mlccad, mlcca-cluster and mlcca-relay. The
// one that forwards is killed, again and again: how long nobody forwards.
#include <arpa/inet.h>
#include <fmt/core.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <mutex>
#include <random>
#include <thread>

#include "tests/bench/gateways/parts.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/relay/udp.hpp"

namespace mlcca::bench {
namespace {

constexpr std::chrono::milliseconds kPeriod{5};
constexpr double kLeaseMs = 2000;

std::string side_by_side_xml() {
  std::string xml =
      "<System name='t'>\n<EventChannel name='beat'><SubjectUID>0x4200000000000000"
      "</SubjectUID><Attributes>" +
      ms_attribute("Period", static_cast<double>(kPeriod.count())) +
      octets_attribute("MaxPayload", 8) + "</Attributes></EventChannel>\n" + ethernet("lan") +
      ethernet("field");
  for (const char* gateway : {"gw1", "gw2"})
    xml += fmt::format("<Gateway name='{}'><Provision>", gateway) + ms_attribute("Latency", 1) +
           "<Attribute><Name>Omission</Name><Value>0</Value></Attribute></Provision>"
           "<Port network='lan' excess='pass'><Interface name='eth1'/></Port>"
           "<Port network='field' excess='pass'><Interface name='eth2'/></Port></Gateway>\n";
  return xml +
         "<Publisher name='p' channel='beat' network='lan'/>"
         "<Subscriber name='s' channel='beat' network='field'/></System>\n";
}

/// Events on lan, and what of them comes to field by which gateway.
class Events {
 public:
  Events() {
    inside("source", [this] { out_ = udp_socket("10.1.0.1", ""); });
    inside("sink", [this] { in_ = udp_socket("10.2.0.1", ""); });
    timeval patience{.tv_sec = 0, .tv_usec = 100'000};
    ::setsockopt(in_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    sender_ = std::thread([this] { send(); });
    receiver_ = std::thread([this] { receive(); });
  }
  Events(const Events&) = delete;
  Events& operator=(const Events&) = delete;
  Events(Events&&) = delete;
  Events& operator=(Events&&) = delete;
  ~Events() {
    ends_ = true;
    sender_.join();
    receiver_.join();
  }

  /// When the latest one came by that gateway (1 or 2).
  Steady::time_point latest(int gateway) {
    const std::scoped_lock lock(mutex_);
    return latest_.at(static_cast<std::size_t>(gateway));
  }
  /// When the first one came by that gateway after `since`.
  Steady::time_point first_after(int gateway, Steady::time_point since) {
    {
      const std::scoped_lock lock(mutex_);
      awaited_ = gateway;
      since_ = since;
      first_ = {};
    }
    const auto there = [this] {
      const std::scoped_lock lock(mutex_);
      return first_;
    };
    wait_for(fmt::format("nothing comes by gw{}", gateway),
             [&] { return there() != Steady::time_point{}; });
    return there();
  }

 private:
  void send() {
    std::array<char, kHeader + 8> event{'B'};
    const sockaddr_in to = group();
    auto next = Steady::now();
    while (!ends_) {
      ::sendto(out_.get(), event.data(), event.size(), 0, generic_of(to), sizeof to);
      std::this_thread::sleep_until(next += kPeriod);
    }
  }
  void receive() {
    std::array<char, 64> event{};
    while (!ends_) {
      sockaddr_in from{};
      socklen_t size = sizeof from;
      // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
      auto* const generic = reinterpret_cast<sockaddr*>(&from);
      if (::recvfrom(in_.get(), event.data(), event.size(), 0, generic, &size) < 0) continue;
      const auto now = Steady::now();
      // 10.2.0.2 is gw1's, 10.2.0.3 gw2's.
      const auto gateway = static_cast<int>(ntohl(from.sin_addr.s_addr) & 0xffU) - 1;
      if (gateway != 1 && gateway != 2) continue;
      const std::scoped_lock lock(mutex_);
      latest_.at(static_cast<std::size_t>(gateway)) = now;
      if (gateway == awaited_ && now > since_ && first_ == Steady::time_point{}) first_ = now;
    }
  }

  Fd out_, in_;
  std::mutex mutex_;
  std::array<Steady::time_point, 3> latest_{};
  int awaited_ = 0;
  Steady::time_point since_, first_;
  std::atomic<bool> ends_ = false;
  std::thread sender_, receiver_;
};

class SideBySide {
 public:
  SideBySide() : store_(prepare(), 1) {
    for (const char* user : {"gw1", "gw2"})
      grant(store_, user, "readwrite", std::string("/mlcca/t/r/field/") + user + '/');
    test::write_file(folder_ / "t.xml", side_by_side_xml());
    require(test::run_script(R"(
segment() { # segment BRIDGE NUMBER NAMESPACE=INTERFACE...: 10.NUMBER.0.I
	bridge=$1 net=$2 i=1
	shift 2
	ip link add $bridge type bridge mcast_snooping 0
	ip link set $bridge up
	for end; do
		space=${end%=*} interface=${end#*=}
		[ -e /run/netns/$space ] || ip netns add $space
		ip link add $bridge-$i master $bridge type veth peer name $interface netns $space
		ip link set $bridge-$i up
		ip -n $space addr add 10.$net.0.$i/24 dev $interface
		ip -n $space link set $interface up
		i=$((i + 1))
	done
}
segment lan 1 source=out gw1=eth1 gw2=eth1
segment field 2 sink=in gw1=eth2 gw2=eth2
)",
                             folder_.path()),
            "links");
    first_ = std::make_unique<RealGateway>(folder_, store_, options("gw1"));
    second_ = std::make_unique<RealGateway>(folder_, store_, options("gw2"));
    first_->start();
    second_->start();
    first_->start_relay();
    second_->start_relay();
    first_->wait_until_in();
    events_ = std::make_unique<Events>();
    static_cast<void>(events_->first_after(1, Steady::now()));
  }

  void run() {
    constexpr double bound = (kLeaseMs * 1.001) + 1000 + (kLeaseMs / 8);
    print("all of the first one is killed",
          measure(
              8, [this] { first_->kill(); }, false),
          fmt::format("bound: {:.0f} ms and two transactions", bound));
    print("its mlccad alone is killed (3)",
          measure(
              4, [this] { first_->kill_daemon(); }, true),
          fmt::format("bound: {:.0f} ms and two transactions",
                      1000 + (kLeaseMs * 0.002) + (kLeaseMs / 8)));
    print("its mlcca-relay alone is killed",
          measure(6, [this] { first_->kill_relay(); }, false), "some transactions");
    print("the first one is back", back_, "some transactions");
  }

 private:
  const test::WorkFolder& prepare() {
    test::make_certificates(folder_);
    return folder_;
  }
  RealGateway::Options options(const std::string& name) {
    return {.name = name,
            .description = folder_ / "t.xml",
            .certificate = name,
            .lease = fmt::format("{}ms", kLeaseMs),
            .state = folder_ / (name + ".state")};
  }
  /// From the kill, or from the last event that came by the first one, to the first one by the
  /// other one, ms.
  std::vector<double> measure(int times, const std::function<void()>& kill, bool goes_on) {
    std::vector<double> gaps;
    for (int time = 0; time < times; ++time) {
      // Somewhere between two beats.
      std::this_thread::sleep_for(std::chrono::milliseconds(random_() % 600));
      const auto before = Steady::now();
      kill();
      const auto other = events_->first_after(2, before);
      const auto since = goes_on ? events_->latest(1) : before;
      gaps.push_back(std::chrono::duration<double, std::milli>(other - since).count());
      bring_back();
    }
    return gaps;
  }
  void bring_back() {
    first_->kill();
    const auto before = Steady::now();
    first_->start();
    first_->start_relay();
    const auto again = events_->first_after(1, before);
    back_.push_back(std::chrono::duration<double, std::milli>(again - events_->latest(2)).count());
    first_->wait_until_in();
  }
  static void print(const std::string& what, std::vector<double> gaps, const std::string& bound) {
    std::ranges::sort(gaps);
    fmt::print(
        "nobody forwards: {:<32}  least {:6.0f} ms, half {:6.0f} ms, most {:6.0f} ms of {}   "
        "{}\n",
        what, gaps.front(), quantile(gaps, 0.5), gaps.back(), gaps.size(), bound);
  }

  test::WorkFolder folder_;
  test::Store store_;
  std::unique_ptr<RealGateway> first_, second_;
  std::unique_ptr<Events> events_;
  std::vector<double> back_;
  std::minstd_rand random_;
};

}  // namespace

void measure_forwarder() { SideBySide().run(); }

}  // namespace mlcca::bench
