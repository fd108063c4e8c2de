// SPDX-License-Identifier: BSD-2-Clause
// An admission that takes something of shared networks: it is answered when the store has decided.
// Other requests continue meanwhile.
#include <fmt/core.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "core/cluster/footprint.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/report_size.hpp"
#include "daemon/gateway/requests/admitting.hpp"
#include "daemon/gateway/requests/elsewhere.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/gateway/turn.hpp"

namespace mlcca::requests {
namespace {

/// One waiting admission. Its request is interpreted again each time it is decided, because the
/// description may have changed.
class Waiting : public std::enable_shared_from_this<Waiting> {
 public:
  /// Who decides about it: this gateway, or the one that has its publisher.
  enum class Decides : std::uint8_t { here, elsewhere };
  Waiting(const AdmitParts& parts, Asker asker, control::Admit request, Decides decides)
      : parts_(parts),
        asker_(std::move(asker)),
        request_(std::move(request)),
        id_(parts.recorder.set_id_aside()),
        actor_(parts.log.actor()),
        decides_(decides) {}

  [[nodiscard]] Reserving::Job job() {
    const auto self = shared_from_this();
    return {.decide = [self] { return self->acting([&] { return self->decide(); }); },
            .granted = [self] { return self->acting([&] { return self->put_in_force(); }); },
            .refused =
                [self](const Reserving::Refusal& why) {
                  self->acting([&] { return self->refuse(why); });
                },
            .session = request_.hold ? asker_.peer.session : 0,
            .key = request_.key,
            .user = asker_.peer.uid};
  }

  [[nodiscard]] std::optional<serve::Slice> slice() const {
    if (!is_answered_) return std::nullopt;
    serve::Slice out{*body_};
    out.owned = owned_;
    return out;
  }

 private:
  /// Runs `call` in the name and at the cost of the client that has asked.
  template <class Call>
  std::invoke_result_t<const Call&> acting(const Call& call) {
    const EventLog::Acting request(parts_.log, actor_);
    if (request_.unlisted) parts_.tags.claim();
    auto result = call();
    if (request_.unlisted) parts_.tags.leave_unused();
    parts_.membership->charge(asker_.peer.uid, request.rows());
    return result;
  }

  [[nodiscard]] std::optional<ParsedRequest> understood() {
    const control::Admit request =
        decides_ == Decides::here ? request_ : subscriber_alone(request_, *id_);
    if (const auto listed = list(*parts_.scene.state, request_); !listed) {
      answer(invalid(listed.error().text));
      return std::nullopt;
    }
    auto asked = understand(*parts_.scene.state, request, *id_);
    if (!asked || !asked->admission) {
      answer(invalid(asked ? "these ends are described meanwhile" : asked.error().text));
      return std::nullopt;
    }
    // Others may have been admitted meanwhile.
    if (const auto why = bars(parts_, asker_, request_, *asked)) {
      answer(*why);
      return std::nullopt;
    }
    return std::move(*asked);
  }

  /// Decides with what is reserved, and what others hold, at this time.
  std::optional<Reserving::Wish> decide() {
    const auto asked = understood();
    if (!asked) return std::nullopt;
    if (decides_ == Decides::elsewhere) return wish_of_another(*asked);
    core::State& state = *parts_.scene.state;
    {
      core::Proposal proposal = state.propose(*asked->admission);
      if (proposal.fit() && !crosses_others(parts_.scene, proposal)) {
        answer(decided(parts_, asker_, request_, *asked, std::move(proposal)));
        return std::nullopt;
      }
    }
    std::optional<core::Proposal> wish(state.wish(*asked->admission));
    if (!wish->fit()) {
      answer(decided(parts_, asker_, request_, *asked, std::move(*wish)));
      return std::nullopt;
    }
    auto footprint =
        core::cluster::footprint_of(*wish, parts_.membership->baseline(), parts_.scene.self);
    if (footprint.parts.empty() && footprint.gateways.empty()) {
      answer(
          failed("nothing was changed: the description promises what it needs, and that is closed "
                 "now: " +
                 parts_.membership->why_closed()));
      return std::nullopt;
    }
    note_deliveries(*wish);
    const auto& channel = state.system().channels[asked->channel];
    cluster::StoredRequest for_others{.channel = channel.name,
                                      .requests = {{.id = *id_, .body = request_}}};
    parts_.membership->add_subscribers(*wish, for_others);
    parts_.membership->add_publishers(footprint, for_others);
    return Reserving::Wish{.footprint = std::move(footprint),
                           .publisher = request_.publisher,
                           .asked = std::move(for_others)};
  }

