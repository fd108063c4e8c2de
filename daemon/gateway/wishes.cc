// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/wishes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <set>

#include "control/protobuf.hpp"
#include "core/admission/permit_check.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

constexpr Value kWishAgain = 2'000'000'000;          // when it may fit
constexpr Value kRefusedWishAgain = 5'000'000'000;   // ns
constexpr Value kGrantedWishAgain = 60'000'000'000;  // after a grant with which it should fit
constexpr std::size_t kRequestOctets = 16;           // of a request in a text, beside its own

/// Other gateways agree to described deliveries by the description.
bool is_asked_for(const core::cluster::Footprint& footprint, const cluster::StoredRequest& asked) {
  return !footprint.parts.empty() || (!footprint.gateways.empty() && !asked.requests.empty());
}

/// Whether it is an admission of this gateway.
bool is_recorded(const control::Request& request, const Recorder& recorder) {
  const auto* const there = recorder.contents().admissions.find(request.id);
  return there != nullptr && *there == request;
}

/// The requests that an entry of the store contains, each of them once.
class AskedRequests {
 public:
  explicit AskedRequests(const Recorder& recorder) : recorded_(recorder.contents().admissions) {}

  /// Counts the request of an admission of this gateway, and appends it to `to` if others are to
  /// decide on it.
  void add(core::AdmissionId id, bool is_asked, std::vector<control::Request>& to) {
    const control::Request* const request = id == 0 ? nullptr : recorded_.find(id);
    if (request == nullptr || !recorded_.through(id).empty()) return;
    if (counted_.insert(id).second) octets_ += control::bytes_of(*request).size() + kRequestOctets;
    if (is_asked && asked_.insert(id).second) to.push_back(*request);
  }
  [[nodiscard]] bool has_room() const {
    return counted_.size() <= cluster::StoredRequest::kMostRequests &&
           octets_ <= Reserving::kMostText;
  }

 private:
  const store::RecordedAdmissions& recorded_;
  std::set<core::AdmissionId> counted_, asked_;
  std::size_t octets_ = 0;
};

}  // namespace

bool Wishes::ask_for_one() {
  const std::vector<std::size_t> wishes = state().wishes();
  const auto due = std::ranges::find_if(wishes, [this](std::size_t channel) {
    const auto again = wish_again_.find(state().system().channels[channel].name);
    return again == wish_again_.end() || again->second <= now();
  });
  if (due == wishes.end()) return false;
  wish(*due);
  return true;
}

/// Even what was tried a short time ago: a gateway has failed, for example, and what it carried is
/// to be reserved now.
void Wishes::anew() {
  wish_again_.clear();
  want_again_.clear();
}

void Wishes::forget_past_pauses() {
  const auto is_past = [this](const auto& entry) { return entry.second <= now(); };
  std::erase_if(wish_again_, is_past);
  std::erase_if(want_again_, is_past);
}

/// Asks for one want of the channel at a time.
void Wishes::wish(std::size_t channel) {
  const std::string name = state().system().channels[channel].name;
  wish_again_[name] = add_saturating(now(), kWishAgain);
  const auto wished = std::make_shared<Wished>();
  const auto again_in = [this, name, wished](Value time) {
    want_again_[{name, wished->gateways}] = add_saturating(now(), time);
    wish_again_.erase(name);
  };
  parts_.ask({.decide = [this, name, wished] { return wish_next(name, *wished); },
              .granted =
                  [this, name, wished, again_in] {
                    objections_.erase({name, wished->gateways});
                    again_in(wished->all ? kGrantedWishAgain : 0);
                    return is_granted(name, *wished);
                  },
              .refused =
                  [this, name, wished, again_in](const Reserving::Refusal& why) {
                    note_objection(name, wished->gateways, why);
                    again_in(kRefusedWishAgain);
                    parts_.log.info(Kind::gateway, name + " waits: " + why.why);
                  }});
}

void Wishes::note_withdrawal(const std::string& channel, std::vector<std::size_t> gateways,
                             const Reserving::Refusal& why) {
  want_again_[{channel, gateways}] = add_saturating(now(), kRefusedWishAgain);
  wish_again_.erase(channel);
  note_objection(channel, std::move(gateways), why);
}

void Wishes::note_objection(const std::string& channel, std::vector<std::size_t> gateways,
                            const Reserving::Refusal& why) {
  if (why.gateway)
    objections_.insert_or_assign({channel, std::move(gateways)},
                                 Objection{.gateway = *why.gateway, .why = why.why});
  else
    objections_.erase({channel, std::move(gateways)});
}

