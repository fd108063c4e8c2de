// SPDX-License-Identifier: BSD-2-Clause
// Recognises the profile of the frames of an interface, with the certainty and the reason.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/model/system.hpp"
#include "tools/learn/frame.hpp"

namespace mlcca::learn {

/// A recognised profile.
struct Recognised {
  core::Profile profile = core::Profile::raw;
  unsigned percent = 0;  ///< certainty
  std::string why;       ///< the reason, in one line
  /// The next most likely profile, if the decision is close.
  std::optional<core::Profile> perhaps = {};
};

/// Examines the first frames of an interface.
class Recogniser {
 public:
  /// At most so many frames are examined.
  static constexpr std::size_t kMost = 20'000;

  void add(const Frame& frame);
  [[nodiscard]] std::size_t frames() const { return frames_; }
  [[nodiscard]] Recognised result() const;

 private:
  void add_standard(const Frame& frame);
  void add_tail(const Frame& frame);
  void add_groups(std::uint32_t id);
  [[nodiscard]] Recognised of_standard() const;
  [[nodiscard]] Recognised of_extended() const;
  [[nodiscard]] Recognised of_groups() const;

  std::size_t frames_ = 0;
  std::size_t extended_ = 0;
  // Cyphal: the transfer-id of an identifier is incremented with each transfer.
  std::map<std::uint32_t, std::uint8_t> tails_;  ///< latest tail byte by identifier
  std::size_t successors_ = 0;
  std::size_t compared_ = 0;
  // J1939:
  std::size_t broadcast_ = 0;   ///< number of frames with a PDU2 format in data page 0
  std::size_t management_ = 0;  ///< number of claims, requests and announcements
  std::map<std::uint32_t, bool> parameters_;  ///< by identifier: whether it is of these or another
  // FAMOUSO: number of frames of the binding protocol.
  std::size_t binding_ = 0;
  // CANopen:
  std::map<std::uint32_t, std::size_t> heartbeats_;  ///< by node
  std::size_t services_ = 0;                         ///< number of SDO frames
  std::map<std::uint32_t, std::size_t> standard_;    ///< number of frames by 11-bit identifier
};

}  // namespace mlcca::learn
