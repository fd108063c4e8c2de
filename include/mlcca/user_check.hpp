// SPDX-License-Identifier: BSD-2-Clause
// Checks of user-defined attributes at compile time. They are identified by their template, and
// compared and composed by the same functions as the built-in ones. Instantiated only if a
// requirement has one. C++14, freestanding.
#pragma once
#include "mlcca/attribute_list.hpp"
#include "mlcca/compose.hpp"
#include "mlcca/mismatch.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca {
namespace detail {

/// The most user-defined attributes of one list.
constexpr size_t kMaxUserAttributes = 16;

struct UserValue {
  size_t index = 0;  ///< index in the list
  Value value = 0;
  Better better = Better::smaller;
  Composition composition = Composition::sum;
  bool dynamic = false;
};

/// The user-defined attributes of one list.
struct UserValues {
  UserValue values[kMaxUserAttributes];
  size_t count = 0;
  size_t seen = 0;  ///< number of attributes of the list so far, built-in ones included
  bool distinct = true;

  /// The position in `values` of the attribute with that index in the list; `count` if there is
  /// none.
  constexpr size_t find(size_t index) const {
    size_t i = 0;
    while (i < count && values[i].index != index) ++i;
    return i;
  }
  constexpr bool skip() {
    ++seen;
    return false;
  }
  /// Adds an attribute. `first`: the first index of its template in the list, to detect duplicates.
  constexpr bool add(size_t first, Value value, Better better, Composition composition,
                     bool dynamic) {
    const size_t index = seen++;
    distinct = distinct && first == index;
    if (count == kMaxUserAttributes) return false;
    UserValue& added = values[count++];
    added.index = index;
    added.value = value;
    added.better = better;
    added.composition = composition;
    added.dynamic = dynamic;
    return true;
  }
};

/// For each user-defined attribute of one list its index in another list.
struct UserPlaces {
  size_t places[kMaxUserAttributes] = {};
  size_t count = 0;

  constexpr bool add(size_t place) {
    if (count == kMaxUserAttributes) return false;
    places[count++] = place;
    return true;
  }
};

template <class A, class B>
struct IsSame {
  static constexpr bool kSame = false;
};
template <class A>
struct IsSame<A, A> {
  static constexpr bool kSame = true;
};

/// An element of a list. Built-in attributes have no tag.
template <class A, bool IsUser = (A::kCode & kUserCode) != 0>
struct Element {
  using Tag = void;
  template <class List>
  static constexpr bool add(UserValues& values) {
    return values.skip();
  }
  template <class List>
  static constexpr bool find(UserPlaces&) {
    return false;
  }
};

/// Finds the first index of an attribute in a list. It does not depend on the value, so the
/// compiler instantiates it once per attribute. An address per tag would be simpler, but avr-g++
/// 5.4 does not compare addresses at compile time.
template <class Tag, class List>
struct PlaceIn;
template <class Tag, class... As>
struct PlaceIn<Tag, AttributeList<As...>> {
  /// The index, or the length of the list if the attribute is not in it.
  static constexpr size_t place() {
    const bool same[] = {IsSame<Tag, typename Element<As>::Tag>::kSame..., true};
    size_t i = 0;
    while (!same[i]) ++i;
    return i;
  }
};

template <class A>
struct Element<A, true> {
  using Tag = typename A::Tag;
  template <class List>
  static constexpr bool add(UserValues& values) {
    return values.add(PlaceIn<Tag, List>::place(), A::kValue, A::kBetter, A::kComposition,
                      (A::kCode & kDynamicCode) != 0);
  }
  template <class List>
  static constexpr bool find(UserPlaces& places) {
    return places.add(PlaceIn<Tag, List>::place());
  }
};

/// The user-defined attributes of a list: their values, and their indices in a provision.
template <class List>
struct UsersOf;
template <class... As>
struct UsersOf<AttributeList<As...>> {
  static constexpr UserValues values() {
    UserValues values;
    const bool added[] = {false, Element<As>::template add<AttributeList<As...>>(values)...};
    static_cast<void>(added);
    return values;
  }
  template <class Provision>
  static constexpr UserPlaces places_in() {
    UserPlaces places;
    const bool found[] = {false, Element<As>::template find<Provision>(places)...};
    static_cast<void>(found);
    return places;
  }
};

/// The values of a list, after checking that it is valid.
template <class List>
constexpr UserValues users_of() {
  static_assert(List::kList.users <= kMaxUserAttributes,
                "an AttributeList has at most 16 attributes of the user's own");
  static_assert(UsersOf<List>::values().distinct,
                "an attribute is given twice in one AttributeList");
  return UsersOf<List>::values();
}

/// One hop with the user-defined attributes that it provides.
struct UserHop {
  UserValues provision;
  UserPlaces places[2];  ///< for the attributes of publisher and subscriber: their indices in the
                         ///< provision
  uint16_t frames;       ///< frames of one event
  bool gateway;
};

/// The comparison of a user-defined attribute with one hop, or with the complete route if `place`
/// is the number of hops.
struct UserFinding {
  Outcome outcome = Outcome::fit;
  size_t attribute = 0;  ///< index in the publisher's list followed by the subscriber's
  size_t place = 0;
  bool known = false;
  bool dynamic = false;
  Value provided = 0;

