// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/rollout.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/many.hpp"
#include "core/cluster/keys.hpp"
#include "core/cluster/shared.hpp"
#include "daemon/gateway/stored_octets.hpp"
#include "daemon/gateway/text_source.hpp"
#include "description/bundle.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

constexpr std::size_t kDigestOctets = Sha256::Digest{}.size();
constexpr std::uint64_t kLongestWait = 60'000'000'000;  // until a text begins to be read

std::vector<std::string> chunks_of(const std::string& text) {
  std::vector<std::string> chunks;
  for (std::size_t at = 0; at < text.size(); at += cc::kMostChunkBytes)
    chunks.push_back(text.substr(at, cc::kMostChunkBytes));
  return chunks;
}

constexpr const char* kUnchecked =
    "whether this description takes others off a network is not known: the one in force in the "
    "cluster is not kept here";

void note_damage(Described& described, const std::string& damage) {
  if (!damage.empty()) described.notes.push_back("what is kept of the cluster: " + damage);
}

/// The description that a rollout has put in force in place of the file; nullopt if its text is
/// lost or damaged.
std::optional<Described> rolled_out(Described& file, const TextSource& rolled,
                                    const ReadText& read_text) {
  std::string damage;
  const auto text = rolled.text(damage);
  note_damage(file, damage);
  if (!text) return std::nullopt;
  auto other = read_text(*text);
  if (!other || other->digest != rolled.digest) return std::nullopt;
  other->file_digest = file.file_digest;
  other->notes = std::move(file.notes);
  return std::move(*other);
}

using SharedPorts = std::optional<std::vector<cc::SharedPort>>;

/// The shared ports of the description in force; nullopt if its text is not available.
SharedPorts ports_in(const TextSource& in_force, const ReadText& read_text, Described& file) {
  std::string damage;
  const auto text = in_force.text(damage);
  note_damage(file, damage);
  if (!text) return std::nullopt;
  const auto known = read_text(*text);
  if (!known || known->digest != in_force.digest) return std::nullopt;
  return cc::shared_ports(known->state->system(), known->self);
}

/// Checks that a file which is not the description in force takes no other gateways off a network.
/// If that is not known, the file is refused; at a start it is loaded, and others are assumed to be
/// on all networks.
DescribedResult held_against(Described file, const SharedPorts& in_force, bool starts) {
  if (!in_force && !starts) {
    std::vector<std::string> lines{kUnchecked};
    lines.insert(lines.end(), file.notes.begin(), file.notes.end());
    return std::unexpected(StartError{.lines = std::move(lines)});
  }
  if (!in_force) {
    file.notes.push_back(std::string(kUnchecked) + ": all its networks are closed until it is");
    file.unchecked = true;
    file.state->share_all(file.self);
    return file;
  }
  std::string why = cc::no_longer_shared(*in_force, file.state->system(), file.self);
  if (why.empty()) return file;
  return std::unexpected(StartError{.lines = {std::move(why)}, .bad_input = true});
}

Response not_handed_over(const std::string& why) { return failed("nothing was changed: " + why); }

}  // namespace

std::string hex_of_digest(const Sha256::Digest& digest) {
  return digest == Sha256::Digest{} ? std::string() : cc::hex_of(digest);
}

std::string shown_digits(const Sha256::Digest& digest) {
  constexpr std::size_t digits = 12;
  return hex_of_digest(digest).substr(0, digits);
}

void Rollout::restore(const store::Membership& record) {
  following_.rolled = array_of<kDigestOctets>(record.rolled_digest);
  following_.replaced = array_of<kDigestOctets>(record.replaced_digest);
  following_.in_force = array_of<kDigestOctets>(record.in_force_digest);
  following_.voted = array_of<kDigestOctets>(record.voted_digest);
}

void Rollout::put_into(store::Membership& record) const {
  record.rolled_digest = octets_of(following_.rolled);
  record.replaced_digest = octets_of(following_.replaced);
  record.in_force_digest = octets_of(following_.in_force);
}

