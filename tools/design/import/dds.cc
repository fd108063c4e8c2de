// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/dds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "base/text.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::size_t kMostText = 500;  // bytes of a name or type
constexpr std::string_view kNotGated =
    "Gates on Ethernet go by the subjects of FAMOUSO: DDS itself is not gated. This network is for "
    "check.";

/// Policies with a text of their own in the lacks, by the beginning of their names in lower case.
constexpr auto kPolicies = std::to_array<std::pair<std::string_view, std::string_view>>({
    {"reliability", "has no counterpart: state PacketLoss or Omission of the network"},
    {"history", "has no counterpart: a channel has no store"},
    {"depth", "has no counterpart: a channel has no store"},
    {"durability", "has no counterpart: a channel has no store"},
    {"liveliness", "who asserts it has no counterpart: a channel is alive by its events"},
});

class DdsMeaning {
 public:
  DdsMeaning(const std::string& file, const ImportOptions& options, Lacks lacks)
      : options_(options), joiner_(out_) {
    out_.file = file;
    out_.kind = core::NetworkKind::other;
    out_.remark = kNotGated;
    out_.is_part = true;
    out_.lacks = std::move(lacks);
  }

  ImportedNetwork take(const std::vector<DdsEnd>& ends) {
    for (const auto& end : ends)
      if (end.writes && end.deadline) {
        auto& period = periods_[end.topic];
        period = std::max(period, *end.deadline);
      }
    for (const auto& end : ends) add(end);
    for (const auto& message : out_.messages)
      lack("no-size", "the size of the type is not stated: add maxPayload", message.line,
           fmt::format("{}: {}", message.topic, message.type.empty() ? "no type" : message.type));
    lack("not-gated", "is no FAMOUSO, by which gates on Ethernet go: the draft is for check", 0,
         "DDS");
    return std::move(out_);
  }

 private:
  void lack(std::string_view kind, std::string_view what, int line, std::string item) {
    out_.lacks.add(kind, what, line, std::move(item));
  }

  std::size_t place_of(const std::string& node) {
    const auto [known, is_new] = places_.emplace(node, out_.nodes.size());
    if (is_new) out_.nodes.push_back({node, "", std::nullopt});
    return known->second;
  }

  void add(const DdsEnd& end) {
    ImportedMessage next;
    next.topic = end.topic;
    next.name = std::string_view(end.topic).substr(end.topic.starts_with('/') ? 1 : 0);
    next.type = end.type;
    next.line = end.line;
    const auto called =
        fmt::format("{} {} {}", end.node, end.writes ? "writes" : "reads", end.topic);
    ImportedEnd as{.node = place_of(end.node), .number = {}, .attributes = {}};
    next.attributes.set(Attribute::period, end.deadline.value_or(options_.default_period));
    if (end.writes)
      writer(end, called, next, as);
    else
      reader(end, called, as);
    omission(end, called, as);
    for (const auto& policy : end.policies) list(policy, called);
    if (end.topic.find_first_of("*?[") != std::string::npos)
      lack("pattern",
           "stands for topics that are not known here: it became one channel, so describe one for "
           "each topic",
           end.line, called);
    (end.writes ? next.senders : next.receivers).push_back(as);
    joiner_.add(std::move(next), {});
  }

  void writer(const DdsEnd& end, const std::string& called, ImportedMessage& to, ImportedEnd& as) {
    if (end.deadline) {
      lack("deadline",
           "the deadline of a writer is taken as its Period: state a shorter one where samples "
           "come more often",
           end.line, fmt::format("{}: {}", called, print_duration(*end.deadline)));
    } else {
      to.arrival = core::Arrival::sporadic;
      to.remark = "Assumed: no deadline of a writer is stated, which would be its Period.";
      lack("no-deadline",
           fmt::format("no deadline is stated: sporadic, and Period {} is assumed "
                       "(--default-period)",
                       print_duration(options_.default_period)),
           end.line, called);
    }
    if (end.lifespan) as.attributes.set(Attribute::deadline, *end.lifespan);
  }

  void reader(const DdsEnd& end, const std::string& called, ImportedEnd& as) {
    if (end.deadline) as.attributes.set(Attribute::period, *end.deadline);
    if (end.lifespan)
      lack("lifespan", "is a policy of writers", end.line,
           fmt::format("{}: {}", called, print_duration(*end.lifespan)));
  }

  /// Sets Omission: the number of consecutive events that may be lost so that the next one still
  /// arrives within the lease.
  void omission(const DdsEnd& end, const std::string& called, ImportedEnd& as) {
    if (!end.lease) return;
    const auto known = periods_.find(end.topic);
    const auto period = end.deadline.value_or(known == periods_.end() ? 0 : known->second);
    if (period == 0)
      return lack("lease", "no Omission follows from a lease without a deadline", end.line,
                  fmt::format("{}: {}", called, print_duration(*end.lease)));
    const auto events = *end.lease / period;
    if (events == 0)
      lack("short-lease", "the lease is shorter than the deadline: Omission is 0", end.line,
           fmt::format("{}: {}", called, print_duration(*end.lease)));
    as.attributes.set(Attribute::omission, events == 0 ? 0 : events - 1);
  }

  void list(const DdsPolicy& policy, const std::string& called) {
    std::string name = policy.name.substr(0, kMostText);
    for (char& c : name)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const auto* const known = std::ranges::find_if(
        kPolicies, [&](const auto& row) { return std::string_view(name).starts_with(row.first); });
    const bool is_known = known != kPolicies.end();
    lack(is_known ? known->first : "policies", is_known ? known->second : "have no counterpart",
         policy.line, fmt::format("{}: {} {}", called, name, policy.value.substr(0, kMostText)));
  }

  const ImportOptions& options_;
  ImportedNetwork out_;
  Joiner joiner_;
  std::map<std::string, std::size_t> places_;
  std::map<std::string, Value> periods_;  ///< by topic, the longest that a writer states
};

}  // namespace

DdsDuration take_duration(std::optional<std::uint64_t> ns, std::optional<Value>& to) {
  // DURATION_INFINITE_SEC of DDS; ROS 2 uses the largest int64_t, which exceeds it.
  constexpr std::uint64_t infinite = 2'147'483'647'000'000'000;
  to.reset();
  if (!ns) return DdsDuration::no_number;
  if (*ns == 0 || *ns >= infinite) return DdsDuration::infinite;
  to = ns;
  return DdsDuration::finite;
}

std::string DdsEnds::add(DdsEnd end) {
  if (ends_.size() >= kMostMessages)
    return fmt::format("there are more than {} writers and readers", kMostMessages);
  for (auto* const text : {&end.node, &end.topic, &end.type})
    text->resize(cut(*text, kMostText).size());
  nodes_.insert(end.node);
  if (nodes_.size() > kMostNodes) return fmt::format("there are more than {} nodes", kMostNodes);
  ends_.push_back(std::move(end));
  return {};
}

Result<ImportedNetwork> DdsEnds::take(const std::string& file, const ImportOptions& options,
                                      const std::string& error, std::string_view lacking) {
  if (!error.empty()) return fail(error);
  if (ends_.empty()) return fail(fmt::format("{}: {}", file, lacking));
  return DdsMeaning(file, options, std::move(lacks)).take(ends_);
}

}  // namespace mlcca::tools::design
