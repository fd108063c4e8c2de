// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/adopting.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>
#include <variant>

#include "base/sha256.hpp"
#include "control/protobuf.hpp"
#include "daemon/gateway/requests/asked.hpp"
#include "daemon/gateway/requests/elsewhere.hpp"

namespace mlcca {
namespace {

constexpr const char* kUnwanted = "what was asked for has ended";
constexpr const char* kReplaced = "its number is that of another admission since";
constexpr const char* kAskedBefore = "it was asked for before";

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

/// Keys and leases concern the other gateway alone.
WhichRequest which_of(std::size_t gateway, const control::Request& request) {
  Sha256 hash;
  hash.add(
      control::bytes_of(control::Request{.id = 0, .body = requests::what_others_need(request)}));
  return {.gateway = gateway, .number = request.id, .content = hash.digest()};
}

/// A vote: against it for that reason, or for it if there is none.
core::cluster::Vote vote_of(std::string why) {
  const bool ok = why.empty();
  return {.ok = ok, .hop = {}, .reason = std::move(why)};
}

}  // namespace

void Adopting::on(const core::cluster::Adopt& event) {
  Adopted& adopted = adopted_[{event.origin.gateway, event.origin.id}];
  adopted = {.origin = event.origin,
             .footprint = event.footprint,
             .asked = cluster::asked_in(event.admission),
             .number = hands_.new_number(),
             .asks = {},
             .ours = {},
             .theirs = {}};
  list(adopted);
  networks_.count(adopted.number, adopted.footprint, event.origin.gateway);
  if (adopted.is_on_behalf()) resume(adopted);
}

void Adopting::on(const core::cluster::Opened& event) {
  const auto it = adopted_.find({event.origin.gateway, event.origin.id});
  // What this gateway has to answer is not lost: of one on behalf there is nothing to open.
  if (it != adopted_.end() && !it->second.is_on_behalf() && !it->second.replaced)
    it->second.due = Due::open;
}

void Adopting::on(const core::cluster::Ended& event) {
  const auto it = adopted_.find({event.origin.gateway, event.origin.id});
  if (it == adopted_.end()) return;
  close(it->second);
  if (it->second.is_on_behalf()) {
    hands_.forget(it->second.number);
    hands_.give_back(ids_in(it->second.ours));
  }
  networks_.drop(it->second.number);
  unlist(it->second);
  hold_nothing(it->second);
  adopted_.erase(it);
}

void Adopting::lost() {
  found_.clear();
  for (auto& [key, adopted] : adopted_) {
    close(adopted);
    if (adopted.is_on_behalf()) hands_.forget(adopted.number);
    networks_.drop(adopted.number);
  }
  adopted_.clear();
  requests_.clear();
}

void Adopting::list(Adopted& adopted) {
  if (!adopted.asked) return;
  for (const auto* all : {&adopted.asked->also, &adopted.asked->requests})
    for (const control::Request& request : *all)
      adopted.asks.push_back(which_of(adopted.origin.gateway, request));
  if (adopted.is_on_behalf()) return;
  for (const WhichRequest& which : adopted.asks) requests_.ask(which, key_of(adopted));
}

void Adopting::unlist(const Adopted& adopted) {
  for (const WhichRequest& which : adopted.asks) requests_.ask_no_more(which, key_of(adopted));
}

void Adopting::set_open(Adopted& adopted, bool open) {
  adopted.open = open;
  for (const WhichRequest& which : adopted.asks) requests_.set_open(which, key_of(adopted), open);
}

void Adopting::hold(Adopted& adopted, const WhichRequest& which, control::Request ours) {
  adopted.theirs.push_back(which);
  adopted.ours.push_back(std::move(ours));
  requests_.hold(which, key_of(adopted));
}

void Adopting::hold_nothing(Adopted& adopted) {
  for (const WhichRequest& which : adopted.theirs) requests_.hold_no_more(which);
  adopted.theirs.clear();
  adopted.ours.clear();
}

/// Another admission of the same gateway that asks for this request too, one that is open if there
/// is one; null if there is none.
Adopting::Adopted* Adopting::other_with(const Adopted& adopted, const WhichRequest& which) {
  const auto other = requests_.other(which, key_of(adopted));
  return other ? &adopted_.at(*other) : nullptr;
}

/// A publisher that several admissions have was taken in with the first one of them. Another one
/// keeps it.
void Adopting::hand_on(Adopted& adopted) {
  if (adopted.is_on_behalf()) return;
  for (std::size_t i = adopted.theirs.size(); i > 0; --i) {
    Adopted* const other = other_with(adopted, adopted.theirs[i - 1]);
    if (other == nullptr || (adopted.open && !other->open)) continue;
    move_request(adopted, adopted.theirs[i - 1], *other);
  }
}

void Adopting::close(Adopted& adopted) {
  hand_on(adopted);
  if (!adopted.open) return;
  set_open(adopted, false);
  hands_.remove(ids_in(adopted.ours));
  hand_on(adopted);
}

/// The other gateway cannot want it any more, and may not have ended it yet.
void Adopting::replace(Adopted& former) {
  former.replaced = true;
  unlist(former);
  close(former);
  if (former.is_on_behalf()) {
    hands_.forget(former.number);
    hands_.give_back(ids_in(former.ours));
  }
  hold_nothing(former);
  networks_.count(former.number, former.footprint, former.origin.gateway);
  former.answer = vote_of(kReplaced);
  former.due = Due::answer;
}

/// Ends what was asked for earlier with the number of this request and was something else. An error
/// if that was asked for later.
std::string Adopting::end_former(const Adopted& adopted, const WhichRequest& which) {
  for (const auto* held = requests_.held(which); held != nullptr && held->which != which;
       held = requests_.held(which)) {
    Adopted& former = adopted_.at(held->holder);
    if (former.origin.asked >= adopted.origin.asked) return kReplaced;
    replace(former);
  }
  return {};
}

/// Moves a request, in front of those that may need its publisher.
void Adopting::move_request(Adopted& from, const WhichRequest& which, Adopted& to) {
  const auto at = std::ranges::find(from.theirs, which);
  const auto ours = from.ours.begin() + (at - from.theirs.begin());
  requests_.hold(which, key_of(to));
  to.theirs.insert(to.theirs.begin(), *at);
  to.ours.insert(to.ours.begin(), std::move(*ours));
  from.theirs.erase(at);
  from.ours.erase(ours);
}

std::optional<core::AdmissionId> Adopting::ours_of(const WhichRequest& which) const {
  const auto* const held = requests_.held(which);
  if (held == nullptr || held->which != which) return std::nullopt;
  const Adopted& holder = adopted_.at(held->holder);
  const auto at = std::ranges::find(holder.theirs, which) - holder.theirs.begin();
  return holder.ours[static_cast<std::size_t>(at)].id;
}

control::Request Adopting::with_own_number(control::Request request) const {
  request.id = hands_.new_id();
  return request;
}

/// Gives a number of this gateway to a request that no other adopted admission holds, or takes it
/// from one that is not open. The result is why that is not possible, or empty.
std::string Adopting::name_request(Adopted& adopted, const control::Request& request,
                                   const WhichRequest& which) {
  if (std::string why = end_former(adopted, which); !why.empty()) return why;
  if (const auto* const held = requests_.held(which)) {
    Adopted& holder = adopted_.at(held->holder);
    if (&holder == &adopted || holder.open) return {};
    if (holder.is_on_behalf()) return kAskedBefore;
    move_request(holder, which, adopted);
    return {};
  }
  hold(adopted, which, with_own_number(request));
  return {};
}

/// Publishers first.
std::string Adopting::name_all(Adopted& adopted) {
  auto which = adopted.asks.begin();
  for (const auto* all : {&adopted.asked->also, &adopted.asked->requests})
    for (const control::Request& request : *all)
      if (std::string why = name_request(adopted, request, *which++); !why.empty()) return why;
  return {};
}

/// The footprint with admission numbers of this gateway; nullopt if it refers to an unknown
/// admission.
std::optional<core::cluster::Footprint> Adopting::mapped(const Adopted& adopted) const {
  std::map<core::AdmissionId, WhichRequest> asks;
  for (const WhichRequest& which : adopted.asks) asks.emplace(which.number, which);
  core::cluster::Footprint out = adopted.footprint;
  bool all = true;
  const auto map = [&](core::cluster::Source& source) {
    if (source.admission == 0) return;
    const auto which = asks.find(source.admission);
    const auto ours = which == asks.end() ? std::nullopt : ours_of(which->second);
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
  std::string why = is_unwanted(adopted) ? kUnwanted : "what is asked for is not understood here";
  if (adopted.asked && !is_unwanted(adopted)) {
    why = name_all(adopted);
    networks_.leave_out(adopted.number);
    hands_.bring_in_line();
    if (why.empty()) why = misfit(adopted);
    networks_.leave_out(std::nullopt);
  }
  const core::cluster::Origin origin = adopted.origin;
  member.vote(origin, vote_of(std::move(why)), now);
}

/// Starts to carry an adopted admission. The result is why it cannot be carried, or empty.
std::string Adopting::open(Adopted& adopted) {
  if (is_unwanted(adopted)) return kUnwanted;
  if (std::string unnamed = adopted.asked ? name_all(adopted) : ""; !unnamed.empty())
    return unnamed;
  const auto footprint = mapped(adopted);
  if (!footprint) return "it takes traffic of an admission that is not known here";
  networks_.carry(adopted.number, *footprint, adopted.origin.gateway, adopted.footprint);
  networks_.leave_out(adopted.number);
  hands_.bring_in_line();
  set_open(adopted, true);
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
      member.vote(origin, vote_of(std::move(why)), now);
  } else if (due == Due::resume) {
    const auto done = hands_.admit(adopted.ours.front());
    if (!done) close(adopted);
    answer(adopted, done ? std::string() : done.error().text);
  } else if (due == Due::answer) {
    member.vote(origin, adopted.answer, now);
  }
}

// --- admissions that this gateway makes for another one ------------------------------------------

Adopting::Adopted* Adopting::find(const Ref& ref) {
  const auto it = adopted_.find({ref.origin.gateway, ref.origin.id});
  return it == adopted_.end() || it->second.number != ref.number ? nullptr : &it->second;
}

/// The other gateway asks again after a refusal, unless the publisher is gone.
void Adopting::answer(Adopted& adopted, const std::string& why) const {
  adopted.answer = vote_of(why);
  adopted.answer.final =
      !why.empty() && !adopted.ours.empty() && hands_.is_publisher_gone(adopted.ours.front());
  adopted.due = Due::answer;
}

/// Asks the store for what the subscriber of another gateway needs. The vote is the result.
void Adopting::begin_on_behalf(Adopted& adopted) {
  const auto& requests = adopted.asked->requests;
  if (requests.size() != 1 || describes_publisher(std::get<control::Admit>(requests.front().body)))
    return answer(adopted, "what is asked for is not understood here");
  const WhichRequest& which = adopted.asks.back();
  if (const std::string why = end_former(adopted, which); !why.empty()) return answer(adopted, why);
  if (requests_.held(which) != nullptr) return answer(adopted, kAskedBefore);
  hold(adopted, which, with_own_number(requests.front()));
  const Ref ref{.origin = adopted.origin, .number = adopted.number};
  const auto asked = hands_.ask({.decide = [this, ref] { return wish_on_behalf(ref); },
                                 .granted = [this, ref] { return open_on_behalf(ref); },
                                 .refused =
                                     [this, ref](const std::string& why) {
                                       if (auto* const there = find(ref)) answer(*there, why);
                                     },
                                 .gateway = ref.origin.gateway,
                                 .adopted = ref.number});
  if (!asked) answer(adopted, asked.error().text);
}

/// An earlier process of this gateway may have admitted it, and it is reserved.
void Adopting::resume(Adopted& adopted) {
  const auto& requests = adopted.asked->requests;
  const auto found = found_.find({hands_.name_of(adopted.origin.gateway), adopted.origin.id});
  if (found == found_.end() || requests.size() != 1 ||
      found->second.body != requests.front().body || requests_.held(adopted.asks.back()) != nullptr)
    return;
  hold(adopted, adopted.asks.back(), found->second);
  adopted.open = true;
  adopted.due = Due::resume;
  found_.erase(found);
}

std::optional<Reserving::Wish> Adopting::wish_on_behalf(const Ref& ref) {
  auto* const adopted = find(ref);
  if (adopted == nullptr) return std::nullopt;
  auto wish = hands_.wish(adopted->ours.front(), ref.origin.gateway);
  if (!wish) {
    answer(*adopted, wish.error().text);
    return std::nullopt;
  }
  wish->asked.for_gateway = hands_.name_of(ref.origin.gateway);
  wish->asked.for_number = ref.origin.id;
  return std::move(*wish);
}

bool Adopting::open_on_behalf(const Ref& ref) {
  auto* const adopted = find(ref);
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

bool Adopting::ends_with_publisher(Adopted& adopted) {
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

bool Adopting::is_made_for_this(const Adopted& adopted) const {
  return adopted.asked && !adopted.asked->for_gateway.empty() &&
         adopted.asked->for_gateway == hands_.name_of(networks_.permits().self());
}

bool Adopting::is_unwanted(const Adopted& adopted) const {
  return is_made_for_this(adopted) && !hands_.wants(adopted.asked->for_number);
}

void Adopting::close_made_for(Number number) {
  for (auto& [key, adopted] : adopted_)
    if (is_made_for_this(adopted) && adopted.asked->for_number == number) close(adopted);
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
  return std::ranges::any_of(adopted_, [&](const auto& entry) {
    const Adopted& adopted = entry.second;
    return is_made_for_this(adopted) &&
           std::ranges::find(adopted.ours, id, &control::Request::id) != adopted.ours.end();
  });
}

}  // namespace mlcca