// --- what is loaded ------------------------------------------------------------------------------

void Rollout::loaded() {
  // It was found usable together with the description that was in force then.
  checked_.reset();
  checks_file_ = true;
  Scene& scene = parts_.scene;
  const std::string text = std::exchange(scene.text, {});
  if (text.empty()) return;
  const auto kept = parts_.patience.wait_for([&] { return parts_.texts.keep(scene.digest, text); });
  if (!kept)
    parts_.log.warning(Kind::problem,
                       "the description cannot be kept for other gateways: " + kept.error().text);
}

void Rollout::note_followed() {
  following_.note_loaded(parts_.scene.digest, parts_.scene.file_digest);
}

std::optional<Rollout::Digest> Rollout::pending() const {
  const bool is_open = own_.state == "staging" || own_.state == "judged";
  return is_open && !staged_ ? std::optional(own_.digest) : std::nullopt;
}

cc::Rollout Rollout::own() {
  const Digest& digest = parts_.scene.digest;
  // The first description of a cluster replaces none.
  return {.digest = digest,
          .chunks = chunks_of(kept(digest).value_or("")),
          .without = {},
          .force = true};
}

void Rollout::report_damage(const std::string& damage) {
  if (!damage.empty())
    parts_.log.warning(Kind::problem, "what is kept of the cluster cannot be used: " + damage);
}

std::optional<std::string> Rollout::kept(const Digest& digest) {
  KeptText known = parts_.patience.wait_for([&] { return parts_.texts.reader()(digest); });
  report_damage(known.damage);
  return std::move(known.text);
}

Rollout::Text Rollout::in_store(const Digest& digest, const cc::Member& member) {
  const auto& blobs = member.view().records().blobs;
  const std::string name = hex_of_digest(digest);
  std::string all;
  std::uint64_t next = 0;
  for (auto it = blobs.lower_bound({name, 0}); it != blobs.end() && it->first.first == name; ++it) {
    if (it->first.second != next++) return nullptr;
    all += it->second;
  }
  return all.empty() ? nullptr : std::make_shared<const std::string>(std::move(all));
}

// --- what the store says -------------------------------------------------------------------------

void Rollout::on(const cc::Judge& event) {
  // What was found usable may be lossy for those who are admitted by now.
  const bool known = checked_ && checked_->digest == event.digest && checked_->force == event.force;
  if (known || event.digest == parts_.scene.digest) {
    vote_.emplace(event.digest, why_not_kept(event));
    return;
  }
  if (event.content.empty()) {
    vote_.emplace(event.digest, "this gateway has another description");
    return;
  }
  if (next_check_ && next_check_->why == Why::propose)
    finish("another description is being rolled out");
  next_check_ =
      std::make_shared<Check>(Check{.why = Why::judge,
                                    .digest = event.digest,
                                    .text = std::make_shared<const std::string>(event.content),
                                    .force = event.force});
}

/// A gateway that votes for a description must be able to load it after a crash, so its text is
/// kept on disk. Why that fails; empty if the text is on disk, or if it is the file that is loaded
/// here and too long to be handed on.
std::string Rollout::why_not_kept(const cc::Judge& event) {
  const bool known = checked_ && checked_->digest == event.digest;
  const std::string& text = known ? *checked_->text : event.content;
  const auto done = parts_.patience.wait_for([&]() -> Result<void> {
    if (const auto there = parts_.texts.reader()(event.digest).text)
      return parts_.texts.keep(event.digest, *there);
    return text.empty() ? Result<void>() : parts_.texts.keep(event.digest, text);
  });
  return done ? std::string() : "it cannot be kept: " + done.error().text;
}

void Rollout::on(const cc::NotRolledOut& event) {
  if (own_.state == "staging" || own_.state == "judged")
    finish(event.why.empty() ? "the gateway that proposed it has given it up" : event.why);
  keep_needed();
}

