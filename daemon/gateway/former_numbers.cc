// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/former_numbers.hpp"

#include "daemon/cluster/record_codec.hpp"

namespace mlcca {
namespace {

constexpr core::AdmissionId kMostNumber = std::uint64_t{1} << 53U;  // no gateway makes as many

}  // namespace

void FormerNumbers::find(const core::cluster::Member& member, Recorder& recorder) {
  numbers_.clear();
  const auto& recorded = recorder.contents().admissions;
  const auto& asked = member.view().records().asked;
  for (auto it = asked.lower_bound({member.self(), 0});
       it != asked.end() && it->first.first == member.self(); ++it) {
    const auto former = cluster::asked_in(it->second.asked.admission);
    if (!former) continue;
    bool is_given_again = false;
    for (const auto* all : {&former->requests, &former->also})
      for (const control::Request& request : *all) {
        const control::Request* const now = recorded.find(request.id);
        is_given_again = is_given_again || (now != nullptr && *now != request) ||
                         recorder.is_set_aside(request.id);
        if (request.id <= kMostNumber) recorder.pass_over(request.id);
      }
    if (is_given_again && !former->on_behalf) numbers_.push_back(it->first.second);
  }
}

std::string FormerNumbers::in_the_way(const core::cluster::Member& member) {
  std::erase_if(numbers_, [&member](SharedNetworks::Number number) {
    return !member.view().records().asked.contains({member.self(), number});
  });
  if (numbers_.empty()) return {};
  return "the store still has admissions of this gateway from before its journal was lost, with "
         "the same numbers: ask again in a few seconds";
}

}  // namespace mlcca
