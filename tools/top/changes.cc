// SPDX-License-Identifier: BSD-2-Clause
#include "tools/top/changes.hpp"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "core/model/text.hpp"

namespace mlcca::tools::top {
namespace {

using Json = nlohmann::ordered_json;

auto naming(const control::Channel& c) {
  return std::tie(c.subject, c.publisher, c.admission, c.from, c.to);
}

Json named(const control::Channel& c) {
  return {{"subject", core::format_subject(c.subject)},
          {"publisher", c.publisher},
          {"admission", c.admission},
          {"from", c.from},
          {"to", c.to}};
}

auto frames_of(const control::Channel& c) {
  return std::tie(c.passed, c.dropped, c.excess, c.would_drop);
}

/// Whether two reports of a supervision are the same. Ages change all the time, so they are
/// ignored.
bool is_same(const control::Watch& a, const control::Watch& b) {
  return std::tie(a.events, a.missing, a.missing_now, a.jitter_ns) ==
             std::tie(b.events, b.missing, b.missing_now, b.jitter_ns) &&
         (a.silent_ns == 0) == (b.silent_ns == 0);
}

bool is_same(const control::Channel& a, const control::Channel& b) {
  return frames_of(a) == frames_of(b) && a.watch.has_value() == b.watch.has_value() &&
         (!a.watch || is_same(*a.watch, *b.watch));
}

Json or_null(std::uint64_t value) { return value == 0 ? Json() : Json(value); }

Json counted(const control::Channel& c, std::size_t place) {
  Json out = {{"delivery", place},
              {"passed", c.crosses_no_gate ? Json() : Json(c.passed)},
              {"dropped", c.dropped},
              {"excess", c.excess},
              {"would_drop", c.would_drop}};
  if (const auto& w = c.watch)
    out["watch"] = {{"missing_now", w->missing_now},
                    {"events", w->events},
                    {"missing", w->missing},
                    {"since_last_ns", w->since_last_ns},
                    {"silent_ns", or_null(w->silent_ns)},
                    {"last_gap_ns", or_null(w->last_gap_ns)},
                    {"jitter_ns", w->jitter_ns},
                    {"rate_millihertz", or_null(w->rate_millihertz)}};
  return out;
}

/// The part of a channel with which the next line is compared.
control::Channel kept(const control::Channel& c) {
  control::Channel out;
  std::tie(out.subject, out.publisher, out.admission, out.from, out.to) = naming(c);
  std::tie(out.passed, out.dropped, out.excess, out.would_drop) = frames_of(c);
  out.watch = c.watch;
  return out;
}

Json traffic(const control::Traffic& t) {
  auto reasons = Json::object();
  for (const auto& one : t.reasons) reasons[one.reason] = one.frames;
  return {{"passed", t.passed},
          {"dropped", t.dropped},
          {"would_drop", t.would_drop},
          {"reasons", std::move(reasons)}};
}

bool is_same(const control::Interface& a, const control::Interface& b) {
  return std::tie(a.ingress, a.egress) == std::tie(b.ingress, b.egress);
}

}  // namespace

std::string Changes::line(const Sample& now, std::uint64_t unix_ns) {
  const auto& all = now.channels.channels;
  Json out = {{"taken_unix_ns", unix_ns}};
  const bool others = is_first_ || !std::ranges::equal(all, before_, {}, naming, naming);
  if (others) {
    auto& deliveries = out["deliveries"] = Json::array();
    for (const auto& c : all) deliveries.push_back(named(c));
  }
  auto& counters = out["counters"] = Json::array();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (others || !is_same(all[i], before_[i])) counters.push_back(counted(all[i], i));
  auto& interfaces = out["interfaces"] = Json::array();
  for (const auto& i : now.status.interfaces) {
    const auto before = interfaces_.find(i.name);
    if (before != interfaces_.end() && is_same(before->second, i)) continue;
    interfaces.push_back(
        {{"name", i.name}, {"ingress", traffic(i.ingress)}, {"egress", traffic(i.egress)}});
  }
  is_first_ = false;
  before_.clear();
  std::ranges::transform(all, std::back_inserter(before_), kept);
  interfaces_.clear();
  for (const auto& i : now.status.interfaces) interfaces_[i.name] = i;
  return out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mlcca::tools::top
