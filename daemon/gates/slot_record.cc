// SPDX-License-Identifier: BSD-2-Clause
// Every number in groups of seven bits, the lowest first; the top bit says that another follows.
#include "daemon/gates/slot_record.hpp"

#include <limits>
#include <utility>

namespace mlcca::enforce {
namespace {

constexpr std::uint64_t kEgress = 1;
constexpr std::uint64_t kPasses = 2;
constexpr std::uint64_t kExcessPasses = 4;

// Whoever adds what a slot says adds it to its record.
static_assert(sizeof(SlotSpec) == 104);

void put(std::string& to, std::uint64_t number) {
  for (; number > 0x7f; number >>= 7) to.push_back(static_cast<char>(number | 0x80));
  to.push_back(static_cast<char>(number));
}

/// Takes numbers off the front; `good` until one is not there or does not fit.
struct Numbers {
  std::string_view octets;
  bool good = true;

  template <class Integer = std::uint64_t>
  Integer take() {
    std::uint64_t number = 0;
    for (unsigned shift = 0; good; shift += 7) {
      if (octets.empty() || shift > 63) {
        good = false;
        break;
      }
      const auto octet = static_cast<unsigned char>(octets.front());
      octets.remove_prefix(1);
      number |= std::uint64_t{octet & 0x7fU} << shift;
      if ((octet & 0x80U) == 0) break;
    }
    good = good && number <= std::numeric_limits<Integer>::max();
    return good ? static_cast<Integer>(number) : Integer{0};
  }
};

bool has_origin(const SlotSpec& s) {
  return gate_has_origin(std::to_underlying(s.direction), s.source) != 0;
}

/// The origin, or the user, of whom GATE_ANY_UID becomes 0.
std::uint32_t origin_or_user(const SlotSpec& s) { return has_origin(s) ? s.origin : s.uid + 1; }

void put(std::string& to, const PlacedSlot& placed) {
  const SlotSpec& s = placed.slot;
  put(to, placed.ifindex);
  put(to, (s.direction == Direction::egress ? kEgress : 0) | (s.pass ? kPasses : 0) |
              (s.excess_passes ? kExcessPasses : 0));
  for (const std::uint64_t number :
       {std::uint64_t{s.max_len}, std::uint64_t{s.formats}, std::uint64_t{s.id},
        std::uint64_t{s.mask}, std::uint64_t{s.source}, std::uint64_t{origin_or_user(s)}, s.station,
        s.per_frame, s.per_byte, s.tolerance, s.period, s.silence, s.together})
    put(to, number);
}

PlacedSlot take(Numbers& from, std::uint64_t subject) {
  PlacedSlot placed;
  SlotSpec& s = placed.slot;
  placed.ifindex = from.take<std::uint32_t>();
  const auto flags = from.take();
  from.good = from.good && flags <= (kEgress | kPasses | kExcessPasses);
  s.direction = (flags & kEgress) != 0 ? Direction::egress : Direction::ingress;
  s.pass = (flags & kPasses) != 0;
  s.excess_passes = (flags & kExcessPasses) != 0;
  s.max_len = from.take<std::uint16_t>();
  s.formats = from.take<std::uint8_t>();
  s.id = from.take<std::uint32_t>();
  s.mask = from.take<std::uint32_t>();
  s.source = from.take<std::uint32_t>();
  if (has_origin(s))
    s.origin = from.take<std::uint32_t>();
  else
    s.uid = from.take<std::uint32_t>() - 1;
  s.station = from.take();
  s.subject = subject;
  s.per_frame = from.take();
  s.per_byte = from.take();
  s.tolerance = from.take();
  s.period = from.take();
  s.silence = from.take();
  s.together = from.take();
  return placed;
}

}  // namespace

std::string record_of(std::span<const PlacedSlot> slots) {
  std::string record;
  for (const PlacedSlot& placed : slots) put(record, placed);
  return record;
}

std::optional<std::vector<PlacedSlot>> slots_in(std::string_view record, std::uint64_t subject) {
  std::vector<PlacedSlot> slots;
  Numbers numbers{record};
  while (!numbers.octets.empty()) {
    slots.push_back(take(numbers, subject));
    if (!numbers.good) return std::nullopt;
  }
  return slots;
}

}  // namespace mlcca::enforce
