// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/described_port.hpp"

#include <fmt/core.h>

#include <utility>

#include "bpf/gate.h"
#include "daemon/net/queue.hpp"
#include "daemon/ports/bring_up.hpp"

namespace mlcca {

DescribedPort::DescribedPort(const core::System& system, const core::Port& port)
    : port_(port),
      network_(system.networks[port.network].name),
      kind_(system.networks[port.network].kind),
      profile_(system.networks[port.network].profile),
      network_bitrate_(system.networks[port.network].bus.bitrate) {}

bool DescribedPort::is_same(const DescribedPort& former) const {
  return former.port_.identity == port_.identity && former.network_ == network_;
}

void DescribedPort::take_over(const DescribedPort& former) {
  ifindex_ = former.ifindex_;
  can_state_ = former.can_state_;
  raised_ = former.raised_ && former.port_.bitrate == port_.bitrate &&
            former.port_.data_bitrate == port_.data_bitrate;
}

bool DescribedPort::can_have_gate(const net::Link& link) const {
  if (!needs_gate()) return false;
  if (kind_ == core::NetworkKind::ieee802154) return link.is_wpan;
  return is_can() ? link.is_can : link.is_ethernet;
}

std::string DescribedPort::lacks_framing(const net::Link& link) const {
  if (is_can()) return link.name + " is not a CAN interface";
  if (kind_ == core::NetworkKind::ieee802154)
    return link.name + " is not an interface of IEEE 802.15.4";
  return link.name +
         " has no Ethernet frames, and there is a gate for CAN, Ethernet and IEEE "
         "802.15.4 only";
}

const net::Link* DescribedPort::link(const net::InterfaceTable& links) const {
  const auto it = links.find(ifindex_);
  return it == links.end() ? nullptr : &it->second;
}

std::string DescribedPort::interface_name(const net::InterfaceTable& links) const {
  const net::Link* now = link(links);
  return now != nullptr ? now->name : net::to_text(port_.identity);
}

void DescribedPort::state_in(core::Condition& network, const net::InterfaceTable& links) const {
  network.available = problem_.empty();
  network.problem = problem_;
  if (const net::Link* now = link(links); now != nullptr && now->kind == "can")
    network.timing = {now->bitrate, now->data_bitrate};
}

std::optional<int> DescribedPort::match(const net::InterfaceTable& links,
                                        const net::FactsOf& facts_of) {
  const auto found = net::find_interface(port_.identity, links, facts_of);
  problem_ = found ? "" : found.error().text;
  reassess_ = !found;
  const int now = found && *found ? **found : 0;
  if (now == 0 && problem_.empty())
    problem_ = fmt::format("the interface ({}) is absent", net::to_text(port_.identity));
  if (now == ifindex_) return std::nullopt;
  raised_ = false;
  return std::exchange(ifindex_, now);
}

void DescribedPort::report_match(const net::InterfaceTable& links, const ReportLine& report) const {
  if (ifindex_ != 0)
    report(network_,
           fmt::format("{} is {} ({})", links.at(ifindex_).name, network_,
                       net::to_text(port_.identity)),
           false);
  else
    report(network_, fmt::format("{}: {}", network_, problem_), true);
}

bool DescribedPort::raise(net::Links& links, const ReportLine& report) {
  const net::Link now = *link(links.table());
  if (const auto done = bring_up(now, port_, links); !done) {
    problem_ = fmt::format("{}: {}", now.name, done.error().text);
    report(network_, problem_, true);
    return false;
  }
  raised_ = true;
  return true;
}

void DescribedPort::assess(const net::InterfaceTable& links, const ReportLine& report) {
  const net::Link* const now = link(links);
  assessed_ = now != nullptr ? std::optional(*now) : std::nullopt;
  if (now == nullptr) return;
  keep_queue(links, report);
  reassess_ = !problem_.empty();
  if (!problem_.empty()) return;
  judge(*now);
  report_can_state(*now, report);
}

void DescribedPort::judge(const net::Link& link) {
  if (!link.up)
    problem_ = link.name + " is down";
  else if (link.can_state == "bus-off")
    problem_ = link.name + " is bus-off";
  else if (!link.running)
    problem_ = link.name + " has no carrier: its cable is unplugged, or nobody is at the other end";
  else if (is_gated_can() && link.bitrate == 0 && link.kind == "can")
    problem_ = "the bit rate of " + link.name + " is unknown";
  else if (is_gated_can() && link.bitrate == 0 && network_bitrate_ == 0)
    problem_ = fmt::format("{} has no bit rate of its own: state <Bus bitrate=\"…\"/> of {}",
                           link.name, network_);
}

/// Error-active is the normal state. Bus-off is reported with the withdrawals that it causes.
void DescribedPort::report_can_state(const net::Link& link, const ReportLine& report) {
  const bool warns = link.can_state == "error-warning" || link.can_state == "error-passive";
  const std::string now = warns ? link.can_state : "";
  if (std::exchange(can_state_, now) == now) return;
  report(network_,
         warns ? fmt::format("{} is {}: frames on {} are being disturbed", link.name, now, network_)
               : fmt::format("{} is {} again", link.name,
                             link.can_state.empty() ? "in order" : link.can_state),
         warns);
}

void DescribedPort::keep_queue(const net::InterfaceTable& links, const ReportLine& report) {
  const net::Link* const now = link(links);
  if (port_.queueing != core::Queueing::priority || !is_gated_can() || !problem_.empty() ||
      now == nullptr)
    return;
  const auto kept = net::keep_priority_queue(ifindex_);
  if (!kept)
    problem_ = fmt::format("{}: {}", now->name, kept.error().text);
  else if (!*kept)
    report(network_, fmt::format("{} queues by priority, in {} bands", now->name, GATE_BANDS),
           false);
}

bool DescribedPort::lacks_queue() const {
  return port_.queueing == core::Queueing::priority && !problem_.empty() && ifindex_ != 0;
}

bool DescribedPort::is_outdated(const net::InterfaceTable& links,
                                const net::FactsOf& facts_of) const {
  if (reassess_) return true;
  const net::Link* const now = link(links);
  if (now == nullptr ? ifindex_ != 0 || assessed_.has_value() : assessed_ != *now) return true;
  const auto found = net::find_interface(port_.identity, links, facts_of);
  return !found || found->value_or(0) != ifindex_;
}

std::vector<DescribedPort> ports_of(const core::System& system, std::size_t gateway) {
  std::vector<DescribedPort> ports;
  for (const core::Port& port : system.gateways[gateway].ports) ports.emplace_back(system, port);
  return ports;
}

}  // namespace mlcca
