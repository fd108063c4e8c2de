// SPDX-License-Identifier: BSD-2-Clause
#include "tools/exporter/answers.hpp"

#include <variant>

namespace mlcca::exporter {

Asking::Asking(const std::string& path, std::chrono::milliseconds patience) {
  auto client = control::Client::connect(path, patience);
  if (client)
    client_.emplace(std::move(*client));
  else
    failed("connect", client.error().text);
}

template <class Question, class Answer>
void Asking::ask(const char* request, std::optional<Answer>& to, Question question) {
  // A reload between two slices ends the answer with an error; the second attempt begins after it.
  for (int tries = 2; tries > 0 && client_; --tries) {
    auto reply = client_->call({0, question});
    if (!reply) {
      client_.reset();
      failed(request, reply.error().text);
      return;
    }
    if (auto* answer = std::get_if<Answer>(&reply->body)) {
      to = std::move(*answer);
      return;
    }
    const auto* error = std::get_if<control::Error>(&reply->body);
    if (tries == 1) failed(request, error != nullptr ? error->message : "another answer came");
  }
}

Live Asking::live() {
  Live live;
  ask<control::StatusRequest>("status", live.status);
  ask<control::ChannelsRequest>("channels", live.channels);
  ask<control::ClusterRequest>("cluster", live.cluster);
  return live;
}

Reports Asking::reports() {
  Reports reports;
  ask<control::NetworksRequest>("networks", reports.networks);
  ask<control::ReservationsRequest>("reservations", reports.reservations);
  ask<control::GateRequest>("gate", reports.gates);
  ask<control::RoutesRequest>("routes", reports.routes);
  ask<control::ClusterRequest>("members", reports.members,
                               {.part = "members", .network = {}, .gateway = {}});
  return reports;
}

}  // namespace mlcca::exporter