std::string Wishes::objection(const std::string& channel,
                              std::span<const std::size_t> gateways) const {
  const auto is_on_way = [&](std::size_t g) {
    return std::ranges::find(gateways, g) != gateways.end();
  };
  for (auto it = objections_.lower_bound({channel, {}});
       it != objections_.end() && it->first.first == channel; ++it) {
    if (!std::ranges::all_of(it->first.second, is_on_way)) continue;
    const std::string& name = state().system().gateways[it->second.gateway].name;
    const std::string own = name + ": ";
    const std::string& why = it->second.why;
    return fmt::format("gateway {}: {}", name, why.starts_with(own) ? why.substr(own.size()) : why);
  }
  return {};
}

/// Whether all of them can decide now. The first one that cannot is noted.
bool Wishes::are_there(const std::string& channel, const std::vector<std::size_t>& gateways) {
  for (const std::size_t g : gateways)
    if (std::string why = parts_.session.member->view().absence(g, now()); !why.empty()) {
      note_objection(channel, gateways, {.why = std::move(why), .gateway = g});
      return false;
    }
  return true;
}

/// Those of which a gateway on the way is not there wait, and the others take turns.
std::optional<Reserving::Wish> Wishes::wish_next(const std::string& channel, Wished& wished) {
  const auto there = state().find_channel(channel);
  if (!there) return std::nullopt;
  const core::Proposal proposal = state().wish(*there);
  if (!proposal.fit()) return std::nullopt;
  for (core::cluster::Want& want : core::cluster::wants_of(proposal, parts_.session.self)) {
    const auto again = want_again_.find({channel, want.gateways});
    const bool is_due = again == want_again_.end() || again->second <= now();
    if (!is_due || !are_there(channel, want.gateways)) continue;
    const std::size_t wanted = want.deliveries.size();
    auto wish = wish_of(channel, proposal, want);
    if (!wish) continue;
    wished = {.gateways = want.gateways, .deliveries = {}, .all = want.deliveries.size() == wanted};
    for (const core::Verdict* const v : want.deliveries)
      wished.deliveries.push_back(state().delivery_of(*v));
    return wish;
  }
  wish_again_[channel] = add_saturating(now(), kRefusedWishAgain);
  return std::nullopt;
}

bool Wishes::is_granted(const std::string& channel, const Wished& wished) const {
  const auto there = state().find_channel(channel);
  return there &&
         std::ranges::any_of(state().decisions()[*there].verdicts, [&](const core::Verdict& v) {
           return v.granted && std::ranges::find(wished.deliveries, state().delivery_of(v)) !=
                                   wished.deliveries.end();
         });
}

/// nullopt: there is nothing to reserve, and nobody to ask.
std::optional<Reserving::Wish> Wishes::wish_of(const std::string& channel,
                                               const core::Proposal& proposal,
                                               core::cluster::Want& want) const {
  cluster::StoredRequest asked = asked_of(channel, want);
  auto footprint = core::cluster::footprint_of(
      proposal, want.deliveries, parts_.session.networks->baseline(), parts_.session.self);
  if (!is_asked_for(footprint, asked)) return std::nullopt;
  add_publishers(footprint, asked);
  return Reserving::Wish{
      .footprint = std::move(footprint), .publisher = {}, .asked = std::move(asked)};
}

/// The admissions to which other gateways have to agree, or those of the publishers where none has
/// to. What another gateway has admitted for this one is not asked for here. Deliveries for which
/// there is no room leave the want.
cluster::StoredRequest Wishes::asked_of(const std::string& channel,
                                        core::cluster::Want& want) const {
  cluster::StoredRequest asked{.channel = channel, .requests = {}};
  const core::Members& members = state().members();
  const bool crosses_others = !want.gateways.empty();
  AskedRequests all(parts_.recorder);
  for (auto it = want.deliveries.begin(); it != want.deliveries.end(); ++it) {
    std::vector<control::Request> further;
    const auto to_agree = crosses_others ? core::admissions_to_agree(members, **it)
                                         : std::vector<core::AdmissionId>();
    for (const core::AdmissionId id : to_agree) all.add(id, true, further);
    // Where others have to agree, add_publishers() adds it.
    all.add(members.admission_of_publisher((*it)->publisher), !crosses_others, further);
    if (!all.has_room() && it != want.deliveries.begin()) {
      want.deliveries.erase(it, want.deliveries.end());
      break;
    }
    std::ranges::move(further, std::back_inserter(asked.requests));
  }
  return asked;
}

