// SPDX-License-Identifier: BSD-2-Clause
// The deliveries of a system, as the page shows them: verdict, way, margin and reaction in words.
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

/// From a publisher to a place with subscribers.
struct ReportedDelivery {
  std::size_t channel = 0;
  std::size_t publisher_number = 0;
  std::string publisher;
  std::string subscribers;  ///< "a, b, c and 5 more"
  Outcome outcome = Outcome::fit;
  std::size_t set = 0;
  core::Place from;
  core::Place to;
  core::Route route;                        ///< of a refusal the one that was tried; may be empty
  std::optional<core::Place> refused_at{};  ///< the first place of the route that does not fit
  std::string margin;                       ///< the smallest, with what it is of; or why not
  Value share = 0;                          ///< of the margin, as core::slack() has it; 0: why not
  std::string reaction;                     ///< "174 ms", at worst; empty: not known
  std::string reaction_terms;               ///< "(Omission 2 + 1) x Period 50 ms + …"
};

ReportedDelivery in_words(const core::System& system, const core::Members& members,
                          const core::Verdict& verdict);

/// A grant may have a smaller margin on one of the buses of its way: they are known at last, with
/// what is sent there though it is refused.
void consider(const core::System& system, std::span<const core::SentMessage* const> messages,
              ReportedDelivery& delivery);

}  // namespace mlcca::tools::design
