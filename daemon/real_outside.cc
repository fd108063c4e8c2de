// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/real_outside.hpp"

#include <memory>
#include <utility>

#include "daemon/net/can_routes.hpp"
#include "daemon/store/disk.hpp"

namespace mlcca {

RealOutside::RealOutside(Options options, SystemLog log, gates::Control control, net::Links links,
                         net::FactsOf facts_of, sd_event* loop)
    : options_(std::move(options)),
      loop_(loop),
      log_(std::move(log)),
      control_(std::move(control)),
      links_(std::move(links)),
      ports_(
          links_, control_.control(), std::move(facts_of),
          [this](const std::string& network, const std::string& line, bool problem) {
            if (problem)
              log_.warning(Kind::interface, line, {.network = network});
            else
              log_.info(Kind::interface, line, {.network = network});
          },
          [this](Kind kind, const std::string& line, bool problem) {
            if (problem)
              log_.error(kind, line);
            else
              log_.notice(kind, line);
          }),
      reading_(loop),
      texts_(options_.state_directory) {}

Result<void> RealOutside::start_cluster() {
  if (!options_.in_cluster) return {};
  cluster_.emplace(loop_,
                   cluster::SocketLink::Options{.socket = options_.cluster_socket, .hello = {}});
  return cluster_->start();
}

Outside RealOutside::outside() {
  return {
      .gates = ports_,
      .control = control_,
      .links = links_,
      .can = can_,
      .clock = clock_,
      .disk = store::real_disk(),
      .reading = reading_,
      .log = log_,
      .read = [options = options_] { return read_description(options); },
      .read_text = [options = options_](
                       const std::string& text) { return read_description_text(options, text); },
      .texts = &texts_,
      .can_rules = std::make_unique<net::KernelCanRules>(),
      .loop = loop_,
      .cluster = cluster_ ? &*cluster_ : nullptr};
}

}  // namespace mlcca