  constexpr void compare(const UserValue& required, Value value) {
    provided = value;
    outcome = outcome_of(satisfies(required.better, value, required.value), dynamic);
  }
};

/// Compares attribute `i` of an endpoint with every hop and with the complete route. A gateway that
/// does not state a maximum or minimum does not limit it and is skipped.
constexpr UserFinding check_user(const UserValues (&ends)[2], size_t end, size_t i,
                                 const UserHop* hops, size_t count) {
  const UserValue& required = ends[end].values[i];
  HopValue values[kMaxComposedHops];
  UserFinding finding;
  for (; finding.place < count; ++finding.place) {
    const UserHop& hop = hops[finding.place];
    const size_t found = hop.provision.find(hop.places[end].places[i]);
    HopValue& value = values[finding.place];
    value.frames = hop.frames;
    finding.known = found != hop.provision.count;
    if (!finding.known && hop.gateway && unlimited_by_gateway(required.composition, &value.value))
      continue;
    finding.outcome = Outcome::unfit;
    if (!finding.known) return finding;
    value.value = hop.provision.values[found].value;
    finding.dynamic = finding.dynamic || hop.provision.values[found].dynamic;
    finding.compare(required, compose_values(required.composition, &value, 1));
    if (finding.outcome == Outcome::unfit) return finding;
  }
  finding.known = true;
  finding.compare(required, compose_values(required.composition, values, count));
  return finding;
}

/// The first unfit attribute of either endpoint; outcome fit if there is none.
constexpr UserFinding check_users(const UserValues (&ends)[2], const UserHop* hops, size_t count) {
  for (size_t end = 0; end < 2; ++end)
    for (size_t i = 0; i < ends[end].count; ++i) {
      UserFinding finding = check_user(ends, end, i, hops, count);
      finding.attribute = ends[end].values[i].index + (end == 0 ? 0 : ends[0].seen);
      if (finding.outcome == Outcome::unfit) return finding;
    }
  return {};
}

template <class Publisher, class Subscriber, class Provision>
constexpr UserHop hop_of(uint16_t frames, bool gateway) {
  return {users_of<Provision>(),
          {UsersOf<Publisher>::template places_in<Provision>(),
           UsersOf<Subscriber>::template places_in<Provision>()},
          frames,
          gateway};
}

/// check_users() for AttributeLists and hops.
template <class Publisher, class Subscriber, class... Hops>
constexpr UserFinding check_users_of() {
  const UserValues ends[] = {users_of<Publisher>(), users_of<Subscriber>()};
  const UserHop hops[] = {
      hop_of<Publisher, Subscriber, typename Hops::provision>(Hops::kFrames, Hops::kIsGateway)...};
  return check_users(ends, hops, sizeof...(Hops));
}

template <size_t Index, class First, class... Rest>
struct At : At<Index - 1, Rest...> {};
template <class First, class... Rest>
struct At<0, First, Rest...> {
  using Type = First;
};
template <size_t Index, class Publisher, class Subscriber>
struct AtEnds;
template <size_t Index, class... Ps, class... Ss>
struct AtEnds<Index, AttributeList<Ps...>, AttributeList<Ss...>> : At<Index, Ps..., Ss...> {};

/// The parts of the error for Question::kFound.
template <class Question>
struct UserMismatch {
  static constexpr UserFinding kFound = Question::kFound;
  using Required = typename AtEnds<kFound.attribute, typename Question::Publisher,
                                   typename Question::Subscriber>::Type;
  using Certain = typename Required::template With<kFound.provided>;
  using Provided =
      typename Select<kFound.known,
                      PROVIDED<typename Select<kFound.dynamic, Dynamic<Certain>, Certain>::Type>,
                      NOT_PROVIDED>::Type;
  using Place =
      typename Select<kFound.place == Question::kHopCount, END_TO_END, HOP<kFound.place + 1>>::Type;
};

/// The error for a route, which names the place, and below the one for a layer.
template <class Question, bool IsRoute>
struct UserError {
  static ATTRIBUTES_MISMATCH<typename UserMismatch<Question>::Place,
                             typename UserMismatch<Question>::Provided,
                             REQUIRED<typename UserMismatch<Question>::Required>>
  error();
};
template <class Question>
struct UserError<Question, false> {
  static ATTRIBUTES_MISMATCH<typename UserMismatch<Question>::Provided,
                             REQUIRED<typename UserMismatch<Question>::Required>>
  error();
};

}  // namespace detail
}  // namespace mlcca
