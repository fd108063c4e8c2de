// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/interfaces.hpp"

#include <fmt/format.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cerrno>
#include <string_view>
#include <system_error>

#include "base/handle.hpp"
#include "base/number.hpp"
#include "daemon/gates/closed_programs.hpp"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/retire.hpp"

namespace mlcca::gates {

Result<std::vector<std::uint32_t>> pinned_interfaces(const Control& control) {
  constexpr std::string_view prefix = "if";
  std::vector<std::uint32_t> found;
  const auto names = names_in(control.directory());
  if (!names && names.error() != std::errc::no_such_file_or_directory)
    return failure("read " + control.directory(), names.error().value());
  for (const std::string& name : names.value_or(std::vector<std::string>{})) {
    if (!name.starts_with(prefix)) continue;
    if (const auto ifindex = number_in<std::uint32_t>(std::string_view(name).substr(prefix.size())))
      found.push_back(*ifindex);
  }
  return found;
}

Result<void> unpin_vanished(const Control& control) {
  const auto pinned = pinned_interfaces(control);
  if (!pinned) return std::unexpected(pinned.error());
  const Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket) return failure("a socket to ask for interfaces", errno);
  for (const std::uint32_t ifindex : *pinned) {
    ifreq asked{};
    asked.ifr_ifindex = static_cast<int>(ifindex);
    // NOLINTNEXTLINE(*-vararg)
    if (::ioctl(socket.get(), SIOCGIFNAME, &asked) == 0 || errno != ENODEV) continue;
    const std::string directory = gate_directory(control.directory(), ifindex);
    retire_gate(directory);
    remove_pin_directory(directory);
  }
  return {};
}

namespace {

Result<bool> has_gate(GateLocation place) {
  for (const auto hook : {Hook::tcx, Hook::clsact}) {
    place.hook = hook;
    const auto there = in_place(place);
    if (!there) return std::unexpected(there.error());
    if (there->is_gate()) return true;
  }
  return false;
}

/// Puts programs where there are none. The interface has nothing to keep, so the maps are not
/// pinned.
Result<Closing> put_closed(const GateLocation& place, const ClosedPrograms& programs) {
  auto closing = Closing::was_gated;
  for (const auto direction : kBothDirections) {
    const auto put = put_in_empty_place(place, direction, programs.program_fd(direction));
    if (!put) return std::unexpected(put.error());
    if (*put) closing = Closing::closed;
  }
  return closing;
}

/// Chooses the programs by the framing of the interface: where frames carry the subject, only
/// frames that carry events are dropped. Uses clsact if nothing can be pinned.
Result<Closing> put_closed(GateLocation place, const Control& control) {
  const auto framing = framing_of(place.ifindex);
  if (!framing) return std::unexpected(framing.error());
  const auto programs =
      *framing == Framing::other
          ? ClosedPrograms::of_can(control.shared())
          : ClosedPrograms::of_ethernet(control.shared(), *framing == Framing::wpan);
  if (!programs) return std::unexpected(programs.error());
  if (place.hook == Hook::tcx && make_pin_directory(place.directory))
    if (auto put = put_closed(place, *programs)) return put;
  place.hook = Hook::clsact;
  return put_closed(place, *programs);
}

}  // namespace

Result<Closing> close_interface(const std::string& name, const Control& control,
                                std::optional<Hook> hook) {
  const auto in_context = [&](const Error& error) {
    return fail(fmt::format("close {}: {}", name, error.text));
  };
  const std::uint32_t ifindex = if_nametoindex(name.c_str());
  if (ifindex == 0) return failure("close " + name, errno);
  const bool can_pin = !control.directory().empty();
  const GateLocation place{ifindex, can_pin ? gate_directory(control.directory(), ifindex) : "",
                           hook.value_or(can_pin ? best_hook() : Hook::clsact)};
  const auto before = has_gate(place);
  if (!before) return in_context(before.error());
  if (*before) return Closing::was_gated;

  auto closing = put_closed(place, control);
  if (!closing) return in_context(closing.error());
  const auto after = has_gate(place);
  if (!after) return in_context(after.error());
  if (!*after)
    return fail(fmt::format(
        "close {0}: an ingress qdisc stands in the place of clsact: tc qdisc del dev {0} ingress",
        name));
  return closing;
}

Result<Closing> close_interface(const std::string& name, const std::string& root,
                                std::optional<Hook> hook) {
  auto control = Control::create(root);
  if (!control) control = Control::create_unpinned();
  if (!control) return fail(fmt::format("close {}: {}", name, control.error().text));
  return close_interface(name, *control, hook);
}

}  // namespace mlcca::gates
