// SPDX-License-Identifier: BSD-2-Clause
// A port of the description: which interface it is now, and whether it can be used.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/admission/admission.hpp"
#include "core/model/system.hpp"
#include "daemon/net/identity.hpp"
#include "daemon/net/links.hpp"
#include "daemon/ports/report_line.hpp"

namespace mlcca {

class DescribedPort {
 public:
  DescribedPort(const core::System& system, const core::Port& port);
  /// It was described before, as another of these: it still is the interface that it was.
  [[nodiscard]] bool is_same(const DescribedPort& former) const;
  void take_over(const DescribedPort& former);

  [[nodiscard]] const core::Port& described() const { return port_; }
  [[nodiscard]] const std::string& network() const { return network_; }
  [[nodiscard]] core::NetworkKind kind() const { return kind_; }
  [[nodiscard]] bool is_can() const { return kind_ == core::NetworkKind::can; }
  [[nodiscard]] core::Profile profile() const { return profile_; }
  [[nodiscard]] bool needs_gate() const { return profile_ != core::Profile::none; }
  /// There is a gate that it needs for interfaces of this kind.
  [[nodiscard]] bool can_have_gate(const net::Link& link) const;

  /// 0: the interface is not there.
  [[nodiscard]] int ifindex() const { return ifindex_; }
  /// As it is listed; none: it is not.
  [[nodiscard]] const net::Link* link(const net::LinkTable& links) const;
  /// "eth0 has no Ethernet frames, …": why there is none for this interface.
  [[nodiscard]] std::string lacks_framing(const net::Link& link) const;
  /// Name of the interface now, or what it is recognised by.
  [[nodiscard]] std::string interface_name(const net::LinkTable& links) const;
  /// Why it cannot be used; empty: it can.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  void set_problem(std::string problem) { problem_ = std::move(problem); }
  /// Says whether its network can be used, and by which timing.
  void state_in(core::Condition& network, const net::LinkTable& links) const;

  // Whenever interfaces have changed: match(), then its gate, then raise() and settle().

  /// Looks for the interface. Gives the one that it was before where that is another one, 0: none.
  /// Both may hold what was granted to another port.
  [[nodiscard]] std::optional<int> match(const net::LinkTable& links, const net::FactsOf& facts_of);
  void report_match(const net::LinkTable& links, const ReportLine& report) const;
  /// Its interface is described as managed, and was not brought up since it appeared.
  [[nodiscard]] bool is_to_be_raised() const { return port_.managed && !raised_; }
  /// Sets bit rates and brings it up. True if that changed the interface.
  bool raise(net::Links& links, const ReportLine& report);
  /// Its queue, and whether it can be used as the interface is now.
  void settle(const net::LinkTable& links, const ReportLine& report);
  /// As the analysis assumes it: a queue that another program replaced is put back.
  void keep_queue(const net::LinkTable& links, const ReportLine& report);
  /// It has a queue to be put back.
  [[nodiscard]] bool lacks_queue() const;

  /// It differs from what settle() has seen, or that may be. The identity of the port decides, not
  /// the content of a notification: so nothing is missed where some were lost.
  [[nodiscard]] bool is_outdated(const net::LinkTable& links, const net::FactsOf& facts_of) const;

 private:
  void judge(const net::Link& link);
  void report_can_state(const net::Link& link, const ReportLine& report);
  [[nodiscard]] bool is_gated_can() const { return is_can() && needs_gate(); }

  core::Port port_;
  std::string network_;
  core::NetworkKind kind_;
  core::Profile profile_;
  std::uint32_t network_bitrate_;  ///< as described
  int ifindex_ = 0;
  std::string problem_;
  bool raised_ = false;
  std::optional<net::Link> settled_;  ///< the interface as settle() has judged it
  bool unsettled_ = false;            ///< what is wrong may be otherwise the next time
  std::string can_state_;             ///< as last reported
};

/// Those of one gateway, in the order of the description.
[[nodiscard]] std::vector<DescribedPort> ports_of(const core::System& system, std::size_t gateway);

}  // namespace mlcca
