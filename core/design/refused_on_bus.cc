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

/// Describes the harm to a message: " could take 810 us of the 600 us".
std::string harm_to(const can::Message& message, const can::Response& response) {
  if (!response.bounded) return " could wait without a bound";
  if (response.meets(message.deadline)) return " could lose frames in its queue";
  const BoundWords words = format_bound(Attribute::latency, response.response, message.deadline);
  return " could take " + words.bound + " of the " + words.limit;
}

/// The most messages that may or may not be on the bus and for which all combinations are tried.
constexpr std::size_t kMostCombined = 6;

struct Late {
  can::Message message;
  can::Response response;

  [[nodiscard]] std::size_t publisher() const { return Ledger::publisher_of(message.key); }
};

/// Everything that can be on a bus.
class Traffic {
 public:
  explicit Traffic(const can::Assumptions& assumptions) : assumptions_(assumptions) {}

  /// Adds a granted message; call it before the others. `surely`: granted in all cases. `here`:
  /// sent by a node of the bus, granted or not.
  void add_granted(const can::Message& message, bool surely, bool here) {
    parts_.push_back({message, surely, surely || here});
    ++held_;
  }
  /// Adds a message that may be granted in the place of others.
  void add_contested(const can::Message& message, bool here) {
    contested_.emplace_back(place_of(message, here), message);
  }
  void add_refused(can::Message message) {
    message.deadline = can::kNever;
    static_cast<void>(place_of(message, true));
  }

  /// Whether nothing can be granted.
  [[nodiscard]] bool empty() const { return held_ == 0 && contested_.empty(); }

  /// The granted messages that would be late if nodes of the bus send what is refused.
  [[nodiscard]] std::vector<Late> late() const {
    std::vector<can::Message> all;
    all.reserve(parts_.size());
    for (const Part& part : parts_) all.push_back(part.message);
    const auto together = can::analyse(assumptions_, all);
    std::vector<Late> out;
    for (std::size_t i = 0; i < held_; ++i)
      if (!can::fits(assumptions_, all[i], together[i])) out.push_back({all[i], together[i]});
    for (const auto& [place, message] : contested_) {
      if (can::fits(assumptions_, message, together[place])) continue;
      const auto open = open_beside(place);
      const auto response =
          open.size() > kMostCombined ? together[place] : longest_of(place, message, open);
      if (!can::fits(assumptions_, message, response)) out.push_back({message, response});
    }
    return out;
  }

 private:
  struct Part {
    can::Message message;
    bool surely = false;  ///< granted in all cases
    bool always = false;  ///< sent in all cases
  };

  /// Adds the message unless it is there already, for another place behind the bus; returns its
  /// index.
  std::size_t place_of(const can::Message& message, bool here) {
    const auto found =
        std::ranges::find(parts_, message.key, [](const Part& part) { return part.message.key; });
    if (found != parts_.end()) return static_cast<std::size_t>(found - parts_.begin());
    parts_.push_back({message, false, here});
    return parts_.size() - 1;
  }

  [[nodiscard]] std::vector<std::size_t> open_beside(std::size_t place) const {
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (i != place && !parts_[i].always) open.push_back(i);
    return open;
  }

  /// The longest response of a message together with everything that is sent in any case, over all
  /// combinations of the `open` ones that can be granted with it.
  [[nodiscard]] can::Response longest_of(std::size_t place, const can::Message& message,
                                         const std::vector<std::size_t>& open) const {
    can::Response longest{.response = 0, .bounded = true, .queued_frames = 0};
    for (unsigned which = 0; which < 1U << open.size(); ++which) {
      std::vector<can::Message> granted{message};
      std::vector<can::Message> sent{message};
      const auto is_chosen = [&](std::size_t i) {
        const auto found = std::ranges::find(open, i);
        return found != open.end() && (which >> (found - open.begin()) & 1U) != 0;
      };
      for (std::size_t i = 0; i < parts_.size(); ++i) {
        if (i == place) continue;
        const bool chosen = is_chosen(i);
        if (parts_[i].surely || chosen) granted.push_back(parts_[i].message);
        if (parts_[i].always || chosen) sent.push_back(parts_[i].message);
      }
      if (!are_in_time(granted)) continue;
      const can::Response response = can::analyse(assumptions_, sent).front();
      longest.bounded = longest.bounded && response.bounded;
      longest.response = std::max(longest.response, response.response);
      longest.queued_frames = std::max(longest.queued_frames, response.queued_frames);
    }
    return longest;
  }

  [[nodiscard]] bool are_in_time(const std::vector<can::Message>& messages) const {
    const auto responses = can::analyse(assumptions_, messages);
    for (std::size_t i = 0; i < messages.size(); ++i)
      if (!can::fits(assumptions_, messages[i], responses[i])) return false;
    return true;
  }

  const can::Assumptions& assumptions_;
  std::vector<Part> parts_;
  std::size_t held_ = 0;  ///< number of granted messages, which come first
  std::vector<std::pair<std::size_t, can::Message>> contested_{};  ///< with their indices in parts_
};

/// Describes the harm to several messages: "v could take 810 us of the 600 us, and one message more
/// may fail so".
std::string harm_words(const Members& members, const std::vector<Late>& late) {
  const Late& first = late.front();
  std::string harm =
      members.publisher(first.publisher()).name + harm_to(first.message, first.response);
  const std::size_t others = late.size() - 1;
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
    for (const BusMessage& m : contested) {
      if (m.network != n || !m.message) continue;
      here.push_back(*m.message);
      here.back().key = Ledger::key_of({m.publisher, n, m.from});
    }
    report(system, members, *bus, n, here, to);
  }
}

void RefusedOnBus::report(const System& system, const Members& members, const can::Schedule& bus,
                          std::size_t network, std::span<const can::Message> contested,
                          std::vector<Finding>& to) const {
  const auto is_here = [&](std::size_t number) {
    return members.publisher(number).place == Place{Place::Kind::network, network};
  };
  Traffic traffic(bus.assumptions());
  for (const can::Message& message : bus.messages()) {
    const std::size_t number = Ledger::publisher_of(message.key);
    traffic.add_granted(message, !perhaps_.contains(number), is_here(number));
  }
  for (const can::Message& message : contested)
    traffic.add_contested(message, is_here(Ledger::publisher_of(message.key)));
  if (traffic.empty()) return;
  std::vector<std::size_t> senders;
  // If these are refused at run time they are sent all the same, while others may be granted in
  // their place.
  for (const std::size_t number : perhaps_)
    if (!contested.empty() && granted_.contains(number) && is_here(number))
      senders.push_back(number);
  std::vector<std::size_t> unknown;
  for (const auto& [number, set] : refused_) {
    if (!is_here(number) || granted_.contains(number)) continue;
    auto message =
        can::message_of(system, members.publisher(number), set, network, bus.assumptions().timing);
    (message ? senders : unknown).push_back(number);
    if (!message) continue;
    message->key = Ledger::key_of({number, network, Flow::kOwn});
    traffic.add_refused(*message);
  }
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
  std::vector<Late> late = traffic.late();
  // A message is not granted and refused at the same time.
  std::erase_if(late, [&senders](const Late& one) {
    return senders == std::vector<std::size_t>{one.publisher()};
  });
  if (late.empty()) return;
  std::erase(senders, late.front().publisher());
  add(members, senders, network, name + ": while they are sent, " + harm_words(members, late), to);
}

/// Adds the finding. `harm`: what the frames of the senders do, beginning with the name of the bus.
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
