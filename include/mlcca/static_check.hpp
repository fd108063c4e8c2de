// SPDX-License-Identifier: BSD-2-Clause
// The checks at compile time. Each is an alias: `using check = Check<Spec::attributes, Can>;`
// compiles if the attributes fit; if not, there is one error that names the first mismatch. A best
// case can refute here; otherwise it passes, and the daemon decides at run time. The rules are
// those of check.hpp. C++14, freestanding.
#pragma once
#include "mlcca/attribute_list.hpp"
#include "mlcca/check.hpp"
#include "mlcca/mismatch.hpp"
#include "mlcca/union.hpp"
#include "mlcca/user_check.hpp"

namespace mlcca {

/// A network as a hop of a route. Provision is an AttributeList. Frames: the number of frames of
/// this network that carry one event; 0: unknown.
template <class Provision, uint16_t Frames = 1>
struct Network {
  using provision = Provision;
  static constexpr uint16_t kFrames = Frames;
  static constexpr bool kIsGateway = false;
};
/// A gateway between two networks. It limits rate, period and size only if it states them.
template <class Provision>
struct Gateway {
  using provision = Provision;
  static constexpr uint16_t kFrames = 1;
  static constexpr bool kIsGateway = true;
};
/// The route from publisher to subscriber: RouteOf<Network<Can>, Gateway<Pc>, Network<Mesh>>. Each
/// network is a medium of its own.
template <class... Hops>
struct RouteOf {
  static_assert(sizeof...(Hops) >= 1 && sizeof...(Hops) <= kMaxComposedHops,
                "a route has 1 to 16 hops");
};

/// The type of a check that has passed.
struct Fit {
  using fit = Fit;
  using type = Fit;
  static constexpr bool value = true;
};

namespace detail {

enum class Finding : uint8_t { fit, unfit, ask_users };

constexpr Finding finding_of(bool unfit, const ListValues& requirement) {
  if (unfit) return Finding::unfit;
  return requirement.users == 0 ? Finding::fit : Finding::ask_users;
}

/// Maps a finding to the type of a check. Only what is needed is instantiated.
template <Finding>
struct Verdict {
  template <class Question>
  static Fit answer();
};
template <>
struct Verdict<Finding::unfit> {
  template <class Question>
  static decltype(Question::Mismatch::error()) answer();
};
template <>
struct Verdict<Finding::ask_users> {
  template <class Question>
  static decltype(Verdict<Question::Users::kFinding>::template answer<typename Question::Users>())
  answer();
};

/// The user-defined attributes of a requirement against the hops of a route, or one layer.
template <class Requirement, bool IsRoute, class... Hops>
struct UserQuestion {
  using Publisher = typename Ends<Requirement>::Publisher;
  using Subscriber = typename Ends<Requirement>::Subscriber;
  static constexpr size_t kHopCount = sizeof...(Hops);
  static constexpr UserFinding kFound = check_users_of<Publisher, Subscriber, Hops...>();
  static constexpr Finding kFinding =
      kFound.outcome == Outcome::unfit ? Finding::unfit : Finding::fit;
  using Mismatch = UserError<UserQuestion, IsRoute>;
};

constexpr Finding layer_finding(const ListValues& requirement, const ListValues& provision) {
  return finding_of(layer_outcome(requirement.set, provision.set) == Outcome::unfit, requirement);
}

template <class Requirement, class Provision>
struct LayerQuestion {
  static constexpr CheckResult check() {
    return check_layer(Requirement::kList.set, Provision::kList.set);
  }
  using Mismatch = NetworkMismatch<Requirement, Provision, LayerQuestion>;
  using Users = UserQuestion<Requirement, false, Network<Provision>>;
};

constexpr Finding traffic_finding(const ListValues& publisher, const ListValues& subscriber) {
  return check_traffic(publisher.set, subscriber.set).outcome == Outcome::unfit ? Finding::unfit
                                                                                : Finding::fit;
}

template <class Publisher, class Subscriber>
struct TrafficQuestion {
  using Mismatch = TrafficMismatch<Publisher, Subscriber>;
};

/// The hops of a route; each is a medium of its own.
struct Way {
  Hop hops[kMaxComposedHops];
  size_t count = 0;

