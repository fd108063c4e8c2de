// SPDX-License-Identifier: BSD-2-Clause
// The peer of `tests/bench/compile_time`: the check of figures 3 and 4 of the paper with Boost.MPL,
// in the manner of FAMOUSO: type lists, search by category, one assertion that names the types.
#pragma once
#include <stdint.h>

#include <boost/mpl/assert.hpp>
#include <boost/mpl/begin_end.hpp>
#include <boost/mpl/bool.hpp>
#include <boost/mpl/count_if.hpp>
#include <boost/mpl/deref.hpp>
#include <boost/mpl/eval_if.hpp>
#include <boost/mpl/find_if.hpp>
#include <boost/mpl/identity.hpp>
#include <boost/mpl/list.hpp>
#include <boost/mpl/placeholders.hpp>
#include <boost/type_traits/is_same.hpp>

namespace mpl_peer {

template <uint32_t v>
struct Period {
  typedef Period type;
  typedef Period<0> category;
  static const uint32_t value = v;
};
template <uint32_t v>
struct Omission {
  typedef Omission type;
  typedef Omission<0> category;
  static const uint32_t value = v;
};
template <uint32_t v>
struct Latency {
  typedef Latency type;
  typedef Latency<0> category;
  static const uint32_t value = v;
};

template <class A, class B>
struct SameCategory : boost::is_same<typename A::category, typename B::category> {};

/// True when no later attribute repeats the category of an earlier one.
template <class List, class At = typename boost::mpl::begin<List>::type>
struct Distinct {
  typedef typename boost::mpl::deref<At>::type Attribute;
  static const bool value =
      boost::mpl::count_if<List, SameCategory<boost::mpl::_1, Attribute>>::value == 1 &&
      Distinct<List, typename boost::mpl::next<At>::type>::value;
};
template <class List>
struct Distinct<List, typename boost::mpl::end<List>::type> : boost::mpl::true_ {};

template <class A, class B, class C>
struct AttributeList {
  typedef typename boost::mpl::list<A, B, C>::type type;
  BOOST_MPL_ASSERT_MSG((Distinct<type>::value), REPEATED_ATTRIBUTES, (type));
};

template <class Provided, class Required>
struct TestAttributes {
  typedef TestAttributes type;
  BOOST_MPL_ASSERT_MSG((Provided::value <= Required::value), ATTRIBUTES_MISMATCH,
                       (Provided, Required));
};

/// One provided attribute against its namesake in the list, if there is one.
template <class List, class Provided>
struct CheckAttributeAgainstAttributeList {
  typedef typename boost::mpl::find_if<List, SameCategory<boost::mpl::_1, Provided>>::type Found;
  typedef typename boost::mpl::eval_if<
      boost::is_same<Found, typename boost::mpl::end<List>::type>, boost::mpl::identity<void>,
      TestAttributes<Provided, typename boost::mpl::deref<Found>::type>>::type type;
};

}  // namespace mpl_peer