void Rollout::keep_needed() {
  std::set<Digest> needed{parts_.scene.digest, following_.rolled, following_.in_force, former_,
                          following_.voted};
  if (following_.wanted) needed.insert(*following_.wanted);
  if (checked_) needed.insert(checked_->digest);
  if (vote_) needed.insert(vote_->first);
  static_cast<void>(parts_.patience.wait_for([&] {
    parts_.texts.keep_only(needed);
    return true;
  }));
}

void Rollout::on(const cc::Switch& event) {
  note_followed();
  const bool here = event.digest == parts_.scene.digest;
  following_.on(event, parts_.scene.digest);
  if (event.open && here) {
    former_ = event.former;
    keep_needed();
  }
  const bool ours = own_.digest == event.digest && !own_.state.empty() && own_.state != "refused";
  if (ours) own_.state = event.open ? "in-force" : "switching";
  if (!ours && own_.state == "switching")
    finish(event.undone && event.former == own_.digest
               ? "not all gateways could put it in force: the former one comes back"
               : "another description has come into force since");
  parts_.log.notice(Kind::rollout, fmt::format("description {} ({}) of the cluster {}{}",
                                               event.generation, shown_digits(event.digest),
                                               event.open ? "is in force" : "comes into force",
                                               here ? "" : ": this gateway has another one"));
}

// --- a text is read beside the loop --------------------------------------------------------------

std::string Rollout::why_not(Check& check) const {
  DescribedResult& read = *check.read;
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
  if (check.why == Why::propose)
    if (const auto name = unknown_gateway(*read); !name.empty())
      return fmt::format("there is no gateway '{}', neither in it nor in the one in force", name);
  if (std::string why = parts_.misfit(*read); !why.empty() || check.force) return why;
  return check.why == Why::follow ? std::string() : why_lost(*read);
}

/// Which grants would be lost here; empty: none.
std::string Rollout::why_lost(Described& next) const {
  constexpr std::size_t most = 3;
  std::vector<std::string> lost = parts_.losses(next);
  if (lost.empty()) return {};
  const std::size_t all = lost.size();
  if (all > most) lost.resize(most);
  return fmt::format("{} would be lost: {}{}; --force rolls it out all the same",
                     many(all, "grant"), fmt::join(lost, "; "),
                     all > most ? fmt::format("; and {} more", all - most) : "");
}

/// The first name in own_.without that no description has; empty if there is none.
std::string Rollout::unknown_gateway(const Described& next) const {
  const auto has = [](const core::System& system, const std::string& name) {
    return std::ranges::find(system.gateways, name, &core::Gateway::name) != system.gateways.end();
  };
  for (const std::string& name : own_.without)
    if (!has(parts_.scene.state->system(), name) && !has(next.state->system(), name)) return name;
  return {};
}

/// Ends a check whose thread may hang, or which has waited too long for the thread.
bool Rollout::give_up_check() {
  if (!check_) return false;
  const bool waits = check_begun_ ? parts_.reading.waits()
                                  : parts_.clock.monotonic_ns() - check_since_ <= kLongestWait;
  if (waits) return false;
  const auto given_up = std::exchange(check_, nullptr);
  end(*given_up, "it could not be read in time");
  return true;
}

bool Rollout::begin_check() {
  if (give_up_check()) return true;
  if (!check_ && next_check_) {
    check_ = std::exchange(next_check_, nullptr);
    check_begun_ = false;
    check_since_ = parts_.clock.monotonic_ns();
  }
  if (!check_ || check_begun_ || busy_) return false;
  // The thread works on its own copy, because a check may be given up meanwhile.
  const auto check = std::make_shared<Check>(Check{
      .why = check_->why, .digest = check_->digest, .text = check_->text, .force = check_->force});
  check_begun_ = parts_.reading.begin(
      [check, kept = parts_.texts.reader(), from = parts_.read] {
        if (check->why == Why::follow)
          check->text = TextSource{check->digest, kept, check->text}.text(check->damage);
        if (check->text) check->read = from(*check->text);
      },
      [this, check, begun = check_] {
        if (check_ != begun) return;  // it was given up
        check_.reset();
        checked(*check);
      });
  busy_ = !check_begun_;
  return check_begun_;
}

