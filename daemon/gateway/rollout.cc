// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/rollout.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <utility>

#include "base/many.hpp"
#include "core/cluster/keys.hpp"
#include "core/cluster/shared.hpp"
#include "daemon/gateway/stored_octets.hpp"
#include "description/bundle.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

constexpr std::size_t kShownDigits = 12;
constexpr std::size_t kDigestOctets = Sha256::Digest{}.size();

std::string shown(const Sha256::Digest& digest) {
  return hex_of_digest(digest).substr(0, kShownDigits);
}

std::vector<std::string> chunks_of(const std::string& text) {
  std::vector<std::string> chunks;
  for (std::size_t at = 0; at < text.size(); at += cc::kMostChunkBytes)
    chunks.push_back(text.substr(at, cc::kMostChunkBytes));
  return chunks;
}

}  // namespace

std::string hex_of_digest(const Sha256::Digest& digest) {
  return digest == Sha256::Digest{} ? std::string() : cc::hex_of(digest);
}

void Rollout::restore(const store::Membership& record) {
  rolled_ = array_of<kDigestOctets>(record.rolled_digest);
  replaced_ = array_of<kDigestOctets>(record.replaced_digest);
  in_force_ = array_of<kDigestOctets>(record.in_force_digest);
  voted_ = array_of<kDigestOctets>(record.voted_digest);
}

void Rollout::put_into(store::Membership& record) const {
  record.rolled_digest = octets_of(rolled_);
  record.replaced_digest = octets_of(replaced_);
  record.in_force_digest = octets_of(in_force_);
}

namespace {

/// A file that is not the description in force may not take others off a network.
DescribedResult held_against(DescribedResult file, const std::optional<std::string>& in_force,
                             const Sha256::Digest& digest, const ReadText& read_text) {
  if (!in_force || file->digest == digest) return file;
  const auto known = read_text(*in_force);
  if (!known || known->digest != digest) return file;
  std::string why =
      cc::no_longer_shared(known->state->system(), known->self, file->state->system(), file->self);
  if (why.empty()) return file;
  return std::unexpected(StartError{.lines = {std::move(why)}, .bad_input = true});
}

}  // namespace

// --- what is loaded ------------------------------------------------------------------------------

/// A file that was changed since is what the operator wants: it is not passed over.
ReadDescription Rollout::reader(ReadDescription read) const {
  auto rolled = rolled_ == Digest{} ? std::nullopt : parts_.texts.text(rolled_);
  auto in_force = in_force_ == Digest{} ? std::nullopt : parts_.texts.text(in_force_);
  return [read = std::move(read), rolled = std::move(rolled), digest = rolled_,
          replaced = replaced_, in_force = std::move(in_force), current = in_force_,
          read_text = parts_.read]() -> DescribedResult {
    auto file = read();
    if (!file) return file;
    file->file_digest = file->digest;
    if (rolled && file->digest == replaced && file->digest != digest) {
      auto other = read_text(*rolled);
      if (other && other->digest == digest) {
        other->file_digest = file->file_digest;
        return other;
      }
    }
    return held_against(std::move(file), in_force, current, read_text);
  };
}

void Rollout::loaded() {
  Scene& scene = parts_.scene;
  if (wanted_ == scene.digest) {
    rolled_ = scene.digest;
    replaced_ = scene.file_digest;
    wanted_.reset();
  }
  const std::string text = std::exchange(scene.text, {});
  if (text.empty()) return;
  const auto kept = parts_.patience.wait_for([&] { return parts_.texts.keep(scene.digest, text); });
  if (!kept)
    parts_.log.warning(Kind::trouble,
                       "the description cannot be kept for other gateways: " + kept.error().text);
}

cc::Rollout Rollout::own() const {
  const Digest& digest = parts_.scene.digest;
  return {
      .digest = digest, .chunks = chunks_of(parts_.texts.text(digest).value_or("")), .without = {}};
}

// --- what the store says -------------------------------------------------------------------------

