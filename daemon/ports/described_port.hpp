// SPDX-License-Identifier: BSD-2-Clause
// A port of the description: which interface it is at present, and whether it can be used.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/admission/admission.hpp"
#include "core/model/system.hpp"
#include "core/profiles/profile.hpp"
#include "daemon/net/identity.hpp"
#include "daemon/net/links.hpp"
#include "daemon/ports/report_line.hpp"

namespace mlcca {

/// Finds the interface by the identity of the port, keeps its queue, and judges whether the port
/// can be used.
class DescribedPort {
 public:
  DescribedPort(const core::System& system, const core::Port& port);
  /// Whether `former` is the same port in an earlier description, so that its interface can be
  /// taken over.
  [[nodiscard]] bool is_same(const DescribedPort& former) const;
  void take_over(const DescribedPort& former);

  [[nodiscard]] const core::Port& described() const { return port_; }
  [[nodiscard]] const std::string& network() const { return network_; }
  [[nodiscard]] core::NetworkKind kind() const { return kind_; }
  [[nodiscard]] bool is_can() const { return kind_ == core::NetworkKind::can; }
  [[nodiscard]] core::Profile profile() const { return profile_; }
  [[nodiscard]] bool needs_gate() const { return core::names_channels(profile_); }
  /// Whether a kind of gate exists that the port needs for this interface.
  [[nodiscard]] bool can_have_gate(const net::Link& link) const;

  /// 0 if the interface is not there.
  [[nodiscard]] int ifindex() const { return ifindex_; }
  /// The entry of the interface in `links`; nullptr if it is not listed.
  [[nodiscard]] const net::Link* link(const net::InterfaceTable& links) const;
  /// Why there is no gate for this interface, for example "eth0 has no Ethernet frames, …".
  [[nodiscard]] std::string lacks_framing(const net::Link& link) const;
  /// The present name of the interface, or else the property by which it is recognised.
  [[nodiscard]] std::string interface_name(const net::InterfaceTable& links) const;
  /// Why the port cannot be used; empty if it can.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  void set_problem(std::string problem) { problem_ = std::move(problem); }
  /// Writes into the condition of its network whether it can be used, and its timing.
  void state_in(core::Condition& network, const net::InterfaceTable& links) const;

  // After a change of interfaces: match(), then the gate, then raise() and assess().

  /// Finds the interface. If it is another one than before, returns the former index (0: there was
  /// none). Then both interfaces may hold grants of another port.
  [[nodiscard]] std::optional<int> match(const net::InterfaceTable& links,
                                         const net::FactsOf& facts_of);
  void report_match(const net::InterfaceTable& links, const ReportLine& report) const;
  /// Whether the interface is described as managed, and was not brought up since it appeared.
  [[nodiscard]] bool is_to_be_raised() const { return port_.managed && !raised_; }
  /// Sets the bit rates and brings the interface up. True if that changed it.
  bool raise(net::Links& links, const ReportLine& report);
  /// Sets up the queue, and judges whether the port can be used with the interface as it is.
  void assess(const net::InterfaceTable& links, const ReportLine& report);
  /// Puts back a queue that another program has replaced, because the analysis assumes it.
  void keep_queue(const net::InterfaceTable& links, const ReportLine& report);
  /// Whether it has a queue that is to be put back.
  [[nodiscard]] bool lacks_queue() const;

  /// Whether the interface differs, or may differ, from what assess() has seen. The identity of the
  /// port decides, not the content of a notification, so nothing is missed if notifications were
  /// lost.
  [[nodiscard]] bool is_outdated(const net::InterfaceTable& links,
                                 const net::FactsOf& facts_of) const;

 private:
  void judge(const net::Link& link);
  void report_can_state(const net::Link& link, const ReportLine& report);
  [[nodiscard]] bool is_gated_can() const { return is_can() && needs_gate(); }

  core::Port port_;
  std::string network_;
  core::NetworkKind kind_;
  core::Profile profile_;
  std::uint32_t network_bitrate_;  ///< as described, bit/s
  int ifindex_ = 0;
  std::string problem_;
  bool raised_ = false;
  std::optional<net::Link> assessed_;  ///< the interface as assess() has judged it
  bool reassess_ = false;              ///< the problem may be gone the next time
  std::string can_state_;              ///< as last reported
};

/// The ports of one gateway, in the order of the description.
[[nodiscard]] std::vector<DescribedPort> ports_of(const core::System& system, std::size_t gateway);

}  // namespace mlcca