void Rollout::checked(Check& check) {
  report_damage(check.damage);
  if (!check.read) {
    lack(check.digest);
    return;
  }
  std::string why = why_not(check);
  if (why.empty()) {
    check.digest = (*check.read)->digest;
    const auto kept =
        parts_.patience.wait_for([&] { return parts_.texts.keep(check.digest, *check.text); });
    if (!kept) why = "it cannot be kept: " + kept.error().text;
  }
  end(check, why);
  parts_.wake();
}

/// busy_ makes the next poll() try again, once a second.
void Rollout::lack(const Digest& digest) {
  busy_ = true;
  if (std::exchange(lacking_, digest) != digest)
    parts_.log.warning(Kind::rollout,
                       fmt::format("description {} comes into force, and its text is neither kept "
                                   "here nor in the store",
                                   shown_digits(digest)));
}

void Rollout::end(const Check& check, const std::string& why) {
  if (why.empty())
    checked_ = Checked{.digest = check.digest, .text = check.text, .force = check.force};
  switch (check.why) {
    case Why::judge:
      vote_.emplace(check.digest, why);
      break;
    case Why::propose:
      own_.digest = check.digest;
      if (!why.empty())
        finish(why);
      else
        staged_ = cc::Rollout{.digest = check.digest,
                              .chunks = chunks_of(*check.text),
                              .without = own_.without,
                              .force = own_.force};
      break;
    case Why::follow:
      if (!why.empty()) cannot_ = Cannot{.digest = check.digest, .why = why};
      break;
  }
}

// --- what is due ---------------------------------------------------------------------------------

bool Rollout::step(cc::Member& member) {
  note_followed();
  bool any = begin_check();
  any = report_cannot(member) || any;
  any = cast_vote(member) || any;
  any = stage(member) || any;
  any = check_file(member) || any;
  return follow(member) || any;
}

/// Loads the file again after it was loaded unchecked at the start: when the store has the
/// description in force, or when the file itself has come into force.
bool Rollout::check_file(const cc::Member& member) {
  if (!parts_.scene.unchecked || !checks_file_ || loading_ || busy_ || following_.wanted)
    return false;
  if (parts_.scene.digest != following_.in_force && !in_store(following_.in_force, member)) {
    busy_ = true;
    return false;
  }
  loading_ = parts_.reload([this](const std::string& /*why*/) {
    loading_ = false;
    parts_.wake();
  });
  checks_file_ = busy_ = !loading_;
  return loading_;
}

void Rollout::poll() {
  busy_ = false;
  uploads_.poll();
}

/// Reports only to a member that knows what is in force: after a failed load the member is a new
/// one.
bool Rollout::report_cannot(cc::Member& member) {
  if (!cannot_ || !member.view().complete()) return false;
  const Cannot cannot = *std::exchange(cannot_, std::nullopt);
  parts_.log.error(Kind::rollout,
                   fmt::format("description {} of the cluster cannot be put in force here: {}",
                               shown_digits(cannot.digest), cannot.why));
  const auto& current = member.view().records().current.value;
  if (current && current->digest == cannot.digest) member.cannot_switch(cannot.why);
  if (following_.wanted == cannot.digest) following_.wanted.reset();
  return true;
}

bool Rollout::cast_vote(cc::Member& member) {
  if (!vote_) return false;
  const auto [digest, why] = *std::exchange(vote_, std::nullopt);
  if (why.empty()) following_.voted = digest;
  if (digest != parts_.scene.digest)
    parts_.log.notice(
        Kind::rollout,
        why.empty() ? fmt::format("agrees to description {}", shown_digits(digest))
                    : fmt::format("objects to description {}: {}", shown_digits(digest), why));
  member.vote_rollout(digest, why.empty(), why);
  return true;
}

