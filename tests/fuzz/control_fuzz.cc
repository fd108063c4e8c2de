// SPDX-License-Identifier: BSD-2-Clause
// What clients send to a whole gateway, in steps: three octets say what is done, by which client,
// and how many octets follow that belong to it. What must hold after each step is in
// gateway_under_test.hpp.
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "control/codec.hpp"
#include "control/local_address.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/gateway_under_test.hpp"

namespace {

using namespace mlcca;
using fuzz::GatewayUnderTest;
using fuzz::User;

constexpr std::size_t kMostSteps = 48;

/// Octets as what is wanted of them; where none are left, zeros.
class Octets {
 public:
  explicit Octets(std::string_view octets) : rest_(octets) {}
  unsigned next() {
    if (rest_.empty()) return 0;
    const auto octet = static_cast<unsigned char>(rest_.front());
    rest_.remove_prefix(1);
    return octet;
  }
  template <std::size_t N>
  std::string one_of(const char* const (&of)[N]) {  // NOLINT(*-c-arrays)
    return of[next() % N];
  }
  std::string_view take(std::size_t size) {
    const auto taken = rest_.substr(0, size);
    rest_.remove_prefix(taken.size());
    return taken;
  }
  [[nodiscard]] bool done() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

constexpr const char* kChannels[] = {"c1", "c2", "c3", "c4", "c5", "0x3", "c9", ""};
/// Channels that are not described: the last one is of no network's Unlisted.
constexpr const char* kUnlisted[] = {"0x5600000000000001", "0x5600000000000002",
                                     "0x56ffffffffffffff", "0x5700000000000001"};
constexpr const char* kPlaces[] = {"", "lan", "bus", "gate", "nowhere"};
constexpr const char* kUsers[] = {"", "1000", "1003", "4294967295", "root"};
constexpr const char* kNames[] = {"", "a", "b", "a name"};
constexpr const char* kKeys[] = {"", "", "k1", "k2"};
constexpr const char* kAddresses[] = {"", "192.0.2.7", "02:00:00:00:00:07", "everybody"};
constexpr const char* kAttributes[] = {"Period", "MaxPayload", "Latency", "Bandwidth", "Beauty"};

/// With tags that are free, another channel's, or none at all.
void make_unlisted(control::ChannelRequest& to, Octets& from) {
  to.unlisted = true;
  to.channel = from.one_of(kUnlisted);
  for (unsigned n = from.next() % 3; n > 0; --n)
    to.identifiers.push_back({from.one_of(kPlaces), 0xf8U + from.next(), from.next() % 8 == 1});
  if (from.next() % 2 == 0) return;
  constexpr std::uint64_t period = 100'000'000;
  to.offered = {{"Period", period, {}}, {"MaxPayload", 8, {}}};
  to.required.clear();
}

void fill(control::ChannelRequest& to, Octets& from) {
  to.channel = from.one_of(kChannels);
  to.from = from.one_of(kPlaces);
  to.to = from.one_of(kPlaces);
  to.publisher = from.one_of(kNames);
  to.subscriber = from.one_of(kNames);
  to.user = from.one_of(kUsers);
  to.address = from.one_of(kAddresses);
  if (const unsigned node = from.next(); node % 4 != 0) to.node = node;
  if (const unsigned priority = from.next(); priority % 4 != 0) to.priority = priority;
  for (unsigned n = from.next() % 4; n > 0; --n) {
    auto& attributes = from.next() % 2 == 0 ? to.offered : to.required;
    const std::string name = from.one_of(kAttributes);
    attributes.push_back({name, std::uint64_t{from.next()} << (from.next() % 64), {}});
  }
  if (from.next() % 4 == 1) make_unlisted(to, from);
}

int restarts_left = 0;
std::uint64_t first_id = 1;

std::uint64_t some_admission(Octets& from) {
  const unsigned n = from.next() % 8;
  return n == 0 ? 0 : first_id + n - 1;
}

/// Of a subscriber on the gateway: mostly none, or a good one, or one that is nearly good.
std::string some_local(Octets& from) {
  std::string out;
  switch (from.next() % 8) {
    case 0:
    case 4:
      out = "0a1b20123456789abcdef";
      break;
    case 5:
      out = "0a1b20123456789abcdef";
      out[from.next() % out.size()] = static_cast<char>(from.next());
      break;
    case 6:
      out = from.take(from.next() % 32);
      break;
    default:
      break;
  }
  const auto read = control::local_address_in(out);
  fuzz::demand(!read || control::to_text(*read) == out, "an address is what was read of it");
  return out;
}

/// A request of any kind; nearly all of them are ones that may be asked.
control::AnnounceRequest some_announcement(Octets& from) {
  control::ChannelRequest attributes;
  fill(attributes, from);
  control::AnnounceRequest out{.channel = from.one_of(kChannels),
                               .role = static_cast<control::Role>(from.next() % 4),
                               .name = attributes.publisher,
                               .attributes = std::move(attributes.offered)};
  std::ranges::move(attributes.required, std::back_inserter(out.attributes));
  if (out.role == control::Role::subscriber) out.local = some_local(from);
  return out;
}

control::SubscribeRequest some_subscription(Octets& from) {
  control::ChannelRequest attributes;
  fill(attributes, from);
  return {.subject = from.next() % 8,
          .network = from.one_of(kPlaces),
          .source = from.next() % 4 == 0 ? from.one_of(kPlaces) : "0x12",
          .required = std::move(attributes.required),
          .states_attributes = from.next() % 4 != 0,
          .lease_ns = std::uint64_t{from.next()} << 20U,
          .end = from.next() % 4 == 0};
}

/// This gateway takes part in no cluster.
decltype(control::Request::body) some_of_a_cluster(Octets& from) {
  constexpr const char* parts[] = {"", "members", "reservations", "leaders"};
  const unsigned which = from.next() % 4;
  if (which == 0) return control::DrainRequest{from.one_of(kPlaces), from.next() % 2 == 0};
  if (which == 1) return control::JoinRequest{from.one_of(kPlaces)};
  return control::ClusterRequest{
      .part = from.one_of(parts), .network = from.one_of(kPlaces), .gateway = from.one_of(kPlaces)};
}

control::Request some_request(Octets& from) {
  control::Request out;
  const unsigned kind = from.next() % 16;
  out.id = from.next();
  out.slices = from.next() % 2 == 0;
  switch (kind) {
    case 0:
      out.body = control::StatusRequest{};
      break;
    case 1:
      out.body = control::NetworksRequest{};
      break;
    case 2:
      out.body = control::ChannelsRequest{};
      break;
    case 3: {
      control::Query query;
      fill(query, from);
      out.body = query;
      break;
    }
    case 4: {
      control::Admit admit;
      admit.key = from.one_of(kKeys);
      const unsigned how = from.next();
      admit.hold = how % 8 == 1;
      if (how % 8 == 2) admit.lease_ns = std::uint64_t{1} << (how / 8);
      fill(admit, from);
      out.body = admit;
      break;
    }
    case 5: {
      control::ReleaseRequest release;
      release.key = from.one_of(kKeys);
      release.admission = some_admission(from);
      release.channel = from.one_of(kChannels);
      if (from.next() % 4 == 1) release.channel = from.one_of(kUnlisted);
      out.body = release;
      break;
    }
    case 6:
      out.body = control::ExplainRequest{from.one_of(kChannels)};
      break;
    case 7:
      out.body = control::MonitorRequest{};
      break;
    case 8:
      out.body = control::ModeRequest{from.next() % 2 == 0 ? "enforce" : "audit",
                                      from.next() % 4 == 0 ? from.next() * 1'000'000'000ULL : 0};
      break;
    case 9:
      out.body = control::ReloadRequest{};
      break;
    case 10: {
      control::RenewRequest renew;
      renew.key = from.one_of(kKeys);
      renew.admission = some_admission(from);
      out.body = renew;
      break;
    }
    case 11:
      if (out.slices)
        out.body = control::RoutesRequest{};
      else
        out.body =
            control::TransfersRequest{from.next() % 2 == 0 ? "" : from.one_of(kChannels), {}};
      break;
    case 12:
      out.body = control::ReservationsRequest{from.one_of(kPlaces)};
      break;
    case 13: {
      control::WhatIfRequest what_if;
      for (unsigned n = from.next() % 3; n > 0; --n)
        what_if.without.push_back(from.one_of(kPlaces));
      for (unsigned n = from.next() % 3; n > 0; --n)
        what_if.links.push_back(
            {from.one_of(kPlaces), "a", "b", from.next(), from.next() % 2 == 0});
      out.body = what_if;
      break;
    }
    case 14: {
      control::HistoryRequest history;
      history.channel = from.one_of(kChannels);
      history.kind = from.next() % 2 == 0 ? "" : "granted";
      history.limit = from.next();
      history.since_unix_ns = from.next() % 2 == 0 ? 0 : ~std::uint64_t{0};
      out.body = history;
      break;
    }
    default: {
      const unsigned which = from.next() % 15;
      if (which == 0)
        out.body = control::WithdrawRequest{from.one_of(kChannels)};
      else if (which == 1)
        out.body = control::ReinstateRequest{from.one_of(kChannels)};
      else if (which == 4)
        out.body = some_announcement(from);
      else if (which == 5)
        out.body = control::DelayRequest{.subject = from.next(),
                                         .publisher = from.one_of(kChannels),
                                         .from = from.one_of(kPlaces),
                                         .to = from.one_of(kPlaces),
                                         .late = from.next(),
                                         .longest_ns = from.next()};
      else if (which == 6)
        out.body = control::SubscriptionsRequest{};
      else if (which == 10)
        out.body = control::AuditRequest{};
      else if (which == 11)
        out.body = control::RolloutRequest{.part = from.one_of(kPlaces),
                                           .more = from.next() % 2 == 0,
                                           .without = {from.one_of(kPlaces)},
                                           .back = from.next() % 4 == 0,
                                           .accept = from.next() % 4 == 0};
      else if (which == 12)
        out.body = control::RolloutStateRequest{};
      else if (which == 13)
        out.body = some_of_a_cluster(from);
      else if (which == 14)
        out.body = control::PingRequest{};
      else if (which == 7)
        out.body = some_subscription(from);
      else if (which == 8)
        out.body = control::RefusalRequest{.subject = from.next(),
                                           .network = from.one_of(kPlaces),
                                           .source = from.one_of(kPlaces),
                                           .reason = from.one_of(kChannels)};
      else if (which == 9)
        out.body = control::PresenceRequest{.network = from.one_of(kPlaces),
                                            .gateway = from.one_of(kPlaces),
                                            .lasts_ns = from.next(),
                                            .forwards = from.next() % 2 == 0,
                                            .not_received = {from.one_of(kPlaces)}};
      else
        out.body = control::GateRequest{from.one_of(kPlaces)};
    }
  }
  return out;
}

void act(GatewayUnderTest& gateway, unsigned what, std::size_t client, std::string_view octets) {
  Octets from(octets);
  switch (what % 16) {
    case 0:
      gateway.connect(static_cast<User>(from.next() % 3));
      break;
    case 1:
    case 2:
    case 3:
      gateway.send(client, control::encode(some_request(from)));
      break;
    case 4:  // several at once
      while (!from.done()) gateway.send(client, control::encode(some_request(from)));
      break;
    case 5: {  // one octet is another
      const unsigned at = from.next();
      const auto other = static_cast<char>(from.next());
      std::string request = control::encode(some_request(from));
      request[at % request.size()] ^= other;
      gateway.send(client, request);
      break;
    }
    case 6: {  // in two parts
      const unsigned at = from.next();
      const std::string request = control::encode(some_request(from));
      const std::string_view whole(request);
      gateway.send(client, whole.substr(0, at % whole.size()));
      gateway.settle();
      gateway.send(client, whole.substr(at % whole.size()));
      break;
    }
    case 7:
      gateway.send(client, octets);
      break;
    case 8:
      gateway.close(client);
      break;
    case 9:
      gateway.shut(client);
      break;
    case 10:
      gateway.set_reading(client, from.next() % 2 == 0);
      break;
    case 11:
      gateway.describe(from.next());
      break;
    case 12:
      gateway.run_round();
      break;
    case 13:
      if (restarts_left-- > 0) gateway.restart(from.next() % 2 == 0);
      break;
    default: {  // asked again and again
      const std::string request = control::encode(some_request(from));
      for (unsigned n = 0; n < 64; ++n) gateway.send(client, request);
    }
  }
  gateway.settle();
}

}  // namespace

/// What mlccad logs goes nowhere; what must be read goes to where it went before.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  fuzz::demand_fd = ::dup(STDERR_FILENO);
  static std::string quiet = "-close_fd_mask=2";
  static std::vector<char*> arguments(*argv, *argv + *argc);
  arguments.push_back(quiet.data());
  arguments.push_back(nullptr);
  ++*argc;
  *argv = arguments.data();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Octets input({reinterpret_cast<const char*>(data), size});
  // Never destroyed: sanitizers look for leaks at the end of a process that still has it.
  static GatewayUnderTest& gateway = *new GatewayUnderTest;  // NOLINT(*-owning-memory)
  gateway.begin();
  restarts_left = 1;
  first_id = gateway.first_id();
  gateway.connect(User::root);
  for (std::size_t step = 0; step < kMostSteps && !input.done(); ++step) {
    const unsigned what = input.next();
    const unsigned client = input.next();
    act(gateway, what, client % GatewayUnderTest::kMostClients, input.take(input.next()));
    gateway.finish();
  }
  return 0;
}
