// SPDX-License-Identifier: BSD-2-Clause
// Which profile the frames of an interface have, how sure that is, and why.
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

struct Recognised {
  core::Profile profile = core::Profile::raw;
  unsigned percent = 0;  ///< how sure
  std::string why;       ///< what was seen, in one line
  /// It may be this one: a close call.
  std::optional<core::Profile> perhaps = {};
};

/// The first frames of an interface.
class Recogniser {
 public:
  /// So many are looked at.
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
  // Cyphal: the transfer-id of an identifier goes up by one with each transfer.
  std::map<std::uint32_t, std::uint8_t> tails_;  ///< the latest of each identifier
  std::size_t successors_ = 0;
  std::size_t compared_ = 0;
  // J1939
  std::size_t broadcast_ = 0;                 ///< frames: PDU2 of data page 0
  std::size_t management_ = 0;                ///< claims, requests, announcements
  std::map<std::uint32_t, bool> parameters_;  ///< identifiers: these, or others
  // FAMOUSO
  std::size_t binding_ = 0;
  // CANopen
  std::map<std::uint32_t, std::size_t> heartbeats_;  ///< by node
  std::size_t services_ = 0;                         ///< SDO
  std::map<std::uint32_t, std::size_t> standard_;    ///< frames of each 11-bit identifier
};

}  // namespace mlcca::learn
