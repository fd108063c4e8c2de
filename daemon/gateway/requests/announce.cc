// SPDX-License-Identifier: BSD-2-Clause
// Announce: a program on this gateway takes up the end of a channel that is meant for it. Decisions
// do not change.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "control/attributes.hpp"
#include "control/local_address.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/endpoints.hpp"
#include "daemon/gateway/local_ends.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/outside/gate_control.hpp"
#include "mlcca/check.hpp"

namespace mlcca::requests {
namespace {

using control::Role;

const char* name_of(Role role) { return role == Role::publisher ? "publisher" : "subscriber"; }

/// Whether a program that states `announced` for an end sends or requires more than was decided. A
/// publisher's MaxPayload and Jitter describe its traffic; a subscriber's MaxPayload is what it
/// accepts. A publisher's Period and Bandwidth are also promised to subscribers, so less is as
/// wrong as more.
bool differs(Role role, Attribute a, Value announced, Value decided) {
  const bool publishes = role == Role::publisher;
  if (publishes && (a == Attribute::period || a == Attribute::bandwidth))
    return announced != decided;
  const bool smaller_is_harder = info(a).better == Better::smaller;
  const bool turned_round = publishes ? a == Attribute::jitter : a == Attribute::max_payload;
  return smaller_is_harder != turned_round ? announced < decided : announced > decided;
}

/// The first announced attribute that conflicts with `decided`, in words; nullopt if none does.
std::optional<std::string> conflict(Role role, const AttributeSet& announced,
                                    const AttributeSet& decided, std::string_view whose) {
  const AttributeSet asked = normalised_requirement(announced);
  const AttributeSet given = normalised_requirement(decided);
  // What the program has announced comes before what that implies.
  std::vector<Attribute> all;
  for (const bool implied : {false, true})
    for (std::size_t i = 0; i < kAttributes; ++i)
      if (const Attribute a = attribute_at(i); asked.has(a) && announced.has(a) != implied)
        all.push_back(a);
  for (const Attribute a : all) {
    const std::string what =
        fmt::format("{} {} is announced{}", info(a).name, core::format_value(a, asked[a]),
                    announced.has(a) ? "" : " (implied by the Period)");
    if (!given.has(a))
      return fmt::format("{}, and nothing is stated {}: state it in the description", what, whose);
    if (differs(role, a, asked[a], given[a]))
      return fmt::format("{}, and {} is stated {}: state what the program needs in the description",
                         what, core::format_value(a, given[a]), whose);
  }
  return std::nullopt;
}

/// The ends of one role that a channel has on this gateway.
class Ends {
 public:
  Ends(const AnnounceParts& parts, std::size_t channel, Role role)
      : state_(*parts.scene.state),
        members_(state_.members()),
        here_{core::Place::Kind::gateway, parts.scene.self},
        channel_(channel),
        role_(role) {
    const auto& all = role == Role::publisher ? members_.publishers_of(channel)
                                              : members_.subscribers_of(channel);
    std::ranges::copy_if(all, std::back_inserter(ends_), [&](std::size_t end) {
      return place_of(end) == here_ && !is_twin(parts, end);
    });
  }

  [[nodiscard]] const std::string& name_of(std::size_t end) const {
    return role_ == Role::publisher ? members_.publisher(end).name : members_.subscriber(end).name;
  }
  /// Why a program that announces this cannot be that end; nullopt if it can. It may match any of
  /// the attribute sets of the end: the set in use can change while programs run, and the answer
  /// says which one it is.
  [[nodiscard]] std::optional<std::string> conflict(std::size_t end,
                                                    const AttributeSet& announced) const {
    auto found = requests::conflict(role_, announced, attributes_of(end, 0), "for this end");
    for (std::size_t set = 1; found && set <= lower_sets(end); ++set)
      if (!requests::conflict(role_, announced, attributes_of(end, set), "")) found.reset();
    return found;
  }
  /// Why the program may not be that end; nullopt if it may. Frames of a publisher pass for one
  /// user only. Frames from a bus can be read by every user, unless the end states who may.
  [[nodiscard]] std::optional<std::string> forbids(std::size_t end, const serve::Peer& peer) const {
    if (role_ == Role::publisher && members_.publisher(end).uid != peer.uid)
      return fmt::format("is for programs of user {}, and this one is of user {}",
                         members_.publisher(end).uid.value_or(0), peer.uid);
    const core::ProgramRule* const rule = rule_of(end);
    if (rule == nullptr) return std::nullopt;
    if (!rule->group.empty() &&
        (!rule->gid || peer.process == nullptr || !peer.process->is_in(*rule->gid)))
      return fmt::format("is for programs in group {}, and this one is not in it", rule->group);
    if (rule->unit.empty()) return std::nullopt;
    if (peer.process == nullptr) return fmt::format("is for programs of unit {}", rule->unit);
    const auto unit = peer.process->unit();
    if (!unit) return fmt::format("is for programs of unit {}: {}", rule->unit, unit.error().text);
    if (*unit == rule->unit) return std::nullopt;
    return fmt::format("is for programs of unit {}, and this one is of {}", rule->unit,
                       unit->empty() ? "none" : *unit);
  }

  /// What the end states about the programs that may take it up; null if it states nothing.
  [[nodiscard]] const core::ProgramRule* rule_of(std::size_t end) const {
    return state_.system().program_rule(role_ == Role::publisher
                                            ? members_.publisher(end).program_rule
                                            : members_.subscriber(end).program_rule);
  }

