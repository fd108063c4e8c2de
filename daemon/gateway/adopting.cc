// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/adopting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/sha256.hpp"
#include "control/protobuf.hpp"
#include "daemon/gateway/requests/elsewhere.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"

namespace mlcca {
namespace {

constexpr const char* kUnwanted = "what was asked for has ended";
constexpr const char* kReplaced = "its number is that of another admission since";
/// What is done in one turn of the loop, so that beats and answers are not late. Each admission
/// counts as much as some requests.
constexpr std::size_t kMostInTurn = 256;
constexpr std::size_t kRequestsOfOne = 8;
constexpr const char* kNotUnderstood = "what is asked for is not understood here";

std::vector<core::AdmissionId> ids_in(const std::vector<control::Request>& requests) {
  std::vector<core::AdmissionId> ids;
  ids.reserve(requests.size());
  for (const control::Request& request : requests) ids.push_back(request.id);
  return ids;
}

/// Keys and leases concern the other gateway alone.
WhichRequest which_of(std::size_t gateway, const control::Request& request) {
  Sha256 hash;
  hash.add(
      control::bytes_of(control::Request{.id = 0, .body = requests::what_others_need(request)}));
  return {.gateway = gateway, .number = request.id, .content = hash.digest()};
}

/// Whether it brings a publisher, or names one.
bool has_publisher(const control::Request& request) {
  return !std::get<control::Admit>(request.body).from.empty();
}

/// `other` with the publisher of `one`, which has one; nullopt if `other` brings its own, or names
/// another one.
std::optional<control::Request> with_publisher_of(const control::Request& one,
                                                  const control::Request& other) {
  const auto& first = std::get<control::Admit>(one.body);
  control::Request both = other;
  auto& second = std::get<control::Admit>(both.body);
  if (describes_publisher(second) || (!second.from.empty() && second.from != first.from))
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

}  // namespace

/// A vote: against it for that reason, or for it if there is none.
core::cluster::Vote Adopting::vote_of(Refusal why) {
  return {
      .ok = why.why.empty(), .hop = why.hop, .reason = std::move(why.why), .gateway = why.gateway};
}

void Adopting::on(const core::cluster::Adopt& event) {
  Adopted& adopted = adopted_[{event.origin.gateway, event.origin.id}];
  adopted = {.origin = event.origin,
             .footprint = event.footprint,
             .text = event.admission,
             .asked = {},
             .number = hands_.new_number(),
             .asks = {},
             .ours = {},
             .theirs = {}};
  set_due(adopted, Due::vote);
  // An earlier process may have made it for the other gateway.
  if (!found_.empty()) read(adopted);
  networks_.count(adopted.number, adopted.footprint, event.origin.gateway);
  if (adopted.is_on_behalf()) resume(adopted);
}

void Adopting::on(const core::cluster::Opened& event) {
  const auto it = adopted_.find({event.origin.gateway, event.origin.id});
  // What this gateway has to answer is not lost: of one on behalf there is nothing to open.
  if (it != adopted_.end() && !it->second.is_on_behalf() && !it->second.replaced)
    set_due(it->second, Due::open);
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
  set_not_due(it->first);
  to_check_.erase(it->first);
  to_judge_.erase(it->first);
  adopted_.erase(it);
}

void Adopting::lost() {
  for (auto& [key, adopted] : adopted_) {
    close(adopted);
    if (adopted.is_on_behalf()) hands_.forget(adopted.number);
    networks_.drop(adopted.number);
  }
  forget();
}

void Adopting::forget() {
  adopted_.clear();
  requests_.clear();
  found_.clear();
  holders_.clear();
  made_for_this_.clear();
  on_behalf_.clear();
  votes_.clear();
  others_due_.clear();
  to_check_.clear();
  changed_.clear();
  to_judge_.clear();
  requests_of_.clear();
}

void Adopting::set_due(Adopted& adopted, Due due) {
  const Key key = key_of(adopted);
  set_not_due(key);
  adopted.due = due;
  (due == Due::vote ? votes_ : others_due_).add(key.first, key.second);
}

void Adopting::set_not_due(const Key& key) {
  votes_.remove(key.first, key.second);
  others_due_.remove(key.first, key.second);
}

/// Reads what is asked for, unless that has been done. It is read late, because there may be more
/// of it than can be decided soon.
void Adopting::read(Adopted& adopted) {
  if (adopted.text.empty()) return;
  adopted.asked = cluster::asked_in(std::exchange(adopted.text, {}));
  if (!adopted.asked) return;
  const std::size_t requests = adopted.asked->size();
  const auto of = requests_of_.find(adopted.origin.gateway);
  const std::size_t before = of == requests_of_.end() ? 0 : of->second;
  if (requests > cluster::StoredRequest::kMostRequests)
    adopted.refusal =
        fmt::format("it has more than {} requests", cluster::StoredRequest::kMostRequests);
  else if (before + requests > kMostOfGateway)
    adopted.refusal =
        fmt::format("{} would have more than {} requests here",
                    hands_.name_of(adopted.origin.gateway), std::size_t{kMostOfGateway});
  if (adopted.refusal.empty())
    list(adopted);
  else
    adopted.asked.reset();
}

void Adopting::list(Adopted& adopted) {
  for (const auto* all : {&adopted.asked->also, &adopted.asked->requests})
    for (const control::Request& request : *all)
      adopted.asks.push_back(which_of(adopted.origin.gateway, request));
  requests_of_[adopted.origin.gateway] += adopted.asks.size();
  if (is_made_for_this(adopted)) made_for_this_[adopted.asked->for_number].insert(key_of(adopted));
  if (adopted.is_on_behalf()) {
    on_behalf_.insert(key_of(adopted));
    return;
  }
  for (const WhichRequest& which : adopted.asks) requests_.ask(which, key_of(adopted));
}

void Adopting::unlist(Adopted& adopted) {
  for (const WhichRequest& which : adopted.asks) requests_.ask_no_more(which, key_of(adopted));
  if (!adopted.asks.empty()) requests_of_[adopted.origin.gateway] -= adopted.asks.size();
  adopted.asks.clear();
  on_behalf_.erase(key_of(adopted));
  if (!is_made_for_this(adopted)) return;
  const auto made = made_for_this_.find(adopted.asked->for_number);
  if (made == made_for_this_.end()) return;
  made->second.erase(key_of(adopted));
  if (made->second.empty()) made_for_this_.erase(made);
}

void Adopting::set_open(Adopted& adopted, bool open) {
  adopted.open = open;
  for (const WhichRequest& which : adopted.asks) requests_.set_open(which, key_of(adopted), open);
}

void Adopting::hold(Adopted& adopted, const WhichRequest& which, control::Request ours) {
  adopted.theirs.push_back(which);
  holders_.insert_or_assign(ours.id, key_of(adopted));
  adopted.ours.push_back(std::move(ours));
  requests_.hold(which, key_of(adopted));
}

void Adopting::hold_nothing(Adopted& adopted) {
  for (const WhichRequest& which : adopted.theirs) requests_.hold_no_more(which);
  for (const control::Request& request : adopted.ours) holders_.erase(request.id);
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

/// The store still has it: until it has not, what was in use counts as reserved by its gateway.
void Adopting::close(Adopted& adopted) {
  hand_on(adopted);
  if (!adopted.open) return;
  set_open(adopted, false);
  hands_.remove(ids_in(adopted.ours));
  if (adopted.is_on_behalf())
    hands_.give_back(ids_in(adopted.ours));
  else
    networks_.count(adopted.number, adopted.footprint, adopted.origin.gateway);
  hand_on(adopted);
}

/// This gateway cannot keep it any more.
void Adopting::end(Adopted& adopted, const Refusal& why) {
  close(adopted);
  answer(adopted, why);
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
  former.answer = vote_of({.why = kReplaced});
  set_due(former, Due::answer);
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
  holders_.insert_or_assign(ours->id, key_of(to));
  to.theirs.insert(to.theirs.begin(), *at);
  to.ours.insert(to.ours.begin(), std::move(*ours));
  from.theirs.erase(at);
  from.ours.erase(ours);
}

/// The request as it is held here; null: it is not.
const control::Request* Adopting::ours_of(const WhichRequest& which) const {
  const auto* const held = requests_.held(which);
  if (held == nullptr || held->which != which) return nullptr;
  const Adopted& holder = adopted_.at(held->holder);
  const auto at = std::ranges::find(holder.theirs, which) - holder.theirs.begin();
  return &holder.ours[static_cast<std::size_t>(at)];
}

/// Only its publisher is needed.
bool Adopting::is_also(const Adopted& adopted, const WhichRequest& which) {
  const auto end = adopted.asks.begin() + static_cast<std::ptrdiff_t>(adopted.asked->also.size());
  return std::find(adopted.asks.begin(), end, which) != end;
}

/// The numbers here of what it asks for, from the `first` one on, also of what another one holds.
std::vector<core::AdmissionId> Adopting::all_ours(const Adopted& adopted, std::size_t first) const {
  std::vector<core::AdmissionId> all;
  for (std::size_t i = first; i < adopted.asks.size(); ++i)
    if (const auto* const ours = ours_of(adopted.asks[i])) all.push_back(ours->id);
  return all;
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
    const auto* const ours = which == asks.end() ? nullptr : ours_of(which->second);
    all = all && ours != nullptr;
    if (ours != nullptr) source.admission = ours->id;
  };
  for (core::cluster::Part& part : out.parts) {
    for (auto& rate : part.rates) map(rate.source);
    for (auto& bus : part.bus) map(bus.source);
    for (auto& path : part.paths) map(path.source);
  }
  return all ? std::optional(std::move(out)) : std::nullopt;
}

void Adopting::vote(Adopted& adopted, core::cluster::Member& member, Value now) {
  if (adopted.is_on_behalf()) {
    begin_on_behalf(adopted);
    return;
  }
  Refusal why{.why = is_unwanted(adopted) ? kUnwanted : kNotUnderstood};
  if (!adopted.refusal.empty()) why.why = adopted.refusal;
  if (adopted.asked && !is_unwanted(adopted)) {
    why.why = name_all(adopted);
    if (why.why.empty()) why = misfit_now(adopted);
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
  networks_.carry(adopted.number, *footprint, adopted.origin.gateway, adopted.footprint,
                  all_ours(adopted, adopted.asked ? adopted.asked->also.size() : 0),
                  all_ours(adopted));
  networks_.leave_out(adopted.number);
  hands_.bring_in_line();
  set_open(adopted, true);
  std::string why = admit_all(adopted);
  networks_.leave_out(std::nullopt);
  if (why.empty()) return why;
  close(adopted);
  hands_.bring_in_line();
  return why;
}

/// Publishers first. The result is what cannot be admitted, and why, or empty.
std::string Adopting::admit_all(const Adopted& adopted) const {
  const auto admit = [&](bool also, auto call) -> std::string {
    for (std::size_t i = 0; i < adopted.ours.size(); ++i) {
      if (is_also(adopted, adopted.theirs[i]) != also) continue;
      if (const auto done = (admissions_.*call)(adopted.ours[i]); !done) return done.error().text;
    }
    return {};
  };
  if (std::string why = admit(true, &AdoptedAdmissions::take_in); !why.empty()) return why;
  hands_.bring_in_line();
  return admit(false, &AdoptedAdmissions::admit);
}

/// Opening comes first: votes alone do not make another gateway wait for this one.
Adopting::Adopted* Adopting::next_due() {
  for (core::cluster::FairQueue* turns : {&others_due_, &votes_}) {
    const auto gateway = turns->next();
    if (!gateway) continue;
    const Key key{*gateway, *turns->of(*gateway).begin()};
    turns->took(*gateway);
    turns->remove(key.first, key.second);
    return &adopted_.at(key);
  }
  return nullptr;
}

bool Adopting::step(core::cluster::Member& member, Value now) {
  bool any = false;
  while (done_in_turn_ < kMostInTurn) {
    Adopted* const adopted = next_due();
    if (adopted == nullptr) break;
    any = true;
    read(*adopted);
    done_in_turn_ += kRequestsOfOne + adopted->asks.size();
    act_on(*adopted, member, now);
  }
  for (const Key& key : std::exchange(to_check_, {}))
    any = ends_with_publisher(adopted_.at(key)) || any;
  any = take_back_lost() || any;
  for (const auto& [of, request] : std::exchange(found_, {})) hands_.give_back({request.id});
  return any;
}

void Adopting::act_on(Adopted& adopted, core::cluster::Member& member, Value now) {
  const Due due = std::exchange(adopted.due, Due::nothing);
  const core::cluster::Origin origin = adopted.origin;
  if (due == Due::vote) {
    vote(adopted, member, now);
  } else if (due == Due::open && !adopted.is_on_behalf()) {
    if (std::string why = open(adopted); !why.empty())
      member.vote(origin, vote_of({.why = std::move(why)}), now);
  } else if (due == Due::resume) {
    const auto done = admissions_.admit(adopted.ours.front());
    if (done)
      answer(adopted, {});
    else
      end(adopted, {.why = done.error().text});
  } else if (due == Due::answer) {
    member.vote(origin, adopted.answer, now);
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
  const auto made = made_for_this_.find(number);
  if (made == made_for_this_.end()) return;
  for (const Key& key : made->second) close(adopted_.at(key));
}

void Adopting::restore() const {
  for (const auto& [key, adopted] : adopted_)
    if (adopted.open)
      for (const control::Request& request : adopted.ours) admissions_.restore(request);
}

const Adopting::Adopted* Adopting::holder_of(core::AdmissionId id) const {
  const auto holder = holders_.find(id);
  return holder == holders_.end() ? nullptr : &adopted_.at(holder->second);
}

bool Adopting::has(core::AdmissionId id) const {
  const Adopted* const holder = holder_of(id);
  return holder != nullptr && holder->open;
}

const control::Request* Adopting::request_of(core::AdmissionId id) const {
  const Adopted* const holder = holder_of(id);
  if (holder == nullptr) return nullptr;
  const auto at = std::ranges::find(holder->ours, id, &control::Request::id);
  return at == holder->ours.end() ? nullptr : &*at;
}

bool Adopting::is_twin(core::AdmissionId id) const {
  const Adopted* const holder = holder_of(id);
  return holder != nullptr && is_made_for_this(*holder);
}

// --- on behalf of other gateways -----------------------------------------------------------------

Adopting::Adopted* Adopting::find(const Ref& ref) {
  const auto it = adopted_.find({ref.origin.gateway, ref.origin.id});
  return it == adopted_.end() || it->second.number != ref.number ? nullptr : &it->second;
}

/// The other gateway asks again after a refusal, unless the publisher is gone.
void Adopting::answer(Adopted& adopted, const Refusal& why) {
  adopted.answer = vote_of(why);
  adopted.answer.final = !why.why.empty() && !adopted.ours.empty() &&
                         admissions_.is_publisher_gone(adopted.ours.front());
  set_due(adopted, Due::answer);
}

/// Asks the store for what the subscriber of another gateway needs. The vote is the result.
void Adopting::begin_on_behalf(Adopted& adopted) {
  const auto& requests = adopted.asked->requests;
  if (requests.size() != 1 || describes_publisher(std::get<control::Admit>(requests.front().body)))
    return answer(adopted, {.why = kNotUnderstood});
  const WhichRequest& which = adopted.asks.back();
  if (const std::string why = end_former(adopted, which); !why.empty())
    return answer(adopted, {.why = why});
  if (requests_.held(which) != nullptr) return answer(adopted, {.why = kAskedBefore});
  hold(adopted, which, with_own_number(requests.front()));
  const Ref ref{.origin = adopted.origin, .number = adopted.number};
  const auto asked = hands_.reserve({.decide = [this, ref] { return wish_on_behalf(ref); },
                                     .granted = [this, ref] { return open_on_behalf(ref); },
                                     .refused =
                                         [this, ref](const Refusal& why) {
                                           if (auto* const there = find(ref)) answer(*there, why);
                                         },
                                     .gateway = ref.origin.gateway,
                                     .adopted = ref.number});
  if (!asked) answer(adopted, {.why = asked.error().text});
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
  set_due(adopted, Due::resume);
  found_.erase(found);
}

std::optional<Reserving::Wish> Adopting::wish_on_behalf(const Ref& ref) {
  auto* const adopted = find(ref);
  if (adopted == nullptr) return std::nullopt;
  auto wish = admissions_.wish(adopted->ours.front(), ref.origin.gateway);
  if (!wish) {
    answer(*adopted, wish.error());
    return std::nullopt;
  }
  wish->asked.for_gateway = hands_.name_of(ref.origin.gateway);
  wish->asked.for_number = ref.origin.id;
  return std::move(*wish);
}

bool Adopting::open_on_behalf(const Ref& ref) {
  auto* const adopted = find(ref);
  if (adopted == nullptr) return false;
  const auto done = admissions_.admit(adopted->ours.front());
  adopted->open = done.has_value();
  answer(*adopted, {.why = done ? std::string() : done.error().text});
  return adopted->open;
}

bool Adopting::keep_found(const cluster::StoredRequest& asked) {
  if (asked.for_gateway.empty() || asked.requests.size() != 1) return false;
  found_.insert_or_assign(For(asked.for_gateway, asked.for_number), asked.requests.front());
  return true;
}

void Adopting::publishers_gone() { to_check_.insert(on_behalf_.begin(), on_behalf_.end()); }

bool Adopting::ends_with_publisher(Adopted& adopted) {
  if (!adopted.open || !admissions_.is_without_publisher(adopted.ours.front())) return false;
  end(adopted, {.why = "the publisher that it is for is not admitted any more"});
  return true;
}

void Adopting::withdrawn(core::AdmissionId id, const Refusal& why) {
  const auto holder = holders_.find(id);
  if (holder == holders_.end()) return;
  Adopted& adopted = adopted_.at(holder->second);
  if (adopted.is_on_behalf() && adopted.open) end(adopted, why);
}

// --- what is not granted here any more -----------------------------------------------------------

/// Takes back the agreement to what this gateway cannot carry any more, for example because a
/// network of it is down: the gateway that has asked withdraws it, and asks again later. Nothing is
/// judged while networks are closed, since then nothing is granted for another reason.
bool Adopting::take_back_lost() {
  if (!networks_.permits().is_open()) return false;
  if (!changed_.empty())
    for (const core::AdmissionId id : admissions_.not_granted(std::exchange(changed_, {})))
      if (const auto holder = holders_.find(id); holder != holders_.end())
        to_judge_.insert(holder->second);
  bool any = false;
  while (!to_judge_.empty() && done_in_turn_ < kMostInTurn) {
    Adopted& adopted = adopted_.at(to_judge_.extract(to_judge_.begin()).value());
    if (!adopted.open) continue;
    done_in_turn_ += kRequestsOfOne + adopted.asks.size();
    const Refusal why = misfit_now(adopted);
    if (why.why.empty()) continue;
    end(adopted, why);
    any = true;
  }
  return any;
}

// --- what does not fit ---------------------------------------------------------------------------

/// Each request is tried alone, and one that only adds a subscriber also with publishers that come
/// with it. On average each request has one further try. What comes only for its publisher need not
/// fit.
Adopting::Refusal Adopting::misfit(const Adopted& adopted) const {
  if (!mapped(adopted)) return {.why = "it takes traffic of an admission that is not known here"};
  std::size_t further = adopted.ours.size();
  std::vector<const control::Request*> publishers;
  for (std::size_t i = 0; i < adopted.ours.size(); ++i) {
    const control::Request& request = adopted.ours[i];
    Refusal why = is_also(adopted, adopted.theirs[i]) ? Refusal() : admissions_.misfit(request);
    for (auto it = publishers.begin(); it != publishers.end() && !why.why.empty(); ++it) {
      const auto both = with_publisher_of(**it, request);
      if (!both) continue;
      if (further == 0) return why;
      --further;
      why = admissions_.misfit(*both);
    }
    if (!why.why.empty()) return why;
    if (has_publisher(request)) publishers.push_back(&request);
  }
  return misfit_of_held(adopted);
}

/// Beside all that is reserved except for itself.
Adopting::Refusal Adopting::misfit_now(const Adopted& adopted) {
  networks_.leave_out(adopted.number);
  hands_.bring_in_line();
  Refusal why = adopted.is_on_behalf() ? admissions_.misfit(adopted.ours.front()) : misfit(adopted);
  networks_.leave_out(std::nullopt);
  return why;
}

/// Of what another admission of the same gateway holds, and this one asks for, too.
Adopting::Refusal Adopting::misfit_of_held(const Adopted& adopted) const {
  for (const WhichRequest& which : adopted.asks) {
    const auto* const held = requests_.held(which);
    const bool is_of_another = held != nullptr && held->holder != key_of(adopted);
    const control::Request* const there =
        is_of_another && !is_also(adopted, which) ? ours_of(which) : nullptr;
    if (there == nullptr) continue;
    if (Refusal why = admissions_.misfit(*there); !why.why.empty()) return why;
  }
  return {};
}

}  // namespace mlcca