void Rollout::on(const cc::Judge& event) {
  if (event.digest == parts_.scene.digest || checked_ == event.digest) {
    vote_.emplace(event.digest, "");
    return;
  }
  if (event.content.empty()) {
    vote_.emplace(event.digest, "this gateway has another description");
    return;
  }
  if (next_check_ && next_check_->why == Why::propose)
    finish("another description is being rolled out");
  next_check_ = Check{.why = Why::judge,
                      .digest = event.digest,
                      .text = std::make_shared<const std::string>(event.content),
                      .read = {}};
}

void Rollout::on(const cc::NotRolledOut& event) {
  if (own_.state == "staging" || own_.state == "judged")
    finish(event.why.empty() ? "the gateway that proposed it has given it up" : event.why);
  keep_needed();
}

void Rollout::keep_needed() {
  std::set<Digest> needed{parts_.scene.digest, rolled_, in_force_, former_, voted_};
  if (wanted_) needed.insert(*wanted_);
  parts_.texts.keep_only(needed);
}

void Rollout::on(const cc::Switch& event) {
  const bool here = event.digest == parts_.scene.digest;
  if (event.open && here) {
    in_force_ = event.digest;
    former_ = event.former;
    keep_needed();
  }
  const bool ours = own_.digest == event.digest && !own_.state.empty() && own_.state != "refused";
  if (ours) own_.state = event.open ? "in-force" : "switching";
  if (event.undone && event.former == own_.digest && own_.state == "switching")
    finish("not all gateways could put it in force: the former one comes back");
  parts_.log.notice(Kind::rollout, fmt::format("description {} ({}) of the cluster {}{}",
                                               event.generation, shown(event.digest),
                                               event.open ? "is in force" : "comes into force",
                                               here ? "" : ": this gateway has another one"));
  follow(event);
}

/// What came by a rollout goes by one. What the operator has loaded gives way to what comes into
/// force after it, and not to what has been in force before.
void Rollout::follow(const cc::Switch& event) {
  const Digest& now = parts_.scene.digest;
  if (event.digest == now) {
    wanted_.reset();
    return;
  }
  const bool by_rollout = now == rolled_;
  const bool is_new = event.digest != in_force_;
  if (by_rollout || (is_new && (event.digest == voted_ || now == in_force_)))
    wanted_ = event.digest;
}

// --- a text is read beside the loop --------------------------------------------------------------

std::string Rollout::why_not(Check& check) const {
  DescribedResult& read = **check.read;
  if (!read) return read.error().lines.front();
  if (check.why != Why::propose && read->digest != check.digest)
    return "its text is not the one of which the digest is stated";
  if (read->state->system().name != parts_.scene.state->system().name)
    return fmt::format("its System is called {}, and a rollout cannot rename {}",
                       read->state->system().name, parts_.scene.state->system().name);
  if (std::string why = cc::no_longer_shared(parts_.scene.state->system(), parts_.scene.self,
                                             read->state->system(), read->self);
      !why.empty())
    return why;
  return parts_.misfit(*read);
}

bool Rollout::begin_check() {
  if (check_ && check_->begun && !parts_.reading.waits()) {
    Check given_up = std::move(*check_);
    check_.reset();
    end(given_up, "it could not be read in time");
    return true;
  }
  if (!check_ && next_check_) check_ = std::exchange(next_check_, std::nullopt);
  if (!check_ || check_->begun || busy_) return false;
  check_->read = std::make_shared<std::optional<DescribedResult>>();
  check_->begun = parts_.reading.begin(
      [read = check_->read, text = check_->text, from = parts_.read] { *read = from(*text); },
      [this] { checked(); });
  busy_ = !check_->begun;
  return check_->begun;
}

void Rollout::checked() {
  Check check = std::move(*check_);
  check_.reset();
  std::string why = why_not(check);
  if (why.empty()) {
    check.digest = (*check.read)->value().digest;
    const auto kept =
        parts_.patience.wait_for([&] { return parts_.texts.keep(check.digest, *check.text); });
    if (!kept) why = "it cannot be kept: " + kept.error().text;
  }
  check.read.reset();
  end(check, why);
  parts_.wake();
}

