// SPDX-License-Identifier: BSD-2-Clause
// The values of an attribute list for code that only knows the built-in attributes. C++14,
// freestanding.
#pragma once
#include "mlcca/attribute.hpp"

namespace mlcca {
namespace detail {

template <class Attributes>
constexpr auto users_in(int) -> decltype(Attributes::kList.users) {
  return Attributes::kList.users;
}
template <class Attributes>
constexpr int users_in(...) {
  return 0;
}

}  // namespace detail

/// The set of an AttributeList, or of any type with a static constexpr set(). It cannot contain
/// user-defined attributes, and to leave out a requirement would weaken it: a list with any does
/// not compile.
template <class Attributes>
constexpr AttributeSet values_of() {
  static_assert(detail::users_in<Attributes>(0) == 0,
                "the user's own attributes are not part of this set");
  return Attributes::set();
}

}  // namespace mlcca
