// SPDX-License-Identifier: BSD-2-Clause
// What the gateway writes down: grants, ports and slots, and when that is on disk.
#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "core/gates/control_traffic.hpp"
#include "core/model/text.hpp"
#include "daemon/gates/slot_record.hpp"
#include "daemon/gateway/gateway.hpp"

namespace mlcca {
namespace {

// The journal's words for what is granted: "set=0 camera#0>control player#7>laptop": the attribute
// set, then publisher, its admission and the place of each delivery.
constexpr std::string_view kSet = "set=";

std::string text_of(const core::Grants& grants) {
  if (grants.deliveries.empty()) return {};
  std::string text = std::string(kSet) + std::to_string(grants.set);
  for (const core::Delivery& d : grants.deliveries)
    text += fmt::format(" {}#{}>{}", d.publisher, d.admission, d.to);
  return text;
}

template <class Number>
std::optional<Number> number_in(std::string_view text) {
  Number number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc{} || read.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

/// Nothing for words that are not ours. Neither names of places nor numbers have a # or a >.
std::optional<core::Grants> grants_of(std::string_view text) {
  if (!text.starts_with(kSet)) return std::nullopt;
  core::Grants grants;
  bool first = true;
  while (!text.empty()) {
    const auto blank = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, blank);
    text.remove_prefix(std::min(blank + 1, text.size()));
    if (std::exchange(first, false)) {
      const auto set = number_in<std::size_t>(word.substr(kSet.size()));
      if (!set) return std::nullopt;
      grants.set = *set;
      continue;
    }
    const auto to = word.rfind('>');
    const auto id = to == std::string_view::npos ? to : word.rfind('#', to);
    if (id == std::string_view::npos) return std::nullopt;
    const auto admission = number_in<core::AdmissionId>(word.substr(id + 1, to - id - 1));
    if (!admission) return std::nullopt;
    grants.deliveries.push_back(
        {std::string(word.substr(0, id)), *admission, std::string(word.substr(to + 1))});
  }
  return grants;
}

}  // namespace

Gateway::Granted Gateway::granted() const {
  Granted all;
  for (const auto& [subject, text] : stored().granted)
    if (auto grants = grants_of(text)) all.emplace(subject, std::move(*grants));
  return all;
}

void Gateway::note(std::size_t channel) {
  note_granted(channel);
  write_down(store::Enforced{
      scene_.state->system().channels[channel].subject,
      enforce::record_of(ports_.slots(scene_.state->gate_state(scene_.self, channel)))});
}

void Gateway::note_granted(std::size_t channel) {
  note_granted(core::format_subject(scene_.state->system().channels[channel].subject),
               text_of(scene_.state->grants(channel)));
}

void Gateway::note_granted(const std::string& subject, const std::string& text) {
  write_down(store::Granted{subject, text});
}

/// For whoever reads back what is in force without this daemon.
void Gateway::note_ports() {
  auto gone = stored().gated;
  std::vector<store::Gated> news;
  const auto report = ports_.report();
  for (std::size_t p = 0; p < report.size(); ++p) {
    // A gate that somebody has detached is put back: it is the port's as before.
    if (ports_.gate(p) == nullptr) continue;
    const control::Interface& port = report[p];
    const store::Gated now{port.identity, port.network, port.name, port.ifindex};
    const auto known = gone.extract(port.identity);
    if (known.empty() || known.mapped() != now) news.push_back(now);
  }
  for (auto& [identity, port] : gone) {
    port.ifindex = 0;
    news.push_back(std::move(port));
  }
  for (const store::Gated& entry : news) write_down(entry);
}

/// For the same reader: of every subject, and of what a profile needs beside events.
void Gateway::note_slots(core::GateState of_all) {
  const auto subject_of = [](const core::GateRule& rule) { return rule.entry.subject; };
  std::ranges::stable_sort(of_all, {}, subject_of);
  std::map<std::uint64_t, std::string> now;
  for (auto first = of_all.begin(); first != of_all.end();) {
    const auto last = std::find_if(first, of_all.end(), [&](const core::GateRule& rule) {
      return subject_of(rule) != subject_of(*first);
    });
    now.emplace_hint(now.end(), subject_of(*first),
                     enforce::record_of(ports_.slots({first, last})));
    first = last;
    pulse();
  }
  for (const auto& [subject, slots] : stored().enforced) now.try_emplace(subject);
  for (auto& [subject, slots] : now) write_down(store::Enforced{subject, std::move(slots)});
}

/// A batch has a limit, which a million subjects reach: where nobody waits for an answer there may
/// be several.
void Gateway::write_down(const store::Entry& entry) {
  auto done = store_->append(entry);
  if (!done && uncommitted_.empty() && store_->dirty()) {
    done = patience_.wait_for([this] { return store_->commit(); });
    if (done) done = store_->append(entry);
  }
  if (!done) log_.error(Kind::trouble, done.error().text);
}

void Gateway::commit() {
  if (!store_ || !store_->dirty()) return;
  // What is not on disk now was asked for by others before.
  const EventLog::Acting nobody(log_, std::nullopt);
  const Result<void> done = patience_.wait_for([this] { return store_->commit(); });
  if (!done) {
    log_.error(Kind::trouble, done.error().text);
    take_back_uncommitted();
  }
  if (journal_trouble_.is_new(store_->trouble().value_or("")))
    log_.warning(Kind::trouble, journal_trouble_.text());
  uncommitted_.clear();
  if (committed_) committed_(done);
  if (done) return;
  // What is in force was to be written down, too: the next commit tries it again.
  for (std::size_t c = 0; c < scene_.state->decisions().size(); ++c) note_granted(c);
  note_ports();
  auto wanted = scene_.state->gate_state(scene_.self);
  std::ranges::copy(core::control_rules(scene_.state->system(), scene_.self, ::geteuid()),
                    std::back_inserter(wanted));
  note_slots(std::move(wanted));
}

/// What a daemon has granted must outlive it, also when somebody removes the file meanwhile.
void Gateway::keep_journal() {
  if (!store_ || store_->dirty()) return;
  const auto again = patience_.wait_for([this] { return store_->keep(); });
  if (journal_gone_.is_new(again ? ""
                                 : store_->path() +
                                       " was removed or replaced, and cannot be written anew: " +
                                       again.error().text))
    log_.error(Kind::trouble, journal_gone_.text());
  if (again && *again)
    log_.error(Kind::drift,
               store_->path() +
                   ": somebody removed or replaced it; it is written anew, with all that is "
                   "granted");
}

/// After a start or a reload; what has no place in the description, too.
void Gateway::report_outcome(const Granted& before, const DeliveryEvents::Reported& reported) {
  for (const auto& [id, why] : left_out_) {
    const auto* request = stored().admissions.find(id);
    const auto* admit = request != nullptr ? std::get_if<control::Admit>(&request->body) : nullptr;
    log_.warning(Kind::trouble, why,
                 {.channel = admit != nullptr ? admit->channel : "", .admissions = {id}});
  }
  deliveries_.outcome(before, reported);
}

/// What could not be written down was never granted.
void Gateway::take_back_uncommitted() {
  for (const core::AdmissionId id : uncommitted_) {
    log_.warning(Kind::withdrawn,
                 fmt::format("admission {} was never granted: it could not be written down", id),
                 {.admissions = {id}});
  }
  static_cast<void>(settle(forget(uncommitted_)));
  leave_unused_tags();
}

}  // namespace mlcca