void Rollout::end(Check& check, const std::string& why) {
  if (why.empty()) checked_ = check.digest;
  switch (check.why) {
    case Why::judge:
      vote_.emplace(check.digest, why);
      break;
    case Why::propose:
      own_.digest = check.digest;
      if (!why.empty())
        finish(why);
      else
        staged_ = cc::Rollout{
            .digest = check.digest, .chunks = chunks_of(*check.text), .without = own_.without};
      break;
    case Why::follow:
      if (!why.empty()) cannot_ = why;
      break;
  }
}

// --- what is due ---------------------------------------------------------------------------------

bool Rollout::step(cc::Member& member) {
  bool any = begin_check();
  any = cast_vote(member) || any;
  any = stage(member) || any;
  return follow(member) || any;
}

bool Rollout::cast_vote(cc::Member& member) {
  if (cannot_) {
    parts_.log.error(Kind::rollout,
                     "the description of the cluster cannot be put in force here: " + *cannot_);
    member.cannot_switch(*std::exchange(cannot_, std::nullopt));
    wanted_.reset();
    return true;
  }
  if (!vote_) return false;
  const auto [digest, why] = *std::exchange(vote_, std::nullopt);
  if (why.empty()) voted_ = digest;
  if (digest != parts_.scene.digest)
    parts_.log.notice(Kind::rollout,
                      why.empty()
                          ? fmt::format("agrees to description {}", shown(digest))
                          : fmt::format("objects to description {}: {}", shown(digest), why));
  member.vote_rollout(digest, why.empty(), why);
  return true;
}

bool Rollout::stage(cc::Member& member) {
  if (own_.state == "staging" && member.view().records().next.value &&
      member.view().records().next.value->digest == own_.digest)
    own_.state = "judged";
  if (!staged_) return false;
  const auto& current = member.view().records().current.value;
  if (current && current->digest == staged_->digest) {
    staged_.reset();
    own_.state = current->open ? "in-force" : "switching";
    return true;
  }
  own_.state = "staging";
  const EventLog::Acting acting(parts_.log, own_.actor);
  parts_.log.notice(Kind::rollout, fmt::format("description {} is proposed to all gateways",
                                               shown(staged_->digest)));
  member.stage(*std::exchange(staged_, std::nullopt));
  return true;
}

bool Rollout::follow(cc::Member& member) {
  if (!wanted_ || loading_ || busy_ || *wanted_ == parts_.scene.digest) return false;
  if (check_ && check_->why == Why::follow) return false;
  const Digest digest = *wanted_;
  const auto text = parts_.texts.text(digest);
  if (!text || checked_ != digest) {
    const auto there = text_of(digest, member);
    if (!there || check_) return false;
    next_check_ = Check{.why = Why::follow,
                        .digest = digest,
                        .text = std::make_shared<const std::string>(*there),
                        .read = {}};
    return begin_check();
  }
  const ReadDescription read = [text = *text, from = parts_.read,
                                file = parts_.scene.file_digest]() -> DescribedResult {
    auto described = from(text);
    if (described) described->file_digest = file;
    return described;
  };
  loading_ = parts_.load(read, [this](const std::string& why) {
    loading_ = false;
    if (!why.empty()) cannot_ = why;
    parts_.wake();
  });
  busy_ = !loading_;
  return loading_;
}

std::optional<std::string> Rollout::text_of(const Digest& digest, const cc::Member& member) const {
  if (auto text = parts_.texts.text(digest)) return text;
  const auto& blobs = member.view().records().blobs;
  const std::string name = hex_of_digest(digest);
  std::string all;
  std::uint64_t next = 0;
  for (auto it = blobs.lower_bound({name, 0}); it != blobs.end() && it->first.first == name; ++it) {
    if (it->first.second != next++) return std::nullopt;
    all += it->second;
  }
  return all.empty() ? std::nullopt : std::optional(std::move(all));
}

void Rollout::finish(const std::string& why) {
  own_.state = "refused";
  own_.why = why;
  const EventLog::Acting acting(parts_.log, own_.actor);
  parts_.log.warning(Kind::rollout, fmt::format("description {} does not come into force: {}",
                                                shown(own_.digest), why));
}

// --- who wants something -------------------------------------------------------------------------

void Rollout::session_closed(std::uint64_t session) {
  if (upload_ && upload_->session == session) upload_.reset();
}

