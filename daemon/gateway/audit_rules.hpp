// SPDX-License-Identifier: BSD-2-Clause
// What a gateway has rules for now, which is why the audit report leaves findings out, and what the
// description says about the senders of the others.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <unordered_map>

#include "control/messages.hpp"
#include "core/gates/plan.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/port_facts.hpp"

namespace mlcca {

/// Stands in control::Finding::entered_by for frames that the kernel itself has sent.
inline constexpr const char* kFromKernel = "kernel";

/// The frames for which this gateway has rules.
class AuditRules {
 public:
  AuditRules(const Scene& scene, const PortFacts& gates);

  /// Whether a rule is for such frames, whoever sends them.
  [[nodiscard]] bool has(std::size_t port, const control::Finding& frame) const;
  /// Whether a rule is for such frames of their sender.
  [[nodiscard]] bool has_from_sender(std::size_t port, const control::Finding& frame) const;

 private:
  using Gate = std::tuple<std::size_t, bool, std::uint32_t>;  // last: mask of a CAN frame
  /// Whose frames a rule is for.
  struct Sender {
    core::Station station;
    std::optional<std::size_t> source_port;
    std::uint32_t uid = 0;
    bool from_kernel = false;
  };
  using Senders = std::unordered_multimap<std::uint64_t, Sender>;  // by identifier or subject

  void add(const core::GateState& rules);
  bool any(std::size_t port, const control::Finding& frame, auto&& is_meant) const;
  [[nodiscard]] bool is_of(const Sender& sender, const control::Finding& frame) const;

  const PortFacts& gates_;
  std::map<Gate, Senders> by_gate_;  ///< Ethernet: mask 0
};

/// The channels and publishers of the description, by what frames and findings have of them.
class AuditNames {
 public:
  /// Both references must outlive this object.
  AuditNames(const Scene& scene, const PortFacts& gates) : scene_(scene), gates_(gates) {}

  /// The name of the channel that the description has for a frame without a rule, whoever sends it;
  /// empty if there is none.
  std::string channel_of(const control::Finding& frame);
  [[nodiscard]] bool has_channel(const std::string& name);
  /// The network of an interface by which a frame came in; empty if it is none of the gateway's.
  [[nodiscard]] std::string network_of(const std::string& interface) const;
  /// Whether the description states the number of frame.described on the network of the frame, so
  /// that frames with other numbers are none of that channel.
  [[nodiscard]] bool has_number(const control::Finding& frame);
  /// Fills in the publisher of frame.described that is at the place of the sender and has its node
  /// number, and in what the frame differs from it; empties both if there is none.
  void compare(std::size_t port, control::Finding& frame);
  /// The shortest Period in ns that the networks of the frame and this gateway state to provide; 0
  /// if none does.
  [[nodiscard]] std::uint64_t provided_period(const control::Finding& frame) const;

 private:
  /// Channels by identifier, for each mask that frames are compared with.
  using Identifiers = std::map<std::uint32_t, std::unordered_map<std::uint32_t, std::size_t>>;

  std::optional<std::size_t> channel_named(const std::string& name);
  [[nodiscard]] const core::Network* network_named(const std::string& name) const;
  const Identifiers& identifiers_of(const std::string& network);
  [[nodiscard]] std::optional<std::uint32_t> difference(std::size_t port, std::size_t channel,
                                                        std::size_t publisher,
                                                        const control::Finding& frame) const;

  const Scene& scene_;
  const PortFacts& gates_;
  std::map<std::string, Identifiers> by_network_;  ///< filled for the networks that were asked for
  std::unordered_map<std::string, std::size_t> channels_;  ///< by name; filled when it is needed
};

}  // namespace mlcca
