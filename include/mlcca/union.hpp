// SPDX-License-Identifier: BSD-2-Clause
// A publisher and a subscriber as one requirement, at compile time. C++14, freestanding.
#pragma once
#include "mlcca/attribute_list.hpp"
#include "mlcca/check.hpp"

namespace mlcca {

/// What publisher and subscriber, two AttributeLists, together ask of the networks between them:
/// requirement_between(). Stands for the attributes in Check and CheckRoute.
template <class Publisher, class Subscriber>
struct Union {
  static constexpr detail::ListValues kList = {
      requirement_between(Publisher::kList.set, Subscriber::kList.set),
      static_cast<uint8_t>(Publisher::kList.users + Subscriber::kList.users), true};
};

namespace detail {

/// The two lists of a requirement; a list alone is a subscriber's.
template <class Requirement>
struct Ends {
  using Publisher = AttributeList<>;
  using Subscriber = Requirement;
};
template <class P, class S>
struct Ends<Union<P, S>> {
  using Publisher = P;
  using Subscriber = S;
};

}  // namespace detail
}  // namespace mlcca
