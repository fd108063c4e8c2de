// SPDX-License-Identifier: BSD-2-Clause
// A publisher and a subscriber as one requirement at compile time. C++14, freestanding.
#pragma once
#include "mlcca/attribute_list.hpp"
#include "mlcca/check.hpp"

namespace mlcca {

/// The requirement of a publisher and a subscriber (two AttributeLists) towards the networks
/// between them, by requirement_between(). Use it as the attributes of Check and CheckRoute.
template <class Publisher, class Subscriber>
struct Union {
  static constexpr detail::ListValues kList = {
      requirement_between(Publisher::kList.set, Subscriber::kList.set),
      static_cast<uint8_t>(Publisher::kList.users + Subscriber::kList.users), true};
};

namespace detail {

/// The two lists of a requirement; a single list is taken as the subscriber's.
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
