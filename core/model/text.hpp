// SPDX-License-Identifier: BSD-2-Clause
// Decisions in words for a person: values with units, the one line that says why.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/graph.hpp"
#include "core/model/members.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// "50 ms", "400 kB/s", "0.5 %", "2", "unbounded": at most three decimals, rounded to the nearest.
[[nodiscard]] std::string format_value(Attribute attribute, Value value);
/// A bound and its limit as format_value has them, with as many decimals as it takes to see that
/// one is not the other: "10.0004 ms" and "10 ms".
struct BoundWords {
  std::string bound;
  std::string limit;
};
[[nodiscard]] BoundWords format_bound(Attribute attribute, Value bound, Value limit);
/// Of a row: what is provided, and what is required.
[[nodiscard]] BoundWords format_bound(const System& system, const Row& row);
/// "1 d 2 h", "3 min 20 s", "4 s" of nanoseconds: the two largest units that it has, rounded down.
[[nodiscard]] std::string format_span(Value ns);

/// Of a row: its attribute's name, and values as format_value has them. A user-defined one is
/// "21.5 K".
[[nodiscard]] std::string attribute_name(const System& system, const Row& row);
/// Unit of the row's integers: "ns", or "1e-3 K" of a user-defined attribute.
[[nodiscard]] std::string unit_name(const System& system, const Row& row);
/// The other way round: unit and magnitude of "1e-3 K". What begins otherwise is a unit as it is.
[[nodiscard]] UserAttribute of_unit(std::string_view name);
[[nodiscard]] std::string format_value(const System& system, const Row& row, Value value);
[[nodiscard]] std::string format_user_value(const UserAttribute& attribute, Value value);
[[nodiscard]] std::string format_margin(const System& system, const Row& row);

/// "3 too many", "12.5 ms to spare", "exactly met"; "not provided" where nothing is known.
[[nodiscard]] std::string format_margin(const Comparison& comparison);

/// "0xa4efeccc3210b497", always 16 digits.
[[nodiscard]] std::string format_subject(Subject subject);

[[nodiscard]] std::string_view to_text(NetworkKind kind);
[[nodiscard]] std::string_view to_text(Profile profile);
[[nodiscard]] std::string_view to_text(mesh::SourceKind kind);
[[nodiscard]] std::string_view to_text(mesh::RateKind kind);
[[nodiscard]] std::string_view to_text(mesh::Lack lack);
/// "nl80211 mesh0".
[[nodiscard]] std::string name_of(const mesh::Source& source);

[[nodiscard]] const std::string& name_of(const System& system, Place place);

/// Of a mesh that has nodes, and neither links nor sources of them; empty: it is none.
[[nodiscard]] std::string no_links_words(const Network& network);

/// "a", "a and b", "a, b, c and 5 more": those publishers.
[[nodiscard]] std::string names_of(const Members& members,
                                   const std::vector<std::size_t>& publishers);

/// What a row checks: a hop's name, "end to end", "publisher NAME for NAME", "capacity of NAME",
/// "listeners on NAME", "response times on NAME", "time left on NAME".
[[nodiscard]] std::string where(const System& system, const Members& members,
                                const Verdict& verdict, const Row& row);

/// A failed schedule row in words: whose frames would be late or lost, by how much.
[[nodiscard]] std::string schedule_text(const System& system, const Members& members,
                                        const Row& row);

/// "174 ms = (Omission 2 + 1) x Period 50 ms + Latency 12 ms + Jitter 12 ms": how long after the
/// last heart-beat a subscriber reacts at the latest. Empty where that is not known.
[[nodiscard]] std::string reaction(const Verdict& verdict);

/// Why, in one line without a full stop: the failed attribute, the hop, by how much; of a grant the
/// tightest margin.
[[nodiscard]] std::string reason(const System& system, const Members& members,
                                 const Verdict& verdict, const std::string& problem = {});

}  // namespace mlcca::core
