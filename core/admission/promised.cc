// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/promised.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/admission/permits.hpp"
#include "core/can/cover.hpp"
#include "core/can/level.hpp"

namespace mlcca::core {
namespace {

/// What a flow is promised for one reason or several.
struct Promise {
  Value bytes_per_second = 0;
  std::optional<can::Message> message;
  std::vector<cluster::PathPart> paths;
  bool by_others = false;

  void take(Value bytes) { bytes_per_second = std::max(bytes_per_second, bytes); }
  void take(can::Message m) {
    m.key = 0;
    message = message ? can::strictest(*message, m) : m;
  }
  void take(const cluster::PathPart& path) { join(paths, path); }
};

/// The promises of a network, put together.
class Promises {
 public:
  /// `self`: the gateway in whose numbers admissions are those of this state; nothing: none is.
  Promises(const System& system, const Members& members, std::size_t network,
           std::optional<std::size_t> self)
      : system_(system), members_(members), network_(network), self_(self) {}

  void take(const cluster::Standing& standing) {
    Promise& promise = all_[standing.flow];
    promise.take(standing.bytes_per_second);
    if (standing.message) promise.take(*standing.message);
    for (const cluster::PathPart& path : standing.paths) promise.take(path);
  }
  void take(const cluster::Part& part) { take_all(part, false); }
  /// Of what others hold: the traffic of publishers that are there.
  void take(const cluster::Foreign& foreign) { take_all(foreign, true); }

  [[nodiscard]] const std::map<Flow, Promise>& all() const { return all_; }
  [[nodiscard]] bool complete() const { return complete_; }

 private:
  template <class Parts>
  void take_all(const Parts& parts, bool by_others) {
    constexpr Value too_much = Value{1} << 44U;  // and little enough that sums do not overflow
    for (const cluster::RatePart& rate : parts.rates)
      if (Promise* const promise = of(rate, by_others))
        promise->take(std::min(rate.bytes_per_second, too_much));
    for (const cluster::BusPart& bus : parts.bus)
      if (Promise* const promise = of(bus, by_others)) promise->take(bus.message);
    for (const cluster::PathPart& path : parts.paths)
      if (Promise* const promise = of(path, by_others)) promise->take(path);
  }

  /// Null where the publisher is not there.
  template <class Part>
  Promise* of(const Part& part, bool by_others) {
    const cluster::Source& source = part.source;
    std::size_t publisher = source.publisher;
    if (source.admission != 0) {
      if (by_others && part.gateway != self_) return nullptr;  // see core::others_on()
      const auto admitted = members_.admitted(source.admission).publisher;
      if (!admitted) return nullptr;
      publisher = *admitted;
    } else if (publisher >= system_.publishers.size()) {
      complete_ = false;
      return nullptr;
    }
    Promise& promise = all_[{publisher, network_, source.from}];
    promise.by_others = promise.by_others || by_others;
    return &promise;
  }

  const System& system_;
  const Members& members_;
  std::size_t network_;
  std::optional<std::size_t> self_;
  std::map<Flow, Promise> all_;
  bool complete_ = true;
};

/// The gateway that puts the flow on the network; nothing where its publisher is there itself.
std::optional<std::size_t> sender_of(const System& system, const Flow& flow) {
  if (flow.from == Flow::kOwn || flow.from < system.networks.size()) return std::nullopt;
  return flow.from - system.networks.size();
}

/// It is promised for a gateway that has failed, and another one carries it in its place.
bool is_replaced(const System& system, const World& world, const cluster::Standing& standing) {
  const auto sender = sender_of(system, standing.flow);
  return standing.elected && sender && world.failed[*sender];
}

/// A network as it is now.
struct Medium {
  std::optional<can::Assumptions> bus;
  const mesh::Mesh* mesh = nullptr;
  const MeshView* view = nullptr;
};

/// `complete`: false from now on if not all of the promise can be counted.
Placeholder placeholder_of(const Flow& flow, const Promise& promise, const Medium& medium,
                           bool& complete) {
  Placeholder p;
  p.flow = flow;
  p.bytes_per_second = promise.bytes_per_second;
  p.by_others = promise.by_others;
  if (promise.message && medium.bus && can::usable(*medium.bus, *promise.message))
    p.message = promise.message;
  complete = complete && promise.message.has_value() == p.message.has_value();
  if (promise.paths.empty()) return p;
  auto shares = medium.mesh == nullptr || medium.view == nullptr
                    ? std::nullopt
                    : shares_of_joined(*medium.mesh, *medium.view, promise.paths);
  complete = complete && shares;
  if (shares) p.shares = std::move(*shares);
  return p;
}

}  // namespace

Others promised_beside(const Situation& s, std::size_t network, const MeshView* view) {
  const System& system = s.system;
  const Members& members = s.members;
  const World& world = s.world;
  const Permits* const permits = s.permits;
  const auto self = permits != nullptr ? std::optional(permits->self()) : std::nullopt;
  const CountsWithPublisher counts = [&](std::size_t gateway, const cluster::Source& source) {
    return gateway == self && members.admitted(source.admission).publisher.has_value();
  };
  Others others = core::others_on(system, world, network, view, counts);
  Promises promises(system, members, network, self);
  promises.take(world.foreign[network]);
  if (permits != nullptr) {
    for (const cluster::Standing& standing : permits->standing(network))
      if (!is_replaced(system, world, standing)) promises.take(standing);
    for (const auto& [number, part] : permits->reserved(network)) promises.take(part);
  }
  others.complete = others.complete && promises.complete();
  const Medium medium{
      .bus = bus_of(system, world.conditions[network], network),
      .mesh = system.networks[network].mesh ? &*system.networks[network].mesh : nullptr,
      .view = view};
  for (const auto& [flow, promise] : promises.all())
    others.standing.push_back(placeholder_of(flow, promise, medium, others.complete));
  return others;
}

}  // namespace mlcca::core
