// SPDX-License-Identifier: BSD-2-Clause
// What a check of a description can find: stable numbers, severities, titles.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Printed as MLCCA and three digits. A number is never used again for something else.
enum class FindingId : std::uint8_t {
  // The description cannot be used.
  unreadable = 1,
  not_xml = 2,
  not_in_schema = 3,
  // Names and rules.
  rule = 4,
  unknown_name = 5,
  name_twice = 6,
  wrong_place = 7,
  too_many = 8,
  subject_twice = 9,
  // Completeness.
  no_publisher = 10,
  unused_publisher = 11,
  unused_channel = 12,
  no_route = 13,
  unreachable_network = 14,
  identifier_clash = 15,
  interface_twice = 16,
  unbound = 17,
  sender_twice = 18,
  unplaced = 19,
  // Correctness.
  traffic_mismatch = 20,
  hop_unfit = 21,
  route_unfit = 22,
  overhearing_unfit = 23,
  capacity = 24,
  too_long = 25,
  no_node = 26,
  no_traffic = 27,
  run_time = 28,
  lower_set = 29,
  unsafe_drop = 30,
  deadline_missed = 31,
  medium_time = 32,
  shared_limit = 33,
  not_decided = 34,
  no_data_rate = 35,
  queue_too_short = 36,
  relay_gated = 37,
  // Allowed, and hardly meant.
  no_omission = 38,
  long_period = 39,
  managed_in_vain = 40,
  unstarted_sender = 41,
};

/// A note is information: it does not make a description unfit.
enum class Severity : std::uint8_t { error, warning, note };

struct FindingInfo {
  FindingId id;
  Severity severity;
  const char* name;   ///< short and stable, for tools: "no-publisher"
  const char* title;  ///< one sentence for people, without a full stop
};

/// All of them, by number.
[[nodiscard]] std::span<const FindingInfo> finding_table();
[[nodiscard]] const FindingInfo& info(FindingId id);

/// "MLCCA012"
[[nodiscard]] std::string code_of(FindingId id);

inline constexpr std::uint32_t kNone = 0xffffffff;

/// One thing that is wrong, or worth knowing. Numbers are indices into the System, kNone where they
/// do not apply.
struct Finding {
  FindingId id = FindingId::rule;
  Origin origin;
  std::string text;  ///< what is wrong, with the numbers
  std::string hint;  ///< what would be right
  std::uint32_t channel = kNone;
  std::uint32_t publisher = kNone;
  std::uint32_t subscriber = kNone;
  Place place;  ///< hop, network or gateway; meaningful with has_place
  bool has_place = false;
  std::string attribute;  ///< name of the attribute that failed, or empty
  std::string required;   ///< value with unit, or empty
  std::string provided;   ///< value with unit, "not provided", or empty
};

}  // namespace mlcca::core
