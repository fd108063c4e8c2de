// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/adopting.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "daemon/gateway/requests/asked.hpp"

namespace mlcca {
namespace {

std::vector<core::AdmissionId> ids_in(const std::vector<control::Request>& requests) {
  std::vector<core::AdmissionId> ids;
  ids.reserve(requests.size());
  for (const control::Request& request : requests) ids.push_back(request.id);
  return ids;
}

/// `other` with the publisher of `one`, if it has none itself; nullopt if `one` brings no
/// publisher, or `other` brings its own.
std::optional<control::Request> with_publisher_of(const control::Request& one,
                                                  const control::Request& other) {
  const auto& first = std::get<control::Admit>(one.body);
  control::Request both = other;
  auto& second = std::get<control::Admit>(both.body);
  if (describes_publisher(second) || first.from.empty() ||
      (!second.from.empty() && second.from != first.from))
    return std::nullopt;
  second.from = first.from;
  second.from_node = first.from_node;
  second.publisher = first.publisher;
  second.address = first.address;
  second.node = first.node;
  second.priority = first.priority;
  second.user = first.user;
  second.offered = first.offered;
  return both;
}

core::cluster::Vote refusal(std::string why) {
  return {.ok = false, .hop = {}, .reason = std::move(why)};
}

}  // namespace

void Adopting::on(const core::cluster::Adopt& event) {
  Adopted& adopted = adopted_[{event.origin.gateway, event.origin.id}];
  adopted = {.origin = event.origin,
             .footprint = event.footprint,
             .asked = cluster::asked_in(event.admission),
             .number = hands_.new_number(),
             .ours = {},
             .theirs = {}};
  networks_.count(adopted.number, adopted.footprint, event.origin.gateway);
  if (adopted.is_on_behalf()) resume(adopted);
}

void Adopting::on(const core::cluster::Opened& event) {
  const auto it = adopted_.find({event.origin.gateway, event.origin.id});
  // What this gateway has to answer of one on behalf is not replaced: there is nothing to open.
  if (it != adopted_.end() && !it->second.is_on_behalf()) it->second.due = Due::open;
}

void Adopting::on(const core::cluster::Ended& event) {
  const auto it = adopted_.find({event.origin.gateway, event.origin.id});
  if (it == adopted_.end()) return;
  close(it->second);
  if (it->second.is_on_behalf()) hands_.give_back(ids_in(it->second.ours));
  networks_.drop(it->second.number);
  adopted_.erase(it);
}

void Adopting::lost() {
  found_.clear();
  for (auto& [key, adopted] : adopted_) {
    close(adopted);
    networks_.drop(adopted.number);
  }
  adopted_.clear();
}

void Adopting::close(Adopted& adopted) const {
  if (!adopted.open) return;
  adopted.open = false;
  hands_.remove(ids_in(adopted.ours));
}

std::optional<core::AdmissionId> Adopting::ours_of(std::size_t gateway,
                                                   core::AdmissionId theirs) const {
  for (const auto& [key, adopted] : adopted_)
    for (std::size_t i = 0; key.first == gateway && i < adopted.theirs.size(); ++i)
      if (adopted.theirs[i] == theirs) return adopted.ours[i].id;
  return std::nullopt;
}

/// Gives numbers of this gateway to those requests that no other adopted admission has brought yet.
void Adopting::name_requests(Adopted& adopted,
                             const std::vector<control::Request>& requests) const {
  for (const control::Request& request : requests) {
    if (ours_of(adopted.origin.gateway, request.id)) continue;
    adopted.theirs.push_back(request.id);
    adopted.ours.push_back(request);
    adopted.ours.back().id = hands_.new_id();
  }
}

/// The footprint with admission numbers of this gateway; nullopt if it refers to an unknown
/// admission.
std::optional<core::cluster::Footprint> Adopting::mapped(const Adopted& adopted) const {
  core::cluster::Footprint out = adopted.footprint;
  bool all = true;
  const auto map = [&](core::cluster::Source& source) {
    if (source.admission == 0) return;
    const auto ours = ours_of(adopted.origin.gateway, source.admission);
    all = all && ours;
    source.admission = ours.value_or(source.admission);
  };
  for (core::cluster::Part& part : out.parts) {
    for (auto& rate : part.rates) map(rate.source);
    for (auto& bus : part.bus) map(bus.source);
    for (auto& path : part.paths) map(path.source);
  }
  return all ? std::optional(std::move(out)) : std::nullopt;
}

std::string Adopting::misfit(const Adopted& adopted) const {
  if (!mapped(adopted)) return "it takes traffic of an admission that is not known here";
  for (std::size_t i = 0; i < adopted.ours.size(); ++i)
    if (std::string why = misfit(adopted, i); !why.empty()) return why;
  return {};
}

/// Why a request does not fit. Each request is tried alone; one that only adds a subscriber is also
/// tried with a publisher that comes with it.
std::string Adopting::misfit(const Adopted& adopted, std::size_t request) const {
  const control::Request& asked = adopted.ours[request];
  std::string why = hands_.misfit(asked);
  for (std::size_t i = 0; i < request && !why.empty(); ++i)
    if (const auto both = with_publisher_of(adopted.ours[i], asked)) why = hands_.misfit(*both);
  return why;
}

void Adopting::vote(Adopted& adopted, core::cluster::Member& member, Value now) {
  if (adopted.is_on_behalf()) {
    begin_on_behalf(adopted);
    return;
  }
  std::string why = "what is asked for is not understood here";
  if (adopted.asked) {
    if (adopted.theirs.empty()) {
      name_requests(adopted, adopted.asked->also);
      name_requests(adopted, adopted.asked->requests);
    }
    networks_.leave_out(adopted.number);
    hands_.bring_in_line();
    why = misfit(adopted);
    networks_.leave_out(std::nullopt);
  }
  const core::cluster::Origin origin = adopted.origin;
  member.vote(origin,
              why.empty() ? core::cluster::Vote{.ok = true, .hop = {}, .reason = {}} : refusal(why),
              now);
}

/// Starts to carry an adopted admission. The result is why it cannot be carried, or empty.
std::string Adopting::open(Adopted& adopted) {
  const auto footprint = mapped(adopted);
  if (!footprint) return "it takes traffic of an admission that is not known here";
  networks_.carry(adopted.number, *footprint, adopted.origin.gateway, adopted.footprint);
  networks_.leave_out(adopted.number);
  hands_.bring_in_line();
  adopted.open = true;
  std::string why;
  for (auto it = adopted.ours.begin(); it != adopted.ours.end() && why.empty(); ++it)
    if (const auto done = hands_.admit(*it); !done) why = done.error().text;
  networks_.leave_out(std::nullopt);
  if (why.empty()) return why;
  close(adopted);
  networks_.count(adopted.number, adopted.footprint, adopted.origin.gateway);
  hands_.bring_in_line();
  return why;
}

bool Adopting::step(core::cluster::Member& member, Value now) {
  bool any = false;
  for (auto& [key, adopted] : adopted_) {
    const Due due = std::exchange(adopted.due, Due::nothing);
    any = any || due != Due::nothing;
    act_on(adopted, due, member, now);
    any = (std::exchange(adopted.check, false) && ends_with_publisher(adopted)) || any;
  }
  for (const auto& [of, request] : std::exchange(found_, {})) hands_.give_back({request.id});
  return any;
}

void Adopting::act_on(Adopted& adopted, Due due, core::cluster::Member& member, Value now) {
  const core::cluster::Origin origin = adopted.origin;
  if (due == Due::vote) {
    vote(adopted, member, now);
  } else if (due == Due::open && !adopted.is_on_behalf()) {
    if (std::string why = open(adopted); !why.empty())
      member.vote(origin, refusal(std::move(why)), now);
  } else if (due == Due::resume) {
    const auto done = hands_.admit(adopted.ours.front());
    if (!done) close(adopted);
    answer(adopted, done ? std::string() : done.error().text);
  } else if (due == Due::answer) {
    const std::string& why = adopted.answer;
    member.vote(
        origin,
        why.empty() ? core::cluster::Vote{.ok = true, .hop = {}, .reason = {}} : refusal(why), now);
  }
}

// --- admissions that this gateway makes for another one ------------------------------------------

Adopting::Adopted* Adopting::find(const core::cluster::Origin& origin) {
  const auto it = adopted_.find({origin.gateway, origin.id});
  return it == adopted_.end() || it->second.origin != origin ? nullptr : &it->second;
}

void Adopting::answer(Adopted& adopted, const std::string& why) {
  adopted.answer = why;
  adopted.due = Due::answer;
}

/// Asks the store for what the subscriber of another gateway needs. The vote is the result.
void Adopting::begin_on_behalf(Adopted& adopted) {
  const auto& requests = adopted.asked->requests;
  if (requests.size() != 1 || describes_publisher(std::get<control::Admit>(requests.front().body)))
    return answer(adopted, "what is asked for is not understood here");
  name_requests(adopted, requests);
  if (adopted.ours.empty()) return answer(adopted, "it was asked for before");
  const core::cluster::Origin origin = adopted.origin;
  const auto asked = hands_.ask({.decide = [this, origin] { return wish_on_behalf(origin); },
                                 .granted = [this, origin] { return open_on_behalf(origin); },
                                 .refused =
                                     [this, origin](const std::string& why) {
                                       if (auto* const there = find(origin)) answer(*there, why);
                                     },
                                 .gateway = origin.gateway});
  if (!asked) answer(adopted, asked.error().text);
}

/// An earlier process of this gateway may have admitted it, and it is reserved.
void Adopting::resume(Adopted& adopted) {
  const auto& requests = adopted.asked->requests;
  const auto found = found_.find({hands_.name_of(adopted.origin.gateway), adopted.origin.id});
  if (found == found_.end() || requests.size() != 1 || found->second.body != requests.front().body)
    return;
  adopted.theirs = {requests.front().id};
  adopted.ours = {found->second};
  adopted.open = true;
  adopted.due = Due::resume;
  found_.erase(found);
}

std::optional<Reserving::Wish> Adopting::wish_on_behalf(const core::cluster::Origin& origin) {
  auto* const adopted = find(origin);
  if (adopted == nullptr) return std::nullopt;
  auto wish = hands_.wish(adopted->ours.front(), origin.gateway);
  if (!wish) {
    answer(*adopted, wish.error().text);
    return std::nullopt;
  }
  wish->asked.for_gateway = hands_.name_of(origin.gateway);
  wish->asked.for_number = origin.id;
  return std::move(*wish);
}

bool Adopting::open_on_behalf(const core::cluster::Origin& origin) {
  auto* const adopted = find(origin);
  if (adopted == nullptr) return false;
  const auto done = hands_.admit(adopted->ours.front());
  adopted->open = done.has_value();
  answer(*adopted, done ? std::string() : done.error().text);
  return adopted->open;
}

bool Adopting::keep_found(const cluster::Asked& asked) {
  if (asked.for_gateway.empty() || asked.requests.size() != 1) return false;
  found_.insert_or_assign(For(asked.for_gateway, asked.for_number), asked.requests.front());
  return true;
}

void Adopting::publishers_gone() {
  for (auto& [key, adopted] : adopted_) adopted.check = adopted.is_on_behalf();
}

bool Adopting::ends_with_publisher(Adopted& adopted) const {
  if (!adopted.open || !hands_.is_without_publisher(adopted.ours.front())) return false;
  close(adopted);
  answer(adopted, "the publisher that it is for is not admitted any more");
  return true;
}

void Adopting::withdrawn(core::AdmissionId id, const std::string& why) {
  for (auto& [key, adopted] : adopted_) {
    if (!adopted.is_on_behalf() || !adopted.open || adopted.ours.front().id != id) continue;
    close(adopted);
    answer(adopted, why);
  }
}

void Adopting::restore() const {
  for (const auto& [key, adopted] : adopted_)
    if (adopted.open)
      for (const control::Request& request : adopted.ours) hands_.restore(request);
}

bool Adopting::has(core::AdmissionId id) const {
  return std::ranges::any_of(adopted_, [&](const auto& entry) {
    return entry.second.open && std::ranges::find(entry.second.ours, id, &control::Request::id) !=
                                    entry.second.ours.end();
  });
}

bool Adopting::is_twin(core::AdmissionId id) const {
  const std::string self = hands_.name_of(networks_.permits().self());
  return std::ranges::any_of(adopted_, [&](const auto& entry) {
    const Adopted& adopted = entry.second;
    return adopted.asked && adopted.asked->for_gateway == self &&
           std::ranges::find(adopted.ours, id, &control::Request::id) != adopted.ours.end();
  });
}

}  // namespace mlcca
