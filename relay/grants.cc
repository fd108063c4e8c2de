// SPDX-License-Identifier: BSD-2-Clause
#include "relay/grants.hpp"

#include <chrono>
#include <utility>
#include <variant>

namespace mlcca::relay {
namespace {

/// Events come in bursts, so the daemon is asked once after a burst.
constexpr std::chrono::milliseconds kPause(20);
/// If more subjects are to be asked for, all are.
constexpr std::size_t kMostDue = 256;

}  // namespace

Grants::Grants(std::string socket, std::uint32_t user, Handlers handlers)
    : user_(user),
      handlers_(std::move(handlers)),
      link_(std::move(socket), {.connected =
                                    [this] {
                                      all_due_ = true;
                                      ask_next();
                                    },
                                .lost =
                                    [this] {
                                      due_.clear();
                                      asked_ = 0;
                                    },
                                .reply = [this](const auto& reply) { on_reply(reply); },
                                .event = [this](const auto& event) { on_event(event); },
                                .timer = [this] { ask_next(); },
                                .log = handlers_.log}) {
  link_.start();
}

void Grants::ask_all() {
  all_due_ = true;
  if (link_.is_connected() && asked_ == 0) link_.set_timer(kPause);
}

void Grants::ask_next() {
  if (asked_ != 0 || (!all_due_ && due_.empty())) return;
  control::TransfersRequest request{.channel = {}, .user = user_};
  of_subject_.reset();
  if (std::exchange(all_due_, false)) {
    due_.clear();
  } else {
    of_subject_ = *due_.begin();
    due_.erase(due_.begin());
    constexpr std::size_t digits = 16;
    std::string text(digits, '0');
    std::uint64_t rest = *of_subject_;
    for (auto digit = text.rbegin(); digit != text.rend(); ++digit, rest >>= 4U)
      *digit = "0123456789abcdef"[rest & 0xfU];
    request.channel = "0x" + text;
  }
  asked_ = link_.send({0, std::move(request), true});
}

void Grants::report(control::DelayRequest delay) {
  if (!link_.is_connected() || !has_answer_ || link_.unsent() > DaemonLink::kMostUnsent) return;
  link_.send({0, std::move(delay)});
  link_.flush();
}

void Grants::on_reply(const control::Reply& reply) {
  if (reply.id != asked_) return;  // reply to the monitor or to a report of delays
  asked_ = 0;
  link_.is_well();
  if (const auto* transfers = std::get_if<control::Transfers>(&reply.body)) {
    if (of_subject_)
      handlers_.of_subject(*of_subject_, transfers->transfers);
    else
      handlers_.all(transfers->transfers);
    has_answer_ = true;
  } else if (of_subject_) {
    handlers_.of_subject(*of_subject_, {});  // the channel does not exist any more
  } else {
    all_due_ = true;  // it was reloaded in between, or is overloaded
  }
  if (all_due_ || !due_.empty()) link_.set_timer(kPause);
}

void Grants::on_event(const control::Event& event) {
  const Affects affected = affected_by(event);
  if (affected == Affects::nothing) return;
  if (affected == Affects::all)
    all_due_ = true;
  else
    due_.insert(event.subject);
  if (due_.size() > kMostDue) all_due_ = true;
  if (asked_ == 0) link_.set_timer(kPause);
}

}  // namespace mlcca::relay