  /// The end of that name that a program may take up. With an empty name there must be only one.
  [[nodiscard]] Result<std::size_t> find(const std::string& name, const serve::Peer& peer) const {
    std::vector<std::size_t> found;
    std::ranges::copy_if(ends_, std::back_inserter(found),
                         [&](std::size_t end) { return name.empty() || name_of(end) == name; });
    if (found.empty()) return fail(none(name));
    const std::size_t one = found.front();
    const auto why = forbids(one, peer);
    std::erase_if(found, [&](std::size_t end) { return forbids(end, peer).has_value(); });
    if (found.empty()) return fail(fmt::format("{} {}", name_of(one), *why));
    if (found.size() > 1)
      return fail(
          fmt::format("user {} may be {}: say which", peer.uid, fmt::join(names(found), ", ")));
    return found.front();
  }

 private:
  /// Where another gateway has admitted a subscriber for this one, the program takes up the
  /// admission of this gateway.
  [[nodiscard]] bool is_twin(const AnnounceParts& parts, std::size_t end) const {
    return parts.membership != nullptr && role_ == Role::subscriber &&
           parts.membership->is_twin(members_.admission_of_subscriber(end));
  }
  [[nodiscard]] const AttributeSet& attributes_of(std::size_t end, std::size_t set) const {
    return role_ == Role::publisher ? core::attributes_in(members_.publisher(end), set)
                                    : core::attributes_in(members_.subscriber(end), set);
  }
  [[nodiscard]] std::size_t lower_sets(std::size_t end) const {
    return role_ == Role::publisher ? members_.publisher(end).lower.size()
                                    : members_.subscriber(end).lower.size();
  }
  [[nodiscard]] core::Place place_of(std::size_t end) const {
    return role_ == Role::publisher ? members_.publisher(end).place
                                    : members_.subscriber(end).place;
  }
  [[nodiscard]] std::vector<std::string> names(std::span<const std::size_t> ends) const {
    constexpr std::size_t most = 8;
    std::vector<std::string> out;
    for (const std::size_t end : ends.first(std::min(ends.size(), most)))
      out.push_back(name_of(end));
    if (ends.size() > most) out.emplace_back("…");
    return out;
  }
  [[nodiscard]] std::string none(const std::string& name) const {
    const std::string& gateway = core::name_of(state_.system(), here_);
    if (ends_.empty())
      return fmt::format("no {} of this channel is on {}: describe one there, or admit one",
                         requests::name_of(role_), gateway);
    return fmt::format("no {} '{}' of this channel is on {} (there are: {})",
                       requests::name_of(role_), echoed(name), gateway,
                       fmt::join(names(ends_), ", "));
  }

  const core::State& state_;
  const core::Members& members_;
  core::Place here_;
  std::size_t channel_;
  Role role_;
  std::vector<std::size_t> ends_;
};

/// Adds the address of a subscriber. Returns why that is not possible now; empty: it is added.
std::string add_address(LocalEnds& local_ends, const core::EventChannel& channel,
                        const serve::Peer& peer, const std::string& address, bool is_for_some) {
  using enum LocalEnds::Standing;
  const auto of_program = is_for_some ? stated : anyone;
  const auto standing = peer.may_change ? trusted : of_program;
  return local_ends.add(channel, {peer.uid, peer.session, standing}, address).value_or("");
}

/// States that events of programs on the gateway do not arrive, although they may be granted.
void note_no_place(control::Channels& answer, const std::string& why) {
  if (why.empty()) return;
  answer.local_problem = why;
  for (control::Channel& delivery : answer.channels)
    if (delivery.from == delivery.to)
      delivery.problems.insert(delivery.problems.begin(), "its events do not arrive: " + why);
}

}  // namespace

Response announce(const AnnounceParts& parts, const Asker& asker,
                  const control::AnnounceRequest& request) {
  if (asker.peer.is_in_other_network)
    return error_of(
        control::ErrorKind::forbidden,
        "this program is in another network namespace than mlccad, so its events do not "
        "pass the gates of this gateway: run it in that of mlccad");
  const core::State& state = *parts.scene.state;
  if (request.role != Role::publisher && request.role != Role::subscriber)
    return invalid("say the role: publisher or subscriber");
  const auto channel = channel_named(state, request.channel);
  if (!channel) return invalid(channel.error().text);
  const Ends ends(parts, *channel, request.role);
  const auto end = ends.find(request.name, asker.peer);
  if (!end) return error_of(control::ErrorKind::forbidden, end.error().text);
  const auto announced = control::set_of(request.attributes);
  if (!announced) return invalid(announced.error().text);
  if (const auto why = ends.conflict(*end, *announced)) return invalid(*why);
  std::string no_place;
  if (!request.local.empty()) {
    if (request.role != Role::subscriber)
      return invalid("local is for subscribers: a publisher sends, and receives nothing");
    // The address is not repeated in the error: it may be almost a key.
    if (!control::local_address_in(request.local))
      return invalid(
          "local is the name of a socket that was bound without one (unix(7)) and its key: 5 and "
          "16 hexadecimal digits in lower case");
    no_place = add_address(parts.local_ends, state.system().channels[*channel], asker.peer,
                           request.local, ends.rule_of(*end) != nullptr);
  }
  const auto report = [parts, channel = *channel, role = request.role, end = *end,
                       no_place = std::move(no_place)] {
    const bool publishes = role == Role::publisher;
    control::Channels out = publishes ? parts.channels.of_publisher(channel, end)
                                      : parts.channels.of_subscriber(channel, end);
    out.endpoints = publishes ? parts.endpoints.of_publisher(channel, end)
                              : parts.endpoints.of_subscriber(channel, end);
    out.grace_ns = parts.control.grace();
    note_no_place(out, no_place);
    return out;
  };
  Response response = parts.replies.made(asker, parts.estimates.has_many_lines(*channel), report);
  response.follows = state.system().channels[*channel].subject;
  return response;
}

}  // namespace mlcca::requests