  std::optional<Reserving::Wish> wish_of_another(const ParsedRequest& asked) {
    const auto gateway =
        gateway_to_ask(parts_.scene, parts_.recorder, parts_.membership, request_, asked);
    if (!gateway) {
      answer(failed("nothing was changed: its publisher is not at another gateway any more"));
      return std::nullopt;
    }
    const core::System& system = parts_.scene.state->system();
    through_ = system.gateways[*gateway].name;
    deliveries_.channels = {delivery_elsewhere(system.channels[asked.channel])};
    return wish_elsewhere(system.channels[asked.channel].name, {.id = *id_, .body = request_},
                          *gateway);
  }

  void note_deliveries(const core::Proposal& wish) {
    const core::State& state = *parts_.scene.state;
    auto verdicts = wish.verdicts();
    deliveries_ = {};
    deliveries_.left_out = leave_out(state, verdicts);
    for (const core::Verdict* v : verdicts)
      deliveries_.channels.push_back(delivery_report(state, *v));
  }

  /// The delivery of a publisher that this gateway does not know.
  [[nodiscard]] control::Channel delivery_elsewhere(const core::EventChannel& channel) const {
    control::Channel out = described_row(channel);
    out.publisher = request_.publisher;
    out.from = request_.from;
    out.to = request_.to;
    if (!request_.subscriber.empty()) out.subscribers = {request_.subscriber};
    return out;
  }

  /// A refusal by another gateway is a decision. Everything else, such as a store that does not
  /// answer, is an error of the surroundings.
  bool refuse(const Reserving::Refusal& why) {
    const core::System& system = parts_.scene.state->system();
    if (!why.gateway || deliveries_.channels.empty()) {
      answer(failed("nothing was changed: " + why.why));
      return false;
    }
    const control::RefusedBy by{.gateway = system.gateways[*why.gateway].name,
                                .hop = why.hop ? core::name_of(system, *why.hop) : std::string()};
    for (control::Channel& one : deliveries_.channels) {
      one.reason = why.why;
      one.refused_by = by;
      parts_.log.write(
          {.kind = Kind::refused,
           .priority = 4,
           .message = fmt::format(
               "{} ({}) refused from {} to {}: {}", one.name, core::format_subject(one.subject),
               one.from.empty() ? "the place of its publisher" : one.from, one.to, why.why),
           .subject = one.subject,
           .channel = one.name,
           .network = one.to,
           .from = one.from,
           .publisher = one.publisher});
    }
    answer(std::exchange(deliveries_, {}));
    return false;
  }

  bool put_in_force() {
    const auto asked = understood();
    if (!asked) return false;
    Response response = decided(parts_, asker_, request_, *asked,
                                parts_.scene.state->propose(*asked->admission), through_);
    const bool granted = response.held;
    answer(std::move(response));
    return granted;
  }

  void answer(Response response) {
    body_ = std::move(response.body);
    owned_ = response.owned;
    if (!response.held) {
      finish();
      return;
    }
    parts_.membership->after_commit([self = shared_from_this()](const Result<void>& done) {
      if (!done) {
        self->body_ = failed("nothing was changed: " + done.error().text);
        self->owned_ = 0;
      }
      self->finish();
    });
  }
  void finish() {
    is_answered_ = true;
    parts_.membership->ready(asker_.peer.session);
  }

  AdmitParts parts_;
  Asker asker_;
  control::Admit request_;
  std::shared_ptr<const core::AdmissionId> id_;
  std::optional<control::Actor> actor_;
  Decides decides_;
  std::string through_;           ///< the gateway that has decided; empty: this one
  control::Channels deliveries_;  ///< what was asked of others, without a verdict
  std::optional<Body> body_;
  core::AdmissionId owned_ = 0;
  bool is_answered_ = false;
};

}  // namespace

namespace {

Response ask_as(const AdmitParts& parts, const Asker& asker, const control::Admit& request,
                Waiting::Decides decides) {
  if (const std::string why = parts.membership->bar(asker.peer.uid); !why.empty())
    return failed("nothing was changed: " + why);
  const auto waiting = std::make_shared<Waiting>(parts, asker, request, decides);
  parts.membership->ask(waiting->job());
  return Response([waiting] { return waiting->slice(); });
}

}  // namespace

Response ask_store(const AdmitParts& parts, const Asker& asker, const control::Admit& request) {
  return ask_as(parts, asker, request, Waiting::Decides::here);
}

Response ask_other_gateway(const AdmitParts& parts, const Asker& asker,
                           const control::Admit& request) {
  return ask_as(parts, asker, request, Waiting::Decides::elsewhere);
}

}  // namespace mlcca::requests
