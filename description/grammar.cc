// SPDX-License-Identifier: BSD-2-Clause
// The table that make-grammar generates from system.xsd, and the checks that it agrees with the
// code.
#include "description/grammar.hpp"

#include <algorithm>
#include <span>

#include "core/model/words.hpp"
#include "description/short_form.hpp"

namespace mlcca::description {

#include "grammar_table.inc"

namespace {

namespace words = core::words;

/// Whether the words of an enumeration in the schema are exactly the enumerators.
template <std::size_t N, class Enum>
consteval bool are(const ValueType& type, const core::Words<Enum, N>& known) {
  return std::ranges::equal(type.values, known);
}

static_assert(are(type::kBetter, words::kBetters));
static_assert(are(type::kExcess, words::kExcesses));
static_assert(are(type::kForwarder, words::kForwarders));
static_assert(are(type::kFrameFormat, words::kFrameFormats));
static_assert(are(type::kInterference, words::kInterferences));
static_assert(are(type::kLinkMetric, words::kAwdsMetrics));
static_assert(are(type::kNetworkKind, words::kNetworkKinds));
static_assert(are(type::kProfile, words::kProfiles));
static_assert(are(type::kQueueing, words::kQueueings));
static_assert(are(type::kRateKind, words::kRateKinds));
static_assert(are(type::kRefused, words::kRefusals));
static_assert(are(type::kSourceKind, words::kSourceKinds));
/// Whether the list has a short name for each built-in attribute.
consteval bool has_every_short_name(const ElementType& list) {
  return std::ranges::all_of(kAttributeTable, [&](const AttributeInfo& row) {
    return std::ranges::any_of(list.keys,
                               [&](const Key& key) { return is_short_of(key.name, row.name); });
  });
}
static_assert(has_every_short_name(element::kAttributes));

// kSafeSides begins with an empty word, for a channel without the attribute.
static_assert(std::ranges::equal(type::kSafeSide.values,
                                 std::span(words::kSafeSides).subspan<1>()));

static_assert(std::ranges::equal(type::kArrival.values, std::span(words::kArrivals)));

}  // namespace

const Child& system_root() { return kRoot; }
std::span<const Child> system_parts() { return kParts; }
std::span<const ElementType* const> element_types() { return kElementTypes; }
std::span<const ValueType* const> value_types() { return kValueTypes; }

}  // namespace mlcca::description
