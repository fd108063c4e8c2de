// SPDX-License-Identifier: BSD-2-Clause
// Attributes of the user's own at compile time: found by their template, compared and composed by
// the same functions as the others. Instantiated only where a requirement has one.
// C++14, freestanding.
#pragma once
#include "mlcca/attribute_list.hpp"
#include "mlcca/compose.hpp"
#include "mlcca/mismatch.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca {
namespace detail {

/// Most attributes of the user's own in one list.
constexpr size_t kMaxUserAttributes = 8;

struct UserValue {
  const char* tag = nullptr;  ///< its address tells attributes apart
  size_t index = 0;           ///< in the list
  Value value = 0;
  Better better = Better::smaller;
  Composition composition = Composition::sum;
  bool dynamic = false;
};

/// The attributes of the user's own in one list.
struct UserValues {
  UserValue values[kMaxUserAttributes];
  size_t count = 0;
  size_t seen = 0;  ///< attributes of the list so far, the table's among them
  bool distinct = true;

  /// The place of the attribute, or count.
  constexpr size_t find(const char* tag) const {
    size_t i = 0;
    while (i < count && values[i].tag != tag) ++i;
    return i;
  }
  constexpr bool skip() {
    ++seen;
    return false;
  }
  constexpr bool add(const char* tag, Value value, Better better, Composition composition,
                     bool dynamic) {
    distinct = distinct && find(tag) == count;
    if (count == kMaxUserAttributes) return false;
    UserValue& added = values[count++];
    added.tag = tag;
    added.index = seen++;
    added.value = value;
    added.better = better;
    added.composition = composition;
    added.dynamic = dynamic;
    return true;
  }
};

template <bool IsUser, class A>
struct UserValueOf {
  static constexpr bool add(UserValues& list) { return list.skip(); }
};
template <class A>
struct UserValueOf<true, A> {
  static constexpr bool add(UserValues& list) {
    return list.add(&A::Tag::id, A::kValue, A::kBetter, A::kComposition,
                    (A::kCode & kDynamicCode) != 0);
  }
};

template <class List>
struct UsersOf;
template <class... As>
struct UsersOf<AttributeList<As...>> {
  static constexpr UserValues values() {
    UserValues list;
    const bool added[] = {false, UserValueOf < (As::kCode & kUserCode) != 0, As > ::add(list)...};
    static_cast<void>(added);
    return list;
  }
};

/// The values of a list that is in order.
template <class List>
constexpr UserValues users_of() {
  static_assert(List::kList.users <= kMaxUserAttributes,
                "an AttributeList has at most 8 attributes of the user's own");
  static_assert(UsersOf<List>::values().distinct,
                "an attribute is given twice in one AttributeList");
  return UsersOf<List>::values();
}

/// What a hop provides of them.
struct UserHop {
  UserValues provision;
  uint16_t frames;  ///< of an event
  bool gateway;
};

/// What an attribute of the user meets on a hop, or (place == number of hops) end to end.
struct UserFinding {
  Outcome outcome = Outcome::fit;
  size_t attribute = 0;  ///< index in the publisher's list and then the subscriber's
  size_t place = 0;
  bool known = false;
  bool dynamic = false;
  Value provided = 0;

  constexpr void compare(const UserValue& required, Value value) {
    provided = value;
    outcome = outcome_of(satisfies(required.better, value, required.value), dynamic);
  }
};

/// One attribute against every hop and the whole route. A gateway that says nothing of a maximum or
/// a minimum does not limit it and is not asked.
constexpr UserFinding check_user(const UserValue& required, const UserHop* hops, size_t count) {
  HopValue values[kMaxComposedHops];
  UserFinding finding;
  for (; finding.place < count; ++finding.place) {
    const UserHop& hop = hops[finding.place];
    const size_t found = hop.provision.find(required.tag);
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

/// The first attribute of either end that is unfit; fit when there is none.
constexpr UserFinding check_users(const UserValues (&ends)[2], const UserHop* hops, size_t count) {
  for (size_t end = 0; end < 2; ++end)
    for (size_t i = 0; i < ends[end].count; ++i) {
      UserFinding finding = check_user(ends[end].values[i], hops, count);
      finding.attribute = ends[end].values[i].index + (end == 0 ? 0 : ends[0].seen);
      if (finding.outcome == Outcome::unfit) return finding;
    }
  return {};
}

/// The same for AttributeLists and hops.
template <class Publisher, class Subscriber, class... Hops>
constexpr UserFinding check_users_of() {
  const UserValues ends[] = {users_of<Publisher>(), users_of<Subscriber>()};
  const UserHop hops[] = {
      {users_of<typename Hops::provision>(), Hops::kFrames, Hops::kIsGateway}...};
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

/// The error for Question::kFound.
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

/// On a route, which says where, and of a layer.
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