Response Rollout::take(const Asker& asker, const control::RolloutRequest& request,
                       const cc::Member& member) {
  if (request.back) return back(request, member);
  if (request.accept) return accept(member);
  const std::uint64_t session = asker.peer.session;
  if (upload_ && upload_->session != session)
    return failed("nothing was changed: another description is being handed over");
  if (!upload_) upload_ = Upload{.session = session, .text = {}};
  if (upload_->text.size() + request.part.size() > description::kMaxBundle) {
    upload_.reset();
    return invalid(fmt::format("a description of more than {} bytes cannot be rolled out",
                               description::kMaxBundle));
  }
  upload_->text += request.part;
  if (request.more) return control::Done{many(upload_->text.size(), "byte")};
  std::string text = std::move(upload_->text);
  upload_.reset();
  return begin(std::move(text), request.without, member);
}

Response Rollout::begin(std::string text, const std::vector<std::string>& without,
                        const cc::Member& member) {
  const auto& keys = member.view().keys();
  if (text.empty()) return invalid("there is no description");
  for (const std::string& name : without) {
    const auto gateway = keys.gateway(name);
    if (!gateway) return invalid(fmt::format("there is no gateway '{}' in this cluster", name));
    if (*gateway == member.self()) return invalid(name + " is this gateway, which is not off");
  }
  const bool open = check_ || next_check_ || staged_ || own_.state == "staging" ||
                    own_.state == "judged" || member.view().records().next.mod != 0;
  if (open) return failed("nothing was changed: another description is being rolled out");
  own_ = Own{.number = own_.number + 1,
             .digest = {},
             .state = "checking",
             .why = {},
             .without = without,
             .actor = parts_.log.actor()};
  next_check_ = Check{.why = Why::propose,
                      .digest = {},
                      .text = std::make_shared<const std::string>(std::move(text)),
                      .read = {}};
  return state(member);
}

Response Rollout::back(const control::RolloutRequest& request, const cc::Member& member) {
  const auto& current = member.view().records().current.value;
  if (!current || current->former == Digest{})
    return failed("nothing was changed: there was no description before");
  auto text = text_of(current->former, member);
  if (!text)
    return failed(fmt::format("nothing was changed: description {} is not kept any more",
                              shown(current->former)));
  return begin(std::move(*text), request.without, member);
}

Response Rollout::accept(const cc::Member& member) {
  const auto& current = member.view().records().current.value;
  if (!current) return failed("nothing was changed: no description is in force in the cluster");
  if (current->digest == parts_.scene.digest)
    return control::Done{"this gateway has the description that is in force: nothing was changed"};
  if (!text_of(current->digest, member))
    return failed(fmt::format("nothing was changed: the store does not have the text of {}",
                              shown(current->digest)));
  wanted_ = current->digest;
  return control::Done{
      fmt::format("description {} is taken up from the cluster", shown(current->digest))};
}

control::Rollout Rollout::state(const cc::Member& member) const {
  const auto& view = member.view();
  const auto& records = view.records();
  control::Rollout out{.number = own_.number,
                       .state = own_.state,
                       .why = own_.why,
                       .waiting = {},
                       .description = hex_of_digest(parts_.scene.digest)};
  if (const auto& current = records.current.value) {
    out.current = hex_of_digest(current->digest);
    out.former = hex_of_digest(current->former);
    out.open = current->open;
    out.generation = current->generation;
  }
  const auto& next = records.next.value;
  if (next) {
    out.next = hex_of_digest(next->digest);
    out.by = next->by;
  }
  for (std::size_t g = 0; g < view.keys().gateways(); ++g) {
    const std::string& name = view.keys().gateway_name(g);
    const auto& vote = records.rollout_votes[g].value;
    const bool voted = vote && vote->next == records.next.mod;
    const bool is_off = next && std::ranges::find(next->without, name) != next->without.end();
    const bool missing = next ? !voted && !is_off
                              : records.current.value && !records.current.value->open &&
                                    !core::cluster::Rollouts::is_in(view, g);
    if (missing) out.waiting.push_back(name);
  }
  return out;
}

}  // namespace mlcca
