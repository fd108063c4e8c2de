// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/audit_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "core/model/text.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gateway/audit_rules.hpp"
#include "daemon/gateway/report.hpp"

namespace mlcca {
namespace {

/// The growth of a counter. One that is less than before has started again from 0.
std::uint64_t grown(std::uint64_t now, std::uint64_t before) {
  return now >= before ? now - before : now;
}

UnknownFrames grown(const UnknownFrames& now, const UnknownFrames& before) {
  return {grown(now.dropped, before.dropped), grown(now.would_drop, before.would_drop)};
}

using core::FrameReason;
using core::stated_reason;
using core::StatedReason;

/// Whether the reason implies that all such frames had the granted identifier and source.
bool is_of_publisher(const StatedReason& stated) {
  return stated.reason && !stated.is_latest && core::is_of_publisher(*stated.reason);
}

/// Whether the reason implies that none of them did.
bool is_of_sender(const StatedReason& stated) {
  return stated.reason && !stated.is_latest && core::is_of_sender(*stated.reason);
}

std::string words_of(const core::Publisher& publisher) {
  if (publisher.node) return fmt::format("node {}", *publisher.node);
  if (!publisher.station.is_wildcard()) return core::to_text(publisher.station);
  return publisher.uid ? fmt::format("user {}", *publisher.uid) : std::string();
}

/// The verdict that the names of a finding identify; nullptr if there is none.
const core::Verdict* delivery_of(const core::State& state, const control::Finding& finding) {
  const core::System& system = state.system();
  const auto channel =
      std::ranges::find(system.channels, finding.channel, &core::EventChannel::name);
  if (channel == system.channels.end()) return nullptr;
  const auto at = static_cast<std::size_t>(channel - system.channels.begin());
  for (const core::Verdict& v : state.decisions()[at].verdicts)
    if (state.members().publisher(v.publisher).name == finding.publisher &&
        core::name_of(system, v.to) == finding.to)
      return &v;
  return nullptr;
}

/// Adds the sender and why it was refused. False if the delivery is granted now or does not exist
/// any more.
bool complete_delivery(const core::State& state, control::Finding& f) {
  const core::Verdict* const v = delivery_of(state, f);
  if (v == nullptr) return false;
  const StatedReason stated = stated_reason(f.reason);
  if (is_of_publisher(stated)) f.sender = words_of(state.members().publisher(v->publisher));
  if (stated.reason != FrameReason::denied) return true;
  f.reason += ": " + why(state, *v);
  return !v->granted;
}

/// Findings are lower bounds if further frames of their interface and reason belong to no finding
/// of a kind, or those of their channel to no finding of a sender.
void mark_lower_bounds(std::vector<control::Finding>& findings) {
  const auto cause = [](const control::Finding& f) {
    return std::tie(f.interface, f.network, f.reason, f.channel.empty() ? f.described : f.channel);
  };
  std::set<std::tuple<std::string, std::string, std::string, std::string>> with_others;
  for (const control::Finding& f : findings)
    if (f.others) with_others.insert(cause(f));
  for (control::Finding& f : findings)
    f.at_least =
        !f.others && (with_others.contains(cause(f)) ||
                      with_others.contains({f.interface, f.network, f.reason, std::string()}));
}

/// Whether the frame came by the granted interface from the granted station: then it is refused
/// because the gate there has not admitted it as this delivery.
bool is_granted_source(const GateReader& gates, const core::GateEntry& entry,
                       const gates::RefusedSender& sender) {
  return sender.reason == FrameReason::source && entry.source_port &&
         gates.gated_interface(*entry.source_port) == static_cast<int>(sender.source) &&
         (entry.station.is_wildcard() || entry.station.bits == sender.frame.station);
}

/// The address of a sender. A datagram without one is from 0.0.0.0; other frames without one have
/// no MAC address either.
std::string address_of(const gates::UnknownFrame& f) {
  if (f.station == 0 && f.mac != gates::Mac{}) return "0.0.0.0";
  return gates::address_text(f.station);
}

/// The interface of a gate from which a frame came to another one.
std::string interface_of(const GateReader& gates, std::uint32_t ifindex) {
  if (ifindex == GATE_NO_SOURCE) return kFromKernel;
  for (std::size_t p = 0; p < gates.size(); ++p)
    if (gates.gated_interface(p) == static_cast<int>(ifindex)) return gates.interface_name(p);
  return fmt::format("interface {}", ifindex);
}

/// Of a frame that leaves: the user that sent it, or by which interface it came in.
void take_way(std::string& user, std::string& entered_by, const GateReader& gates,
              const gates::RefusedSender& sender) {
  if (sender.source != 0)
    entered_by = interface_of(gates, sender.source);
  else if (sender.uid != GATE_ANY_UID)
    user = fmt::format("{}", sender.uid);
}

/// The reason by which frames of no slot are counted: later parts of a message have several.
FrameReason counted_as(FrameReason reason) {
  return core::row_of(reason).kind == core::FrameReasonKind::any ? reason : FrameReason::fragment;
}

/// How many of a sender's frames an earlier state of its place contains; 0 if it is another one's.
std::uint64_t frames_before(const gates::RefusedSender& before, const gates::RefusedSender& now) {
  const bool is_same = gates::is_same(before, now) && before.frame.count <= now.frame.count;
  return is_same ? before.frame.count : 0;
}

/// Whether frames of no delivery that were refused for this reason name what they are about by
/// their identifier or subject. Of other frames it may not be known.
bool is_about_frames(const StatedReason& stated) {
  return stated.reason && (*stated.reason == FrameReason::unknown || is_of_sender(stated));
}

}  // namespace

void AuditLog::restore(const control::Audit& kept) {
  since_unix_s_ = kept.since_unix_s;
  left_out_ = kept.left_out;
  for (const control::Finding& f : kept.findings) {
    const std::uint8_t without_xl = f.fd ? GATE_FD : GATE_CLASSIC;
    const std::uint8_t format = f.xl ? std::uint8_t{GATE_XL} : without_xl;
    const bool has_identifier = is_about_frames(stated_reason(f.reason)) || f.can_id != 0;
    const bool is_can = has_identifier && f.channel.empty() && f.subject == 0 &&
                        f.address.empty() && f.mac.empty() && !f.others;
    const Key key{.interface = f.interface,
                  .network = f.network,
                  .egress = f.egress,
                  .reason = f.reason,
                  .channel = f.channel,
                  .publisher = f.publisher,
                  .to = f.to,
                  .can_id = f.can_id,
                  .format = is_can ? format : std::uint8_t{0},
                  .subject = f.subject,
                  .address = f.address,
                  .mac = f.mac,
                  .user = f.user,
                  .entered_by = f.entered_by,
                  .described = is_of_sender(stated_reason(f.reason)) ? f.described : std::string(),
                  .others = f.others};
    auto& [of, finding] = unranked(key);
    finding = {.dropped = f.dropped,
               .would_drop = f.would_drop,
               .first_unix_s = f.first_unix_s,
               .last_unix_s = f.last_unix_s,
               .busy_gap = f.busy_gap_ns,
               .length = f.length};
    ranks_.insert(rank_of(of, finding));
  }
}

// --- finding -------------------------------------------------------------------------------------

void AuditLog::refused(const core::Verdict& verdict, const core::GateEntry& entry,
                       const StatedReason& reason, Fate fate, std::uint64_t frames) {
  const core::State& state = *scene_.state;
  note({.interface = gates_.interface_name(entry.port),
        .network = gates_.network_of(entry.port),
        .egress = entry.direction == core::Direction::egress,
        .reason = to_text(reason),
        .channel = state.system().channels[verdict.channel].name,
        .publisher = state.members().publisher(verdict.publisher).name,
        .to = core::name_of(state.system(), verdict.to),
        .others = is_of_sender(reason)},
       {.fate = fate, .frames = frames});
}

void AuditLog::refused(const core::Verdict& verdict, const core::GateEntry& entry,
                       const gates::RefusedSender& sender, Fate fate, std::uint64_t frames,
                       std::uint64_t span) {
  const gates::UnknownFrame& f = sender.frame;
  if (is_granted_source(gates_, entry, sender)) {
    refused(verdict, entry, {sender.reason}, fate, frames);
    return;
  }
  Key key{.interface = gates_.interface_name(entry.port),
          .network = gates_.network_of(entry.port),
          .egress = entry.direction == core::Direction::egress,
          .reason = std::string(to_text(sender.reason)),
          .can_id = f.can_id,
          .format = f.format,
          .subject = f.subject,
          .address = address_of(f),
          .mac = gates::mac_text(f.station, f.mac),
          .described = scene_.state->system().channels[verdict.channel].name};
  if (key.egress) take_way(key.user, key.entered_by, gates_, sender);
  note(key, {.fate = fate, .frames = frames, .length = f.len, .span = span});
}

void AuditLog::poll(std::size_t port, const UnknownFrames& unknown) {
  poll(port, unknown, Reporting::yes);
}

void AuditLog::take_up(std::size_t port, const UnknownFrames& unknown) {
  if (!polled_.contains(gates_.gated_interface(port))) poll(port, unknown, Reporting::no);
}

/// Forgets what is known of interfaces that have gone.
AuditLog::Polled& AuditLog::polled_of(std::size_t port) {
  const int ifindex = gates_.gated_interface(port);
  if (!polled_.contains(ifindex)) {
    std::set<int> present;
    for (std::size_t p = 0; p < gates_.size(); ++p) present.insert(gates_.gated_interface(p));
    std::erase_if(polled_, [&](const auto& one) { return !present.contains(one.first); });
  }
  return polled_[ifindex];
}

void AuditLog::poll(std::size_t port, const UnknownFrames& unknown, Reporting reporting) {
  Polled& last = polled_of(port);
  const std::uint64_t now = clock_.monotonic_ns();
  const std::uint64_t span = last.at == 0 ? 0 : now - last.at;
  last.at = now;
  poll_reasons(port, last, span, reporting);
  if (reporting == Reporting::no) {
    poll_frames(port, last, {}, reporting);
    // Read after the kinds: no frame is in their counts that is not in this one.
    last.unknown = gates_.unknown_frames(port);
    return;
  }
  const UnknownFrames fresh = grown(unknown, std::exchange(last.unknown, unknown));
  const std::uint64_t frames = fresh.dropped + fresh.would_drop;
  if (frames == 0) return;
  // The mode does not change between two polls.
  const Fate fate = fresh.dropped != 0 ? Fate::dropped : Fate::passed;
  last.ahead += poll_frames(port, last, {.fate = fate, .span = span}, reporting);
  const std::uint64_t known = std::min(frames, last.ahead);
  last.ahead -= known;
  if (frames > known)
    note({.interface = gates_.interface_name(port),
          .network = gates_.network_of(port),
          .reason = std::string(to_text(FrameReason::unknown)),
          .others = true},
         {.fate = fate, .frames = frames - known});
}

void AuditLog::poll_reasons(std::size_t port, Polled& last, std::uint64_t span,
                            Reporting reporting) {
  // The counts first: a gate notes a sender before it counts its frame.
  FramesByReason fresh = fresh_reasons(port, last);
  poll_senders(port, last, span, reporting, fresh);
  if (reporting == Reporting::no) return;
  for (const auto& [of, frames] : fresh) note_rest(port, of, frames);
}

/// The frames that were counted since the last poll.
AuditLog::FramesByReason AuditLog::fresh_reasons(std::size_t port, Polled& last) const {
  FramesByReason fresh;
  for (const WithoutSlot& now : gates_.without_slot(port)) {
    WithoutSlot& before = last.parts[now.egress];
    if (now.all.dropped < before.all.dropped || now.all.would_drop < before.all.would_drop)
      before = {};
    // Frames that came while a count was read are missing in it, and are in the next one.
    const UnknownFrames most{std::max(now.parts.dropped, before.parts.dropped),
                             std::max(now.parts.would_drop, before.parts.would_drop)};
    fresh[{FrameReason::fragment, now.egress}] = grown(most, before.parts);
    before = {.egress = now.egress, .all = now.all, .parts = most};
  }
  for (const Refusals& counted : gates_.refusals(port)) {
    UnknownFrames& before = last.reasons[{counted.reason, counted.egress}];
    fresh[{counted.reason, counted.egress}] = grown(counted.frames, before);
    before = counted.frames;
  }
  return fresh;
}

/// Takes the frames whose sender is known from those that were counted. What is more than these is
/// left to the next poll.
void AuditLog::poll_senders(std::size_t port, Polled& last, std::uint64_t span, Reporting reporting,
                            FramesByReason& fresh) {
  decltype(last.senders) now;
  for (const gates::RefusedSender& sender : gates_.refused_senders(port)) {
    if (!sender.is_without_slot()) continue;
    const auto known = last.senders.find(sender.place);
    const std::uint64_t before =
        known == last.senders.end() ? 0 : frames_before(known->second, sender);
    gates::RefusedSender& taken = now[sender.place] = sender;
    if (reporting == Reporting::no) continue;
    const bool egress = sender.frame.direction == gates::Direction::egress;
    UnknownFrames& counted = fresh[{counted_as(sender.reason), egress}];
    const Fate fate = counted.dropped != 0 ? Fate::dropped : Fate::passed;
    std::uint64_t& left = fate == Fate::dropped ? counted.dropped : counted.would_drop;
    const std::uint64_t given = std::min(left, sender.frame.count - before);
    taken.frame.count = before + given;
    left -= given;
    if (given == 0) continue;
    Key key{.interface = gates_.interface_name(port),
            .network = gates_.network_of(port),
            .egress = egress,
            .reason = std::string(to_text(counted_as(sender.reason))),
            .can_id = sender.frame.can_id,
            .format = sender.frame.can_id == 0 ? std::uint8_t{0} : sender.frame.format,
            .subject = sender.frame.subject,
            .address = gates::address_text(sender.frame.station),
            .mac = gates::mac_text(sender.frame.station, sender.frame.mac)};
    if (egress) take_way(key.user, key.entered_by, gates_, sender);
    note(key, {.fate = fate, .frames = given, .length = sender.frame.len, .span = span});
  }
  last.senders = std::move(now);
}

/// Frames of senders that the gate does not keep, or keeps no more. A closed gate keeps none.
void AuditLog::note_rest(std::size_t port, const ReasonOfGate& of, const UnknownFrames& frames) {
  const auto& [reason, egress] = of;
  const bool is_closed = reason == FrameReason::closed;
  const Key key{.interface = gates_.interface_name(port),
                .network = gates_.network_of(port),
                .egress = is_closed && egress,
                .reason = std::string(to_text(reason)),
                .others = !is_closed};
  if (frames.dropped != 0) note(key, {.fate = Fate::dropped, .frames = frames.dropped});
  if (frames.would_drop != 0) note(key, {.fate = Fate::passed, .frames = frames.would_drop});
}

/// The gate counts a kind of frame until another kind takes its place; then the count starts again,
/// with another sequence number.
std::uint64_t AuditLog::poll_frames(std::size_t port, Polled& last, News news,
                                    Reporting reporting) {
  std::uint64_t noted = 0;
  decltype(last.frames) now;
  for (const gates::UnknownFrame& f : gates_.seen_unknown(port)) {
    const bool egress = f.direction == gates::Direction::egress;
    const auto key = std::tuple(f.can_id, f.subject, f.format, egress);
    now[key] = {f.count, f.sequence};
    const auto known = last.frames.find(key);
    const Polled::Frame before = known == last.frames.end() ? Polled::Frame{} : known->second;
    if (reporting == Reporting::no || f.sequence == before.sequence) continue;
    news.frames = f.count > before.count ? f.count - before.count : f.count;
    news.length = f.len;
    noted += news.frames;
    note({.interface = gates_.interface_name(port),
          .network = gates_.network_of(port),
          .egress = egress,
          .reason = std::string(to_text(FrameReason::unknown)),
          .can_id = f.can_id,
          .format = f.format,
          .subject = f.subject,
          .address = address_of(f),
          .mac = gates::mac_text(f.station, f.mac)},
         news);
  }
  last.frames = std::move(now);
  return noted;
}

AuditLog::Rank AuditLog::rank_of(const Key& key, const Finding& finding) {
  return {is_rest(key), finding.dropped + finding.would_drop, finding.last_unix_s, &key};
}

std::pair<const AuditLog::Key, AuditLog::Finding>& AuditLog::unranked(const Key& key) {
  const auto [known, fresh] = findings_.try_emplace(key);
  if (!fresh) ranks_.erase(rank_of(known->first, known->second));
  return *known;
}

void AuditLog::rank(const std::pair<const Key, Finding>& of) {
  ranks_.insert(rank_of(of.first, of.second));
}

void AuditLog::note(const Key& key, const News& news) {
  const std::uint64_t now = clock_.monotonic_ns();
  const std::uint64_t unix_s = clock_.unix_ns() / 1'000'000'000;
  if (!findings_.contains(key)) make_room();
  auto& of = unranked(key);
  Finding& f = of.second;
  if (f.first_unix_s == 0) f.first_unix_s = unix_s;
  f.last_unix_s = unix_s;
  (news.fate == Fate::dropped ? f.dropped : f.would_drop) += news.frames;
  rank(of);
  f.length = std::max(f.length, news.length);
  std::uint64_t gap = 0;
  if (news.frames > 1) gap = news.span / news.frames;
  if (news.frames == 1 && f.noted != 0 && !key.others) gap = now - f.noted;
  if (gap != 0 && (f.busy_gap == 0 || gap < f.busy_gap)) f.busy_gap = gap;
  f.noted = now;
  if (news.fate == Fate::passed) clean_since_ = now;
  has_news_ = true;
}

void AuditLog::make_room() {
  while (findings_.size() >= kMost) {
    const auto removed = findings_.extract(*ranks_.begin()->key);
    ranks_.erase(ranks_.begin());
    ++left_out_;
    if (!is_rest(removed.key())) add_to_others(removed.key(), removed.mapped());
  }
}

/// Adds the frames of a finding that was removed to those that belong to no finding of a kind.
void AuditLog::add_to_others(const Key& key, const Finding& removed) {
  auto& of = unranked(
      {.interface = key.interface, .network = key.network, .reason = key.reason, .others = true});
  Finding& f = of.second;
  f.dropped += removed.dropped;
  f.would_drop += removed.would_drop;
  if (f.first_unix_s == 0) f.first_unix_s = removed.first_unix_s;
  f.first_unix_s = std::min(f.first_unix_s, removed.first_unix_s);
  f.last_unix_s = std::max(f.last_unix_s, removed.last_unix_s);
  rank(of);
}

// --- what was found ------------------------------------------------------------------------------

control::Audit AuditLog::contents() const {
  control::Audit out;
  out.since_unix_s = since_unix_s_;
  out.left_out = left_out_;
  out.findings.reserve(findings_.size());
  for (const auto& [key, f] : findings_)
    out.findings.push_back({.interface = key.interface,
                            .network = key.network,
                            .egress = key.egress,
                            .reason = key.reason,
                            .dropped = f.dropped,
                            .would_drop = f.would_drop,
                            .first_unix_s = f.first_unix_s,
                            .last_unix_s = f.last_unix_s,
                            .busy_gap_ns = f.busy_gap,
                            .channel = key.channel,
                            .publisher = key.publisher,
                            .to = key.to,
                            .can_id = key.can_id,
                            .length = f.length,
                            .fd = key.format == GATE_FD,
                            .xl = key.format == GATE_XL,
                            .subject = key.subject,
                            .address = key.address,
                            .mac = key.mac,
                            .described = key.described,
                            .others = key.others,
                            .user = key.user,
                            .entered_by = key.entered_by});
  std::ranges::stable_sort(out.findings, std::ranges::greater{}, [](const control::Finding& f) {
    return std::pair(f.dropped + f.would_drop, f.last_unix_s);
  });
  mark_lower_bounds(out.findings);
  return out;
}

namespace {

/// The port that the finding is about; nullopt if it is no longer there.
std::optional<std::size_t> port_of(const GateReader& gates, const control::Finding& f) {
  for (std::size_t port = 0; port < gates.size(); ++port)
    if (gates.interface_name(port) == f.interface && gates.network_of(port) == f.network)
      return port;
  return std::nullopt;
}

/// Adds to a finding about frames of no delivery what the description has for them. False if the
/// gateway has rules for such frames by now.
bool complete_frames(std::size_t port, const AuditRules& rules, AuditNames& names,
                     control::Finding& f) {
  const StatedReason stated = stated_reason(f.reason);
  const bool is_unknown = stated.reason == FrameReason::unknown;
  if (!f.entered_by.empty()) f.entered_network = names.network_of(f.entered_by);
  if (!is_about_frames(stated)) {
    if (f.can_id != 0 || f.subject != 0) f.described = names.channel_of(f);
    return true;
  }
  if (is_unknown ? rules.has(port, f) : rules.has_from_sender(port, f)) return false;
  const bool has_identifier = stated.reason == FrameReason::identifier;
  if (is_unknown || !names.has_channel(f.described) || (has_identifier && names.has_number(f)))
    f.described = names.channel_of(f);
  if (has_identifier) names.compare(port, f);
  f.provided_period_ns = names.provided_period(f);
  return true;
}

}  // namespace

control::Audit AuditLog::report() const {
  const core::State& state = *scene_.state;
  control::Audit out = contents();
  out.gateway = state.system().gateways[scene_.self].name;
  const AuditRules rules(scene_, gates_);
  AuditNames names(scene_, gates_);
  std::erase_if(out.findings, [&](control::Finding& f) {
    const auto port = port_of(gates_, f);
    if (!port) return true;
    f.profile = core::to_text(gates_.profile(*port));
    if (!f.channel.empty()) return !complete_delivery(state, f);
    return !f.others && !complete_frames(*port, rules, names, f);
  });
  return out;
}

}  // namespace mlcca