bool Rollout::stage(cc::Member& member) {
  if (own_.state == "staging" && member.view().records().next.value &&
      member.view().records().next.value->digest == own_.digest)
    own_.state = "judged";
  if (!staged_) return false;
  const auto& current = member.view().records().current.value;
  const bool same = current && current->digest == staged_->digest;
  if (same && (current->open || staged_->without.empty())) {
    staged_.reset();
    own_.state = current->open ? "in-force" : "switching";
    return true;
  }
  own_.state = "staging";
  const EventLog::Acting acting(parts_.log, own_.actor);
  const std::string digits = shown_digits(staged_->digest);
  parts_.log.notice(Kind::rollout,
                    same ? fmt::format("called off while description {} comes into force: {}",
                                       digits, fmt::join(staged_->without, ", "))
                         : fmt::format("description {} is proposed to all gateways", digits));
  member.stage(*std::exchange(staged_, std::nullopt));
  return true;
}

bool Rollout::follow(const cc::Member& member) {
  if (!following_.wanted || loading_ || busy_ || cannot_ ||
      *following_.wanted == parts_.scene.digest)
    return false;
  if (checked_ && checked_->digest == *following_.wanted) return load();
  if (check_ || next_check_) return false;
  next_check_ = std::make_shared<Check>(Check{.why = Why::follow,
                                              .digest = *following_.wanted,
                                              .text = in_store(*following_.wanted, member)});
  return begin_check();
}

bool Rollout::load() {
  const ReadDescription read = [text = checked_->text, from = parts_.read,
                                file = parts_.scene.file_digest]() -> DescribedResult {
    auto described = from(*text);
    if (described) described->file_digest = file;
    return described;
  };
  loading_ = parts_.load(read, [this, digest = *following_.wanted](const std::string& why) {
    loading_ = false;
    if (why.empty())
      note_followed();
    else
      cannot_ = Cannot{.digest = digest, .why = why};
    parts_.wake();
  });
  busy_ = !loading_;
  return loading_;
}

void Rollout::finish(const std::string& why) {
  own_.state = "refused";
  own_.why = why;
  const EventLog::Acting acting(parts_.log, own_.actor);
  parts_.log.warning(Kind::rollout, fmt::format("description {} does not come into force: {}",
                                                shown_digits(own_.digest), why));
}

// --- the description to be loaded ----------------------------------------------------------------

/// A file that has changed since the rollout is what the operator wants, so it takes precedence.
ReadDescription Rollout::reader(ReadDescription read, const cc::Member* member) const {
  const auto source = [&](const Digest& digest) {
    return TextSource{.digest = digest,
                      .kept = parts_.texts.reader(),
                      .stored = member == nullptr ? nullptr : in_store(digest, *member)};
  };
  const Scene& scene = parts_.scene;
  SharedPorts here;
  if (scene.state && scene.digest == following_.in_force)
    here = cc::shared_ports(scene.state->system(), scene.self);
  return [read = std::move(read), rolled = source(following_.rolled),
          in_force = source(following_.in_force), here = std::move(here), following = following_,
          read_text = parts_.read, starts = member == nullptr]() -> DescribedResult {
    auto file = read();
    if (!file) return file;
    file->file_digest = file->digest;
    if (following.replaces(file->digest))
      if (auto other = rolled_out(*file, rolled, read_text)) return std::move(*other);
    if (file->digest == in_force.digest || in_force.digest == Digest{}) return file;
    const SharedPorts ports = here ? here : ports_in(in_force, read_text, *file);
    return held_against(std::move(*file), ports, starts);
  };
}

// --- requests of clients -------------------------------------------------------------------------

void Rollout::session_closed(std::uint64_t session) { uploads_.end(session); }

