// SPDX-License-Identifier: BSD-2-Clause
// The vocabulary of the compile-time error, and how a failed value is shown as the attribute that
// the user wrote. All of it is instantiated only on the way to an error. C++14, freestanding.
#pragma once
#include "mlcca/attribute_list.hpp"
#include "mlcca/check.hpp"
#include "mlcca/union.hpp"

namespace mlcca {

/// The error. `What` states where (HOP or END_TO_END, nothing for a single layer), what is
/// provided, and what is required.
template <class... What>
struct ATTRIBUTES_MISMATCH {};

template <class A>
struct PROVIDED {};  ///< by the network, the gateway or the route
struct NOT_PROVIDED {};
template <class A>
struct PUBLISHED {};  ///< what the publisher sends
struct NOT_PUBLISHED {};
template <class A, class... Why>
struct REQUIRED {};
struct AS_DEADLINE {};  ///< the reason: a Period without a Deadline implies one
template <class A>
struct ACCEPTED {};  ///< the most that the subscriber accepts
template <unsigned Number>
struct HOP {};  ///< position on the route, counted from 1
struct END_TO_END {};

namespace detail {

template <bool Condition, class Then, class Else>
struct Select {
  using Type = Then;
};
template <class Then, class Else>
struct Select<false, Then, Else> {
  using Type = Else;
};

/// The first of As that states attribute A with value V, as it was written; void if there is none.
template <Attribute A, Value V, class... As>
struct Written {
  using Type = void;
};
template <Attribute A, Value V, class First, class... Rest>
struct Written<A, V, First, Rest...> {
  using Type = typename Select<(First::kCode & ~kDynamicCode) == code_of(A) && First::kValue == V,
                               First, typename Written<A, V, Rest...>::Type>::Type;
};

/// The first type that is not void; void if there is none.
template <class... All>
struct FirstOf {
  using Type = void;
};
template <class First, class... Rest>
struct FirstOf<First, Rest...> {
  using Type = First;
};
template <class... Rest>
struct FirstOf<void, Rest...> : FirstOf<Rest...> {};

/// Searches a list, or both lists of a Union, for the attribute as it was written.
template <class List, Attribute A, Value V>
struct Find;
template <class... As, Attribute A, Value V>
struct Find<AttributeList<As...>, A, V> : Written<A, V, As...> {};
template <class Publisher, class Subscriber, Attribute A, Value V>
struct Find<Union<Publisher, Subscriber>, A, V>
    : FirstOf<typename Find<Publisher, A, V>::Type, typename Find<Subscriber, A, V>::Type> {};

/// A provided value as it was written: as the attribute, as the Period that promises a Latency, or
/// if it was computed, as the attribute with that value.
template <class Provision, Attribute A, Value V, bool IsDynamic>
struct ProvidedAs
    : FirstOf<typename Find<Provision, A, V>::Type,
              typename Find<Provision, A == Attribute::latency ? Attribute::period : A, V>::Type,
              typename Select<IsDynamic, Dynamic<typename Named<A, V>::Type>,
                              typename Named<A, V>::Type>::Type> {};

/// A required value as it was written, or as the Period that implies a Deadline.
template <class Required, class ImpliedBy>
struct RequiredAs {
  using Type = REQUIRED<Required>;
};
template <class ImpliedBy>
struct RequiredAs<void, ImpliedBy> {
  using Type = REQUIRED<ImpliedBy, AS_DEADLINE>;
};

/// The row to be shown: the first unfit one. A Deadline that is only implied is shown last.
constexpr Comparison first_unfit_row(const CheckResult& check, bool deadline_is_implied) {
  for (size_t i = 0; i < check.count; ++i)
    if (check.rows[i].outcome == Outcome::unfit &&
        (!deadline_is_implied || check.rows[i].attribute != Attribute::deadline))
      return check.rows[i];
  for (size_t i = 0; i < check.count; ++i)
    if (check.rows[i].outcome == Outcome::unfit) return check.rows[i];
  return {};
}

template <class Requirement>
constexpr bool implies_deadline() {
  return !Ends<Requirement>::Publisher::kList.set.has(Attribute::deadline) &&
         !Ends<Requirement>::Subscriber::kList.set.has(Attribute::deadline);
}

/// The error of a network, gateway or route: the first unfit row of Answer::check().
template <class Requirement, class Provision, class Answer, class... Where>
struct NetworkMismatch {
  static constexpr Comparison kRow =
      first_unfit_row(Answer::check(), implies_deadline<Requirement>());
  using Provided = typename ProvidedAs<Provision, held_against(kRow.attribute), kRow.provided,
                                       kRow.dynamic>::Type;
  using Required =
      typename RequiredAs<typename Find<Requirement, kRow.attribute, kRow.required>::Type,
                          typename Find<Requirement, Attribute::period, kRow.required>::Type>::Type;
  static ATTRIBUTES_MISMATCH<
      Where..., typename Select<kRow.known, PROVIDED<Provided>, NOT_PROVIDED>::Type, Required>
  error();
};

/// The error of a publisher that does not send what a subscriber requires.
template <class Publisher, class Subscriber>
struct TrafficMismatch {
  static constexpr Comparison kRow =
      first_unfit_row(check_traffic(Publisher::kList.set, Subscriber::kList.set), false);
  using Asked = typename Find<Subscriber, kRow.attribute, kRow.required>::Type;
  static ATTRIBUTES_MISMATCH<
      typename Select<kRow.known,
                      PUBLISHED<typename ProvidedAs<Publisher, kRow.attribute, kRow.provided,
                                                    kRow.dynamic>::Type>,
                      NOT_PUBLISHED>::Type,
      typename Select<kRow.attribute == Attribute::max_payload, ACCEPTED<Asked>,
                      REQUIRED<Asked>>::Type>
  error();
};

}  // namespace detail
}  // namespace mlcca
