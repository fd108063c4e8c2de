// SPDX-License-Identifier: BSD-2-Clause
// Decisions as text for a person: values with their units, margins, and the one line that states
// the reason.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/graph.hpp"
#include "core/model/members.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// Formats a value of a built-in attribute with a readable unit, such as "50 ms", "400 kB/s", "0.5
/// %", "2" or "unbounded". It is rounded to the nearest with at most three decimals.
[[nodiscard]] std::string format_value(Attribute attribute, Value value);
/// A bound and its limit, formatted like format_value() but with as many decimals as are needed to
/// make the two texts differ, such as "10.0004 ms" and "10 ms".
struct BoundWords {
  std::string bound;
  std::string limit;
};
[[nodiscard]] BoundWords format_bound(Attribute attribute, Value bound, Value limit);
/// Formats what the row's route or hop provides (bound) and what is required (limit).
[[nodiscard]] BoundWords format_bound(const System& system, const Row& row);
/// Formats a duration in ns by its two largest units, rounded down: "1 d 2 h", "3 min 20 s", "4 s".
[[nodiscard]] std::string format_span(Value ns);

/// The name of the attribute that the row compares, built-in or user-defined.
[[nodiscard]] std::string attribute_name(const System& system, const Row& row);
/// The unit of the row's integers: "ns", or for a user-defined attribute with a magnitude "1e-3 K".
[[nodiscard]] std::string unit_name(const System& system, const Row& row);
/// The inverse of unit_name(): parses "1e-3 K" into magnitude and unit. A text that has no valid
/// "1e" prefix is taken as the unit with magnitude 0.
[[nodiscard]] UserAttribute of_unit(std::string_view name);
/// These format values of a row. A value of a user-defined attribute reads like "21.5 K".
[[nodiscard]] std::string format_value(const System& system, const Row& row, Value value);
[[nodiscard]] std::string format_user_value(const UserAttribute& attribute, Value value);
/// See format_margin(Comparison); also for user-defined attributes.
[[nodiscard]] std::string format_margin(const System& system, const Row& row);

/// Formats how far provision and requirement are apart: "3 too many", "12.5 ms to spare", "exactly
/// met"; "not provided" if the attribute is not provided.
[[nodiscard]] std::string format_margin(const Comparison& comparison);

/// Formats a subject as "0xa4efeccc3210b497", always with 16 digits.
[[nodiscard]] std::string format_subject(Subject subject);

[[nodiscard]] std::string_view to_text(NetworkKind kind);
[[nodiscard]] std::string_view to_text(Profile profile);
[[nodiscard]] std::string_view to_text(mesh::SourceKind kind);
[[nodiscard]] std::string_view to_text(mesh::RateKind kind);
[[nodiscard]] std::string_view to_text(mesh::Lack lack);
/// Names a source of links by its kind and interface or endpoint: "nl80211 mesh0".
[[nodiscard]] std::string name_of(const mesh::Source& source);

[[nodiscard]] const std::string& name_of(const System& system, Place place);

/// The finding about a mesh that has nodes but neither links nor sources of links, so that no path
/// through it can ever be known. Returns an empty text if that is not the case.
[[nodiscard]] std::string no_links_words(const Network& network);

/// Lists the names of publishers: "a", "a and b", "a, b, c and 5 more".
[[nodiscard]] std::string names_of(const Members& members,
                                   const std::vector<std::size_t>& publishers);

/// States where a row applies: a hop's name, "end to end", "publisher NAME for NAME", "capacity of
/// NAME", "listeners on NAME", "response times on NAME" or "time left on NAME".
[[nodiscard]] std::string where(const System& system, const Members& members,
                                const Verdict& verdict, const Row& row);

/// Explains a failed row of kind Against::schedule: whose frames would be late or lost, and by how
/// much.
[[nodiscard]] std::string schedule_text(const System& system, const Members& members,
                                        const Row& row);

/// Formats the worst-case reaction time to a missing heart-beat with its terms: "174 ms = (Omission
/// 2 + 1) x Period 50 ms + Latency 12 ms + Jitter 12 ms". Returns an empty text if a term is
/// unknown.
[[nodiscard]] std::string reaction(const Verdict& verdict);

/// States the reason of a verdict in one line without a full stop. Of a refusal it names the
/// attribute, the hop and the amount; of a grant the tightest margin. `problem`: details of an
/// Obstacle::unavailable or ::contradicted.
[[nodiscard]] std::string reason(const System& system, const Members& members,
                                 const Verdict& verdict, const std::string& problem = {});

}  // namespace mlcca::core
