// SPDX-License-Identifier: BSD-2-Clause
// The rules of the Ethernet gate once more, as plainly as possible: what the programs are held
// against. Nothing expires here, and nothing is forgotten.
#pragma once
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/bpf/ether/loaded_ether.hpp"

namespace mlcca::test {

struct Judgement {
  bool dropped = false;
  std::optional<std::uint32_t> mark;  ///< nothing: left as it was
  gate_reason reason = GATE_R_FOREIGN;
  std::optional<std::size_t> slot;  ///< that counts the packet; none: the direction's own
  std::uint64_t bytes = 0;
  bool counts_in_slot = false;
};

class EtherWorld {
 public:
  bool open = true;
  bool lapsed = false;
  bool audit = false;
  std::vector<gates::SlotSpec> slots;  ///< in the order they were added; nothing where removed

  Judgement judge(gates::Direction direction, const Bytes& bytes, const Sender& sender);
  /// What the program in the driver drops; nothing where it lets pass.
  [[nodiscard]] std::optional<Judgement> judge_early(const Bytes& bytes) const;

 private:
  enum class Kind { foreign, event, later, foreign_first, malformed, opaque };
  struct Seen {
    Kind kind = Kind::foreign;
    std::uint64_t subject = 0;
    std::uint64_t station = 0;  ///< whom it is from
    std::size_t length = 0;
    bool fragmented = false;
    bool more = false;
    std::size_t offset = 0;
    std::size_t here = 0;   ///< bytes of the datagram in this packet
    std::size_t whole = 0;  ///< bytes that it has
    bool inside = false;
    std::uint64_t addresses = 0;
    std::uint16_t id = 0;
  };
  using Name = std::tuple<gates::Direction, std::uint64_t, std::uint16_t, bool>;
  struct Remembered {
    bool event = false;
    std::size_t first = 0;
    std::size_t whole = 0;
    std::size_t slot = 0;
    std::size_t left = 0;  ///< bytes that may follow
  };

  static Seen parse(const Bytes& bytes);
  static Seen look_at_ip(const Bytes& bytes, std::size_t at, bool inside);
  static std::pair<Kind, std::size_t> look_at_batman(const Bytes& bytes, std::size_t at);
  static Seen look_at_awds(const Bytes& bytes, std::size_t packet, std::size_t at, bool inside);
  Judgement judge_event(gates::Direction direction, const Seen& seen, const Sender& sender);
  Judgement judge_later(gates::Direction direction, const Seen& seen, const Sender& sender);
  [[nodiscard]] std::pair<gate_reason, std::optional<std::size_t>> decide(
      gates::Direction direction, const Seen& seen, const Sender& sender) const;
  [[nodiscard]] Judgement reported_once(gates::Direction direction, const Sender& sender,
                                        Judgement judged) const;
  [[nodiscard]] Judgement refused(gate_reason reason, std::optional<std::size_t> slot,
                                  std::optional<std::uint32_t> mark) const;

  std::map<Name, Remembered> fragments_;
};

}  // namespace mlcca::test