void Wishes::add_subscribers(const core::Proposal& wish, cluster::StoredRequest& to) const {
  const core::Permits& permits = parts_.session.networks->permits();
  AskedRequests all(parts_.recorder);
  for (const core::Verdict* const v : wish.verdicts()) {
    const auto to_agree = core::admissions_to_agree(wish.state().members(), *v);
    const bool is_agreed = std::ranges::any_of(to_agree, [&](core::AdmissionId id) {
      return std::ranges::all_of(v->route, [&](core::Place place) {
        return place.kind != core::Place::Kind::gateway || place.index == permits.self() ||
               permits.is_agreed(id, place.index);
      });
    });
    if (is_agreed) continue;
    for (const core::AdmissionId id : to_agree) all.add(id, true, to.requests);
  }
}

void Wishes::add_publishers(const core::cluster::Footprint& footprint,
                            cluster::StoredRequest& to) const {
  const auto has = [](const std::vector<control::Request>& all, core::AdmissionId id) {
    return std::ranges::find(all, id, &control::Request::id) != all.end();
  };
  for (const core::cluster::Part& part : footprint.parts)
    for (const core::cluster::RatePart& rate : part.rates) {
      const core::AdmissionId id = rate.source.admission;
      if (id == 0 || has(to.requests, id) || has(to.also, id)) continue;
      const auto* const request = parts_.recorder.contents().admissions.find(id);
      if (request != nullptr) to.also.push_back(*request);
    }
}

bool Wishes::is_known(const cluster::StoredRequest& asked) const {
  const auto known = [&](const control::Request& request) {
    // Another gateway was asked for the subscriber alone.
    return asked.on_behalf ? !parts_.recorder.contents().admissions.through(request.id).empty()
                           : is_recorded(request, parts_.recorder);
  };
  // What another gateway was asked for is not in the state yet, and so is its channel if it is not
  // described.
  return (asked.on_behalf || state().find_channel(asked.channel)) &&
         std::ranges::all_of(asked.requests, known) && std::ranges::all_of(asked.also, known);
}

bool Wishes::has_publishers_of(const cluster::StoredRequest& asked) const {
  return std::ranges::all_of(asked.also, [this](const control::Request& request) {
    return is_recorded(request, parts_.recorder);
  });
}

/// The granted deliveries that need it. One that was made for another gateway is needed as long as
/// its subscriber is given anything, so that the other gateway follows the publisher.
Wishes::Deliveries Wishes::uses_of(SharedNetworks::Number number,
                                   const Reserving::Held& held) const {
  const auto there = state().find_channel(held.channel);
  if (!there) return {};
  Deliveries uses;
  for (const core::Verdict& v : state().decisions()[*there].verdicts)
    if (v.granted && (!state().is_permitted_without(v, number) ||
                      (!held.for_gateway.empty() && takes_part(v, held.admissions))))
      uses.push_back(&v);
  return uses;
}

bool Wishes::takes_part(const core::Verdict& v, std::span<const core::AdmissionId> ids) const {
  const core::Members& members = state().members();
  const auto has = [ids](core::AdmissionId id) { return std::ranges::find(ids, id) != ids.end(); };
  return has(members.admission_of_publisher(v.publisher)) ||
         std::ranges::any_of(v.subscribers, [&](std::size_t subscriber) {
           return has(members.admission_of_subscriber(subscriber));
         });
}

/// Of its admissions, with those that take part in one of these deliveries.
std::optional<Reserving::Wish> Wishes::rest_of(SharedNetworks::Number number,
                                               const Reserving::Held& held) const {
  const Deliveries uses = uses_of(number, held);
  if (uses.empty()) return std::nullopt;
  Reserving::Wish rest{.footprint = core::cluster::footprint_of(
                           state(), uses, parts_.session.networks->baseline(), parts_.session.self),
                       .publisher = {},
                       .asked = {.channel = held.channel,
                                 .requests = {},
                                 .for_gateway = held.for_gateway,
                                 .for_number = held.for_number}};
  for (const core::AdmissionId id : held.admissions) {
    const auto* const request = request_of(id);
    if (request != nullptr && std::ranges::any_of(uses, [&](const core::Verdict* v) {
          return takes_part(*v, std::span(&id, 1));
        }))
      rest.asked.requests.push_back(*request);
  }
  const auto& gateways = state().system().gateways;
  const auto other = std::ranges::find(gateways, held.for_gateway, &core::Gateway::name);
  if (other != gateways.end())
    core::cluster::add_gateway(rest.footprint, static_cast<std::size_t>(other - gateways.begin()));
  add_publishers(rest.footprint, rest.asked);
  return rest;
}

const control::Request* Wishes::request_of(core::AdmissionId id) const {
  const auto* const own = parts_.recorder.contents().admissions.find(id);
  return own != nullptr ? own : parts_.session.adopting->request_of(id);
}

}  // namespace mlcca
