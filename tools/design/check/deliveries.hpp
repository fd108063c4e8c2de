// SPDX-License-Identifier: BSD-2-Clause
// The deliveries of a system in words for the page: verdict, route, margin and reaction time.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/design/bus_messages.hpp"
#include "core/design/inspect.hpp"
#include "core/model/members.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::tools::design {

/// A delivery from a publisher to a place with subscribers.
struct ReportedDelivery {
  std::size_t channel = 0;
  std::size_t publisher_number = 0;
  std::string publisher;
  std::string subscribers;  ///< names, such as "a, b, c and 5 more"
  Outcome outcome = Outcome::fit;
  std::size_t set = 0;
  core::Place from;
  core::Place to;
  core::Route route;                        ///< if refused, the route that was tried; may be empty
  std::optional<core::Place> refused_at{};  ///< the first place of the route that does not fit
  std::string margin;    ///< the smallest margin and the attribute that it belongs to; or why there
                         ///< is none
  Value share = 0;       ///< the margin as a share, see core::slack(); 0: there is none
  std::string reaction;  ///< the worst case, such as "174 ms"; empty: not known
  std::string reaction_terms;  ///< the sum that it results from: "(Omission 2 + 1) x Period 50 ms +
                               ///< …"
};

/// Describes the delivery of a verdict; its margin does not consider analysed buses, see
/// consider().
ReportedDelivery in_words(const core::System& system, const core::Members& members,
                          const core::Verdict& verdict);

/// Lowers the margin of a grant to that on a bus of its route, if that is smaller. The margins on
/// buses are known only when all buses are analysed, including refused messages that are sent.
void consider(const core::System& system, std::span<const core::SentMessage* const> messages,
              ReportedDelivery& delivery);

}  // namespace mlcca::tools::design