Response Rollout::take(const Asker& asker, const control::RolloutRequest& request,
                       cc::Member& member) {
  const std::uint64_t session = asker.peer.session;
  if (request.back || request.accept || request.cancel) {
    uploads_.end(session);
    if (request.cancel) return cancel(member);
    return request.back ? back(request, member) : accept(member);
  }
  if (request.more) {
    const auto size = uploads_.add(session, asker.peer.uid, request.part);
    if (!size) return not_handed_over(size.error().text);
    return control::Done{many(*size, "byte")};
  }
  auto text = uploads_.finish(session, asker.peer.uid, request.part);
  if (!text) return not_handed_over(text.error().text);
  return begin(std::move(*text), request.without, request.force, member);
}

/// Ends what is not decided yet: here, or by a vote against it, whichever gateway proposes it.
Response Rollout::cancel(cc::Member& member) {
  const auto& records = member.view().records();
  const auto& current = records.current.value;
  const std::string why = fmt::format("an operator has given it up at {}",
                                      member.view().keys().gateway_name(member.self()));
  if (own_.state == "checking" || staged_) {
    for (auto* const one : {&check_, &next_check_})
      if (*one && (*one)->why == Why::propose) one->reset();
    staged_.reset();
    finish(why);
    return state(member);
  }
  std::optional<Digest> digest;
  if (records.next.value)
    digest = records.next.value->digest;
  else if (current && !current->open && !current->undone)
    digest = current->digest;
  else if (own_.state == "staging")
    digest = own_.digest;
  if (!digest) return failed("nothing was changed: no description is being rolled out");
  parts_.log.notice(Kind::rollout, fmt::format("description {}: {}", shown_digits(*digest), why));
  member.cancel_rollout(*digest, why);
  return state(member);
}

Response Rollout::begin(std::string text, const std::vector<std::string>& without, bool force,
                        const cc::Member& member) {
  const auto& keys = member.view().keys();
  if (text.empty()) return invalid("there is no description");
  for (const std::string& name : without) {
    if (keys.gateway(name) == member.self())
      return invalid(name + " is this gateway, which is not off");
  }
  const auto& next = member.view().records().next;
  if (next.mod != 0 && !next.value)
    return failed(
        "nothing was changed: what is proposed in the store cannot be read (d/next); it is removed "
        "after two minutes");
  const bool gives_way = cc::Rollouts::gives_way(member.view().records(), without);
  const bool open = check_ || next_check_ || staged_ || own_.state == "staging" ||
                    own_.state == "judged" || (next.mod != 0 && !gives_way);
  if (open) return failed("nothing was changed: another description is being rolled out");
  own_ = Own{.number = own_.number + 1,
             .digest = {},
             .state = "checking",
             .why = {},
             .without = without,
             .actor = parts_.log.actor(),
             .force = force};
  next_check_ =
      std::make_shared<Check>(Check{.why = Why::propose,
                                    .digest = {},
                                    .text = std::make_shared<const std::string>(std::move(text)),
                                    .force = force});
  return state(member);
}

Response Rollout::back(const control::RolloutRequest& request, const cc::Member& member) {
  const auto& current = member.view().records().current.value;
  if (!current || current->former == Digest{})
    return failed("nothing was changed: there was no description before");
  // The one before may be coming back already.
  const Digest& before = current->undone && !current->open ? current->digest : current->former;
  auto text = kept(before);
  if (const Text stored = text ? nullptr : in_store(before, member)) text = *stored;
  if (!text)
    return failed(fmt::format("nothing was changed: description {} is not kept any more",
                              shown_digits(before)));
  // The way back is open whatever it loses.
  return begin(std::move(*text), request.without, true, member);
}

Response Rollout::accept(const cc::Member& member) {
  const auto& current = member.view().records().current.value;
  if (!current) return failed("nothing was changed: no description is in force in the cluster");
  if (current->digest == parts_.scene.digest)
    return control::Done{"this gateway has the description that is in force: nothing was changed"};
  if (!in_store(current->digest, member) && !kept(current->digest))
    return failed(fmt::format("nothing was changed: the store does not have the text of {}",
                              shown_digits(current->digest)));
  following_.wanted = current->digest;
  return control::Done{
      fmt::format("description {} is taken up from the cluster", shown_digits(current->digest))};
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
