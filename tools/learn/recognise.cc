// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/recognise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "base/many.hpp"
#include "tools/learn/decode.hpp"

namespace mlcca::learn {
namespace {

constexpr std::size_t kMostIdentifiers = 4096;

unsigned percent_of(std::size_t part, std::size_t all) {
  return all == 0 ? 0 : static_cast<unsigned>(part * 100 / all);
}

/// The larger of two shares. A single fast message can make up most frames of a bus, and many rare
/// ones most of its identifiers.
struct Share {
  unsigned percent = 0;
  std::string_view of;
};
Share larger(unsigned of_frames, unsigned of_identifiers) {
  return of_identifiers > of_frames ? Share{of_identifiers, "identifiers"}
                                    : Share{of_frames, "frames"};
}

}  // namespace

void Recogniser::add(const Frame& frame) {
  if (frames_ >= kMost) return;
  ++frames_;
  if (!frame.is_extended()) {
    add_standard(frame);
    return;
  }
  ++extended_;
  add_tail(frame);
  add_groups(frame.id & kIdentifierBits);
}

/// Counts heart-beats, SYNC and SDO of CANopen.
void Recogniser::add_standard(const Frame& frame) {
  const std::uint32_t id = frame.id & kIdentifierBits;
  const auto& data = frame.data;
  if (standard_.size() < kMostIdentifiers || standard_.contains(id)) ++standard_[id];
  constexpr std::array<std::uint8_t, 4> states = {0, 4, 5, 127};
  const bool state = data.size() == 1 && std::ranges::find(states, data[0]) != states.end();
  if (id > 0x700 && id <= 0x77f && state) ++heartbeats_[id & 0x7fU];
  if (is_service(id) && data.size() == 8) ++services_;
}

/// Counts, for Cyphal, whether the tail byte is that of the next transfer or of the same one.
void Recogniser::add_tail(const Frame& frame) {
  const std::uint32_t id = frame.id & kIdentifierBits;
  if (frame.data.empty() || (tails_.size() >= kMostIdentifiers && !tails_.contains(id))) return;
  const std::uint8_t tail = frame.data.back();
  const auto [known, fresh] = tails_.try_emplace(id, tail);
  if (fresh) return;
  ++compared_;
  const std::uint8_t before = known->second;
  known->second = tail;
  constexpr std::uint8_t first = 0x80;
  constexpr std::uint8_t last = 0x40;
  constexpr std::uint8_t toggle = 0x20;
  constexpr std::uint8_t number = 0x1f;
  const bool next_transfer = (before & last) != 0 && (tail & first) != 0 && (tail & toggle) != 0 &&
                             (tail & number) == ((before + 1U) & number);
  const bool same_transfer = (before & last) == 0 && (tail & first) == 0 &&
                             (tail & number) == (before & number) &&
                             (tail & toggle) != (before & toggle);
  if (next_transfer || same_transfer) ++successors_;
}

/// Counts PGNs of J1939, and the binding protocol of FAMOUSO (priority 0x7d, tags 2 and 4).
void Recogniser::add_groups(std::uint32_t id) {
  constexpr std::array<std::uint32_t, 5> managing = {0xee, 0xea, 0xec, 0xeb, 0xe8};
  constexpr std::uint32_t pdu2 = 240;
  const std::uint32_t format = id >> 16U & 0xffU;
  const bool page0 = (id >> 24U & 3U) == 0;
  const bool broadcast = page0 && format >= pdu2;
  const bool manages = page0 && std::ranges::find(managing, format) != managing.end();
  if (broadcast) ++broadcast_;
  if (manages) ++management_;
  if (parameters_.size() < kMostIdentifiers) parameters_.try_emplace(id, broadcast || manages);
  const std::uint32_t tag = id & 0x3fffU;
  if ((id >> 22U & 0x7fU) == 0x7d && (tag == 2 || tag == 4)) ++binding_;
}

Recognised Recogniser::result() const {
  if (frames_ == 0) return {core::Profile::raw, 0, "no frames were seen"};
  const unsigned extended = percent_of(extended_, frames_);
  if (extended >= 90) return of_extended();
  if (extended_ == 0) return of_standard();
  return {core::Profile::raw, 90,
          fmt::format("{} % of the frames have 29-bit identifiers, the others 11", extended)};
}

Recognised Recogniser::of_standard() const {
  if (!heartbeats_.empty()) {
    // Counts the function codes of the predefined connection set of nodes with a heart-beat.
    std::size_t frames = 0;
    std::size_t identifiers = 0;
    for (const auto& [id, count] : standard_)
      if (id <= 0x80 || heartbeats_.contains(id & 0x7fU)) {
        frames += count;
        ++identifiers;
      }
    const Share share =
        larger(percent_of(frames, frames_), percent_of(identifiers, standard_.size()));
    if (share.percent >= 80)
      return {core::Profile::canopen, std::min(60 + share.percent / 3, 95U),
              fmt::format("{} heart-beats (0x700 and the node), {} % of the {} are theirs, SYNC or "
                          "NMT{}",
                          many(heartbeats_.size(), "node sends", "nodes send"), share.percent,
                          share.of, services_ == 0 ? "" : ", and there are SDOs")};
  }
  constexpr std::size_t enough = 100;  // frames
  const std::string_view why = "11-bit identifiers without the traffic of CANopen";
  if (frames_ >= enough) return {core::Profile::raw, 90, std::string(why)};
  return {core::Profile::raw, 50 + static_cast<unsigned>(frames_ * 40 / enough),
          fmt::format("{}, in {} only", why, many(frames_, "frame"))};
}

Recognised Recogniser::of_extended() const {
  using core::Profile;
  const unsigned successors = percent_of(successors_, compared_);
  if (compared_ >= 20 && successors >= 90)
    return {Profile::cyphal, std::min(successors, 99U),
            fmt::format("29-bit identifiers, and {} % of the frames of an identifier end with the "
                        "next transfer-id in their last byte",
                        successors)};
  if (binding_ != 0)
    return {Profile::famouso, 95,
            fmt::format("{} for tags or deal{} them, with priority 0x7d",
                        many(binding_, "frame asks", "frames ask"), binding_ == 1 ? "s" : "")};
  return of_groups();
}

Recognised Recogniser::of_groups() const {
  using core::Profile;
  const auto known = static_cast<std::size_t>(
      std::ranges::count_if(parameters_, [](const auto& one) { return one.second; }));
  const Share share = larger(percent_of(broadcast_ + management_, extended_),
                             percent_of(known, parameters_.size()));
  const std::string seen =
      fmt::format("29-bit identifiers, {} % of the {} of broadcast PGNs{}", share.percent, share.of,
                  management_ == 0 ? "" : " or manage the network");
  if (share.percent >= 70 && management_ != 0)
    return {Profile::j1939, std::min(70 + share.percent / 4, 98U),
            fmt::format("{} ({})", seen,
                        many(management_, "address claim, request or announcement",
                             "address claims, requests or announcements"))};
  if (share.percent >= 80)
    return {Profile::j1939, 70, fmt::format("{}; no address claim was seen", seen)};
  constexpr unsigned close = 40;
  if (share.percent >= close)
    return {Profile::raw, 60, fmt::format("{}, which is too few for J1939 to be sure", seen),
            Profile::j1939};
  return {Profile::raw, 60, "29-bit identifiers of no profile that is known here"};
}

}  // namespace mlcca::learn
