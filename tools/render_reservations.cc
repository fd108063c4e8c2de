// SPDX-License-Identifier: BSD-2-Clause
// Text about reservations: who holds how much of each resource, and what is left.
#include <fmt/format.h>

#include "mlcca/arithmetic.hpp"
#include "tools/render.hpp"
#include "tools/values.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

/// One second of medium time in the units of a bus (us) and of a contention domain (ps).
constexpr std::uint64_t kBusSecond = 1'000'000;
constexpr std::uint64_t kDomainSecond = 1'000'000'000'000;

/// An amount of a resource: "12.5 %" of its time, or "400 kB/s".
std::string amount(const control::Resource& resource, std::uint64_t value) {
  if (resource.unit == "ppm") return percent(value, kBusSecond);
  if (resource.unit == "ps/s") return percent(value, kDomainSecond);
  if (resource.unit == "bytes/s") return bytes_per_second(value);
  return print_value("", value, resource.unit);
}

Cell left(const control::Resource& resource) {
  if (!resource.capacity_known) return {};
  const auto taken = add_saturating(resource.reserved, resource.background);
  if (taken > resource.capacity)
    return {"over by " + amount(resource, taken - resource.capacity), Style::bad};
  return {amount(resource, resource.capacity - taken)};
}

std::string overview(const control::Reservations& reservations, Color color) {
  TextTable table({{"RESOURCE"},
                   {"KIND"},
                   {"CAPACITY", Align::right},
                   {"RESERVED", Align::right},
                   {"BACKGROUND", Align::right},
                   {"FREE", Align::right}});
  for (const auto& resource : reservations.resources)
    table.add({{resource.name, Style::bold},
               {resource.kind},
               {resource.capacity_known ? amount(resource, resource.capacity) : "unknown"},
               {amount(resource, resource.reserved)},
               {resource.background == 0 ? "" : amount(resource, resource.background)},
               left(resource)});
  return table.empty() ? "nothing that can be reserved is described\n" : table.text(color);
}

/// `shown`, or an empty cell if `n` is 0, the default (preferred set, no importance, no lease).
std::string unless_zero(std::uint64_t n, std::uint64_t shown) {
  return n == 0 ? "" : fmt::format("{}", shown);
}

std::string share(const control::Resource& resource, const control::Reservation& reservation) {
  const bool known = resource.capacity_known && resource.capacity != 0;
  return known ? percent(reservation.amount, resource.capacity) : "";
}

std::string holders(const control::Resource& resource, Color color) {
  TextTable table({{"CHANNEL"},
                   {"PUBLISHER"},
                   {"AMOUNT", Align::right},
                   {"SHARE", Align::right},
                   {"ADMISSION", Align::right},
                   {"SET", Align::right},
                   {"IMPORTANCE", Align::right},
                   {"LEASE", Align::right}});
  for (const auto& one : resource.reservations)
    table.add({{one.channel},
               {one.publisher},
               {amount(resource, one.amount)},
               {share(resource, one)},
               {unless_zero(one.admission, one.admission)},
               {unless_zero(one.set, std::uint64_t{one.set} + 1)},
               {unless_zero(one.importance, one.importance)},
               {one.lease_ns == 0 ? "" : print_duration(one.lease_ns)}});
  if (table.empty()) return {};
  return '\n' + styled(resource.name, Style::bold, color) + '\n' + table.text(color, "  ");
}

}  // namespace

std::string render(const control::Reservations& reservations, Color color) {
  auto text = overview(reservations, color);
  for (const auto& resource : reservations.resources) text += holders(resource, color);
  return text;
}

}  // namespace mlcca::tools
