// SPDX-License-Identifier: BSD-2-Clause
// Rules for a gateway without mlccad: of can-gw for forwarding, of em_canid for egress.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <utility>

#include "base/ascii.hpp"
#include "core/gates/plan.hpp"
#include "tools/design/export/admitted.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::size_t kMatchesOfAFilter = 50;  // of at most 500

/// Whether a name needs no quotes in a shell script.
bool is_plain(std::string_view name) {
  return !name.empty() && std::ranges::all_of(name, is_of_interface_name);
}

Result<std::string> interface_of(const core::System& system, const core::Gateway& gateway,
                                 const core::Port& port) {
  if (is_plain(port.identity.name)) return port.identity.name;
  return fail(
      fmt::format("{}: its port on {} does not state the name of its interface: a rule "
                  "needs one (Interface name)",
                  gateway.name, system.networks[port.network].name));
}

std::string head_of(const core::System& system, const core::Gateway& gateway,
                    std::string_view what) {
  return fmt::format(
      "#!/bin/sh\n"
      "# {} of gateway {} in {}, as mlccactl check admits them.\n"
      "# For a gateway without mlccad. Nothing polices, supervises or follows the networks:\n"
      "# export again when the description changes.\n"
      "set -e\n",
      what, gateway.name, system.name);
}

bool is_can(const core::System& system, const core::Port& port) {
  return system.networks[port.network].kind == core::NetworkKind::can;
}

class CanGwWriter {
 public:
  CanGwWriter(const Admitted& admitted, std::size_t gateway)
      : admitted_(admitted),
        system_(admitted.system()),
        number_(gateway),
        gateway_(system_.gateways[gateway]) {}

  Result<Exported> write() {
    out_.text = head_of(system_, gateway_, "can-gw rules");
    for (std::size_t c = 0; c < admitted_.decisions().size(); ++c)
      for (const auto& transit : core::transits(system_, admitted_.members(), c,
                                                admitted_.decisions()[c].verdicts, number_))
        if (auto done = add(c, transit); !done) return std::unexpected(done.error());
    list_not_carried(admitted_, number_, out_.lacks);
    if (rules_.empty()) out_.text += "# Nothing is admitted from one CAN bus to another.\n";
    return std::move(out_);
  }

 private:
  Result<void> add(std::size_t channel, const core::Transit& transit) {
    const auto& in = transit.in;
    const auto& out = transit.out;
    const auto& from = gateway_.ports[in.port];
    const auto& to = gateway_.ports[out.port];
    const auto source = interface_of(system_, gateway_, from);
    if (!source) return std::unexpected(source.error());
    const auto target = interface_of(system_, gateway_, to);
    if (!target) return std::unexpected(target.error());
    const auto& name = system_.channels[channel].name;
    const auto lack = [&](std::string_view why) {
      out_.lacks.add("not-carried", why, 0,
                     fmt::format("{} from {} to {}", name, *source, *target));
    };
    if (((in.mask ^ out.mask) & ~core::kRemoteFlag) != 0) {
      lack("the buses leave different parts of the identifier open, which no rule can say");
      return {};
    }
    if (in.transport || out.transport) {
      lack("long messages of J1939 are of many channels at once: only a gate distinguishes them");
      return {};
    }
    for (const bool fd : {false, true}) {
      if (!(fd ? in.fd && out.fd : in.classic && out.classic)) continue;
      const auto mask = in.mask | out.mask;
      const auto rule =
          fmt::format("cangw -A -s {} -d {} -e {}-f {:X}:{:X}{}", *source, *target, fd ? "-X " : "",
                      in.id & mask, mask, change(in.id, out.id, mask, fd));
      if (rules_.insert(rule).second) out_.text += fmt::format("{} # {}\n", rule, name);
    }
    return {};
  }

  /// The can-gw modification that turns one identifier into another; bits outside of the mask stay.
  static std::string change(std::uint32_t before, std::uint32_t after, std::uint32_t mask,
                            bool fd) {
    if (before == after) return {};
    const std::string data(fd ? 128 : 16, '0');
    const auto one = [&](const char* what, std::uint32_t id) {
      return fd ? fmt::format(" -M {}:I:{:X}.0.0.{}", what, id, data)
                : fmt::format(" -m {}:I:{:X}.0.{}", what, id, data);
    };
    return one("AND", ~mask) + one("OR", after);
  }

  const Admitted& admitted_;
  const core::System& system_;
  std::size_t number_;
  const core::Gateway& gateway_;
  std::set<std::string> rules_;
  Exported out_;
};

std::string matches_of(const std::set<core::FrameIdentity>& identities, std::size_t from) {
  std::string out;
  auto at = std::next(identities.begin(), static_cast<std::ptrdiff_t>(from));
  for (std::size_t n = 0; n < kMatchesOfAFilter && at != identities.end(); ++n, ++at) {
    const bool extended = (at->id & core::kExtendedFlag) != 0;
    const auto bits = extended ? core::kExtendedBits : core::kStandardBits;
    out += fmt::format("{}{} 0x{:x}:0x{:x}", out.empty() ? "" : " ", extended ? "eff" : "sff",
                       at->id & bits, at->mask & bits);
  }
  return out;
}

}  // namespace

Result<Exported> export_can_gw(const Admitted& admitted, std::size_t gateway) {
  return CanGwWriter(admitted, gateway).write();
}

Result<Exported> export_em_canid(const Admitted& admitted, std::size_t number) {
  const auto& system = admitted.system();
  const auto& gateway = system.gateways[number];
  const auto state = core::gate_state(system, admitted.members(), admitted.decisions(), number);
  Exported out;
  out.text = head_of(system, gateway, "Filters (tc, em_canid)") +
             "# What is admitted leaves; all else is dropped, of local programs as well.\n"
             "# Run it before the interfaces are up. Senders, remote frames, lengths and FD are "
             "not distinguished.\n";
  for (std::size_t p = 0; p < gateway.ports.size(); ++p) {
    const auto& port = gateway.ports[p];
    if (!is_can(system, port)) {
      out.lacks.add("other-networks", "are not filtered: em_canid knows CAN alone", 0,
                    system.networks[port.network].name);
      continue;
    }
    const auto name = interface_of(system, gateway, port);
    if (!name) return std::unexpected(name.error());
    std::set<core::FrameIdentity> identities;
    for (const auto& rule : state)
      if (rule.pass && rule.entry.port == p && rule.entry.direction == core::Direction::egress)
        identities.insert({rule.entry.id, rule.entry.mask});
    constexpr unsigned last = 60'000;
    out.text += fmt::format(
        "tc qdisc del dev {0} clsact 2>/dev/null || :\n"
        "tc qdisc add dev {0} clsact\n"
        "tc filter add dev {0} egress pref {1} protocol all matchall action drop\n",
        *name, last);
    unsigned preference = 1;
    for (std::size_t from = 0; from < identities.size(); from += kMatchesOfAFilter)
      out.text += fmt::format(
          "tc filter add dev {} egress pref {} protocol all basic match 'canid({})' action ok\n",
          *name, preference++, matches_of(identities, from));
  }
  list_not_carried(admitted, number, out.lacks);
  return out;
}

}  // namespace mlcca::tools::design
