// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/refused_on_bus.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/many.hpp"
#include "core/can/analysis.hpp"
#include "core/can/of_system.hpp"
#include "core/model/text.hpp"

namespace mlcca::core {
namespace {

/// " could take 810 us of the 600 us"
std::string harm_to(const can::Message& message, const can::Response& response) {
  if (!response.bounded) return " could wait without a bound";
  if (response.meets(message.deadline)) return " could lose frames in its queue";
  const BoundWords words = format_bound(Attribute::latency, response.response, message.deadline);
  return " could take " + words.bound + " of the " + words.limit;
}

/// What becomes of the first `held` messages, which are granted, when all are sent; empty: all are
/// in time.
std::string harm_of(const Members& members, const can::Schedule& bus,
                    const std::vector<can::Message>& messages, std::size_t held) {
  const auto responses = can::analyse(bus.assumptions(), messages);
  std::size_t late = held;
  std::size_t others = 0;
  for (std::size_t i = 0; i < held; ++i) {
    if (can::fits(bus.assumptions(), messages[i], responses[i])) continue;
    if (late == held)
      late = i;
    else
      ++others;
  }
  if (late == held) return {};
  std::string harm = members.publisher(Ledger::publisher_of(messages[late].key)).name +
                     harm_to(messages[late], responses[late]);
  if (others != 0)
    harm += ", and " + many(others, "message more may fail so", "messages more may fail so");
  return harm;
}

}  // namespace

void RefusedOnBus::add(const Verdict& verdict) {
  if (verdict.granted)
    granted_.insert(verdict.publisher);
  else
    refused_.try_emplace(verdict.publisher, verdict.set);
  if (verdict.outcome == Outcome::run_time) perhaps_.insert(verdict.publisher);
}

void RefusedOnBus::report(const System& system, const Members& members, const Ledger& ledger,
                          std::span<const BusMessage> contested, std::vector<Finding>& to) const {
  if (refused_.empty() && contested.empty()) return;
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    const can::Schedule* const bus = ledger.schedule(n);
    if (bus == nullptr) continue;
    std::vector<can::Message> here;
    for (const BusMessage& m : contested)
      if (m.network == n && m.message && !m.present) here.push_back(*m.message);
    report(system, members, *bus, n, here, to);
  }
}

void RefusedOnBus::report(const System& system, const Members& members, const can::Schedule& bus,
                          std::size_t network, std::span<const can::Message> contested,
                          std::vector<Finding>& to) const {
  std::vector<can::Message> messages(bus.messages().begin(), bus.messages().end());
  const std::size_t held = messages.size();
  messages.insert(messages.end(), contested.begin(), contested.end());
  std::vector<std::size_t> senders;
  // Refused at run time they are sent all the same, and others may be granted in their place.
  for (const std::size_t number : perhaps_)
    if (!contested.empty() && granted_.contains(number) &&
        members.publisher(number).place == Place{Place::Kind::network, network})
      senders.push_back(number);
  std::vector<std::size_t> unknown;
  for (const auto& [number, set] : refused_) {
    const Publisher& p = members.publisher(number);
    if (p.place != Place{Place::Kind::network, network} || granted_.contains(number)) continue;
    auto message = can::message_of(system, p, set, network, bus.assumptions().timing);
    if (!message) {
      unknown.push_back(number);
      continue;
    }
    message->deadline = can::kNever;
    messages.push_back(*message);
    senders.push_back(number);
  }
  if (held == 0) return;
  const std::string& name = system.networks[network].name;
  if (!unknown.empty())
    add(members, unknown, network,
        name + (unknown.size() == 1
                    ? ": how much it sends is not known, so whether what is granted there is in "
                      "time is known only while it is silent"
                    : ": how much they send is not known, so whether what is granted there is in "
                      "time is known only while they are silent"),
        to);
  if (senders.empty()) return;
  const std::string harm = harm_of(members, bus, messages, held);
  if (!harm.empty()) add(members, senders, network, name + ": while they are sent, " + harm, to);
}

/// `harm`: what the frames of the publishers do, from the name of the bus on.
void RefusedOnBus::add(const Members& members, const std::vector<std::size_t>& senders,
                       std::size_t network, const std::string& harm,
                       std::vector<Finding>& to) const {
  const Publisher& sender = members.publisher(senders.front());
  std::string text = sender.name;
  if (senders.size() > 1) text += " and " + std::to_string(senders.size() - 1) + " more";
  const bool one = senders.size() == 1;
  if (std::ranges::all_of(senders, [&](std::size_t number) { return perhaps_.contains(number); }))
    text += " may be refused";
  else
    text += one ? " is refused" : " are refused";
  text += one ? ", and no gate keeps its frames off " : ", and no gate keeps their frames off ";
  Finding& f = to.emplace_back();
  f.id = FindingId::refused_on_bus;
  f.origin = sender.origin;
  f.text = text + harm;
  f.hint =
      "change what " + sender.name +
      " is refused for, or take it off the bus: what is granted there is in time for sure only "
      "while it is silent";
  f.channel = static_cast<std::uint32_t>(sender.channel);
  f.publisher = static_cast<std::uint32_t>(senders.front());
  f.place = {Place::Kind::network, network};
  f.has_place = true;
}

}  // namespace mlcca::core