  /// Returns false if the route is too long, which RouteOf refuses.
  constexpr bool add(const AttributeSet& provision, uint16_t frames, bool gateway) {
    if (count == kMaxComposedHops) return false;
    Hop& hop = hops[count];
    hop.provision = provision;
    hop.medium = static_cast<uint16_t>(count);
    hop.frames = frames;
    hop.gateway = gateway;
    ++count;
    return true;
  }
};

template <class... Hops>
constexpr Way way_of() {
  Way way;
  const bool added[] = {true,
                        way.add(Hops::provision::kList.set, Hops::kFrames, Hops::kIsGateway)...};
  static_cast<void>(added);
  return way;
}

/// The index of the first unfit hop; the number of hops if only the complete route is unfit; one
/// more if everything fits.
constexpr size_t first_unfit_place(const AttributeSet& requirement, const Way& way,
                                   Value source_jitter) {
  for (size_t i = 0; i < way.count; ++i)
    if (check_hop(requirement, way.hops[i]).outcome == Outcome::unfit) return i;
  const CheckResult whole = check_route(requirement, way.hops, way.count, source_jitter);
  return whole.outcome == Outcome::unfit ? way.count : way.count + 1;
}

/// The rows of one hop, and below those of the complete route.
template <class Requirement, class Question, size_t Place>
struct HopAnswer {
  static constexpr CheckResult check() {
    return check_hop(Requirement::kList.set, Question::kWay.hops[Place]);
  }
};
template <class Requirement, class Question>
struct WayAnswer {
  static constexpr CheckResult check() {
    return check_route(Requirement::kList.set, Question::kWay.hops, Question::kWay.count,
                       Question::kSourceJitter);
  }
};

template <class Requirement, class Question, size_t Place, bool IsEndToEnd, class... Hops>
struct RouteMismatch : NetworkMismatch<Requirement, typename At<Place, Hops...>::Type::provision,
                                       HopAnswer<Requirement, Question, Place>, HOP<Place + 1>> {};
template <class Requirement, class Question, size_t Place, class... Hops>
struct RouteMismatch<Requirement, Question, Place, true, Hops...>
    : NetworkMismatch<Requirement, AttributeList<>, WayAnswer<Requirement, Question>, END_TO_END> {
};

template <class Requirement, class Route>
struct RouteQuestion;
template <class Requirement, class... Hops>
struct RouteQuestion<Requirement, RouteOf<Hops...>> {
  static constexpr Way kWay = way_of<Hops...>();
  static constexpr Value kSourceJitter = Ends<Requirement>::Publisher::kList.set[Attribute::jitter];
  static constexpr size_t kPlace = first_unfit_place(Requirement::kList.set, kWay, kSourceJitter);
  static constexpr Finding kFinding =
      sizeof(RouteOf<Hops...>) != 0 && kWay.count == sizeof...(Hops) && kWay.count != 0
          ? finding_of(kPlace <= kWay.count, Requirement::kList)
          : Finding::fit;  // RouteOf has refused the route
  using Mismatch =
      RouteMismatch<Requirement, RouteQuestion, kPlace, kPlace == sizeof...(Hops), Hops...>;
  using Users = UserQuestion<Requirement, true, Hops...>;
};

}  // namespace detail

/// Checks Attributes (an AttributeList or a Union) against the Provision (an AttributeList) of one
/// network layer: figure 5 of the paper.
template <class Attributes, class Provision>
using Check =
    typename decltype(detail::Verdict<detail::layer_finding(Attributes::kList, Provision::kList)>::
                          template answer<detail::LayerQuestion<Attributes, Provision>>())::fit;

/// Checks what a publisher sends against what a subscriber requires of it: Period, Bandwidth,
/// MaxPayload and the Jitter of the source. Both are AttributeLists.
template <class Publisher, class Subscriber>
using CheckTraffic =
    typename decltype(detail::Verdict<detail::traffic_finding(Publisher::kList,
                                                              Subscriber::kList)>::
                          template answer<detail::TrafficQuestion<Publisher, Subscriber>>())::fit;

/// Checks Attributes (an AttributeList or a Union) against each hop of a RouteOf and against the
/// complete route. The Jitter of a Union's publisher is added to that of the route.
template <class Attributes, class Route>
using CheckRoute =
    typename decltype(detail::Verdict<detail::RouteQuestion<Attributes, Route>::kFinding>::
                          template answer<detail::RouteQuestion<Attributes, Route>>())::fit;

}  // namespace mlcca
