// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's check of what a network layer provides against what a channel requires, in the global
// namespace.
#pragma once
#include "mlcca/static_check.hpp"

namespace mlcca {
namespace detail {

/// What a list asks of one attribute: its namesake, and what is held against it.
constexpr AttributeSet asked_of(const AttributeSet& required, Attribute provided) {
  AttributeSet asked = normalised_requirement(required);
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (a != provided && held_against(a) != provided) asked.clear(a);
  }
  return asked;
}

/// One attribute is held against its namesake in the list, a Latency against the Deadline too. What
/// the list does not name is not asked for.
template <class Required, class Provided>
struct FamousoQuestion {
  static constexpr CheckResult check() {
    constexpr auto kProvided = static_cast<Attribute>(Provided::kCode);
    // Who provides a Deadline delivers within it, which is what a required one is held against.
    return check_normalised(asked_of(Required::kList.set, kProvided),
                            AttributeSet().set(held_against(kProvided), Provided::kValue));
  }
  struct Mismatch {
    static ATTRIBUTES_MISMATCH<
        PROVIDED<Provided>,
        typename NetworkMismatch<Required, AttributeList<Provided>, FamousoQuestion>::Required>
    error();
  };
};
/// A list is checked like a network layer: what it does not provide is not fulfilled.
template <class Required, class... Provided>
struct FamousoQuestion<Required, AttributeList<Provided...>>
    : LayerQuestion<Required, AttributeList<Provided...>> {};

template <class Question>
constexpr Finding famouso_finding() {
  return Question::check().outcome == Outcome::unfit ? Finding::unfit : Finding::fit;
}

}  // namespace detail
}  // namespace mlcca

/// Required is an AttributeList, Provided an attribute or an AttributeList. To name its ::type is
/// to check.
template <class Required, class Provided>
struct CheckAttributeAgainstAttributeList {
  using type = CheckAttributeAgainstAttributeList;
  using Question = mlcca::detail::FamousoQuestion<typename Required::type, typename Provided::type>;
  using Verdict = mlcca::detail::Verdict<mlcca::detail::famouso_finding<Question>()>;
  using fit = typename decltype(Verdict::template answer<Question>())::fit;
};
