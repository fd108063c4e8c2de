// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/recorder.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "base/number.hpp"
#include "core/model/progress.hpp"
#include "core/model/text.hpp"
#include "daemon/store/records.hpp"

namespace mlcca {

Result<void> Recorder::open(const std::string& directory, store::Disk& disk) {
  auto opened = patience_.wait_for([&] { return store::Journal::open(directory, disk); });
  if (!opened) return std::unexpected(opened.error());
  journal_.emplace(std::move(*opened));
  return {};
}

Recorder::Granted Recorder::granted() const {
  Granted all;
  for (const auto& [subject, record] : contents().granted)
    if (auto grants = store::grants_in(record)) all.emplace(subject, std::move(*grants));
  return all;
}

// --- what clients ask for ------------------------------------------------------------------------

Result<void> Recorder::admit(const control::Request& request, std::uint32_t user,
                             const std::string& through) {
  auto done = journal_->append(store::Admitted{request, user, through});
  if (done) uncommitted_.push_back(request.id);
  return done;
}

std::shared_ptr<const core::AdmissionId> Recorder::set_id_aside() {
  return journal_->expect(new_id());
}

core::AdmissionId Recorder::new_id() {
  const core::AdmissionId id = next_id();
  beyond_aside_ = id + 1;
  append(store::NextId{beyond_aside_});
  return id;
}

void Recorder::pass_over(core::AdmissionId id) {
  if (id < next_id()) return;
  beyond_aside_ = id + 1;
  append(store::NextId{beyond_aside_});
}

void Recorder::take_back(core::AdmissionId id) {
  std::erase(uncommitted_, id);
  if (contents().admissions.find(id) != nullptr)
    static_cast<void>(journal_->append(store::Removed{id}));
}

bool Recorder::is_uncommitted(core::AdmissionId id) const {
  return std::ranges::find(uncommitted_, id) != uncommitted_.end();
}

Result<void> Recorder::write_at_once(const std::vector<store::Entry>& entries) {
  Result<void> done;
  for (const store::Entry& entry : entries)
    if (done) done = journal_->append(entry);
  if (done && journal_->dirty()) done = patience_.wait_for([this] { return journal_->commit(); });
  if (done) return done;
  journal_->roll_back();
  return fail("nothing was changed: " + done.error().text);
}

// --- what is in force ----------------------------------------------------------------------------

void Recorder::note(std::size_t channel) {
  note_granted(channel);
  append(store::Enforced{
      scene_.state->system().channels[channel].subject,
      store::record_of(gates_.slots(scene_.state->gate_state(scene_.self, channel)))});
}

void Recorder::note_granted(std::size_t channel) {
  append(store::Granted{core::format_subject(scene_.state->system().channels[channel].subject),
                        store::record_of(scene_.state->grants(channel))});
}

void Recorder::note_gone(const std::string& subject) { append(store::Granted{subject, {}}); }

void Recorder::note_ports() {
  auto gone = contents().gated;
  std::vector<store::Gated> changed;
  const auto report = gates_.report();
  for (std::size_t p = 0; p < report.size(); ++p) {
    // A gate that another program has detached will be attached again: the port still has it.
    if (!gates_.is_gated(p)) continue;
    const control::Interface& port = report[p];
    const store::Gated now{port.identity, port.network, port.name, port.ifindex};
    const auto known = gone.extract(port.identity);
    if (known.empty() || known.mapped() != now) changed.push_back(now);
  }
  for (auto& [identity, port] : gone) {
    port.ifindex = 0;
    changed.push_back(std::move(port));
  }
  for (const store::Gated& entry : changed) append(entry);
}

void Recorder::note_contradicted(std::vector<store::Contradicted> all) {
  contradicted_ = std::move(all);
  auto over = contents().contradicted;
  for (const store::Contradicted& now : contradicted_) {
    over.erase({now.network, now.subject});
    append(now);
  }
  for (auto& [key, entry] : over) {
    entry.how.clear();
    append(entry);
  }
}

/// Notes the slots of every subject, and those for the control traffic of profiles.
void Recorder::note_slots(core::GateState of_all) {
  const auto subject_of = [](const core::GateRule& rule) { return rule.entry.subject; };
  std::ranges::stable_sort(of_all, {}, [&](const core::GateRule& rule) {
    core::Progress::step();
    return subject_of(rule);
  });
  std::map<std::uint64_t, std::string> now;
  for (auto first = of_all.begin(); first != of_all.end();) {
    const auto last = std::find_if(first, of_all.end(), [&](const core::GateRule& rule) {
      return subject_of(rule) != subject_of(*first);
    });
    now.emplace_hint(now.end(), subject_of(*first), store::record_of(gates_.slots({first, last})));
    first = last;
    pulse_();
  }
  for (const auto& [subject, slots] : contents().enforced) {
    now.try_emplace(subject);
    core::Progress::step();
  }
  for (auto& [subject, slots] : now) append(store::Enforced{subject, std::move(slots)});
}

/// A batch has a size limit, which a million subjects reach. If no answer waits for the batch, it
/// may be written in several parts.
void Recorder::append(const store::Entry& entry) {
  core::Progress::step();
  auto done = journal_->append(entry);
  if (!done && uncommitted_.empty() && journal_->dirty()) {
    done = patience_.wait_for([this] { return journal_->commit(); });
    if (done) done = journal_->append(entry);
  }
  if (!done) log_.error(Kind::problem, done.error().text);
}

// --- the disk ------------------------------------------------------------------------------------

Result<void> Recorder::commit(
    const std::function<void(const std::vector<core::AdmissionId>&)>& lost) {
  auto done = patience_.wait_for([this] { return journal_->commit(); });
  if (!done) {
    log_.error(Kind::problem, done.error().text);
    lost(uncommitted_);
  }
  if (trouble_.is_new(journal_->trouble().value_or("")))
    log_.warning(Kind::problem, trouble_.text());
  uncommitted_.clear();
  return done;
}

void Recorder::keep() {
  if (!journal_ || journal_->dirty()) return;
  const auto again = patience_.wait_for([this] {
    // The commit that failed has reported what cannot be undone.
    static_cast<void>(journal_->mend());
    return journal_->keep();
  });
  if (gone_.is_new(again ? ""
                         : journal_->path() +
                               " was removed or replaced, and cannot be written again: " +
                               again.error().text))
    log_.error(Kind::problem, gone_.text());
  if (again && *again)
    log_.error(
        Kind::drift,
        journal_->path() +
            ": another program removed or replaced it; it is written again, with all that is "
            "granted");
}

}  // namespace mlcca
