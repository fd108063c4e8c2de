// SPDX-License-Identifier: BSD-2-Clause
// Readers for pcap (draft-ietf-opsawg-pcap) and pcapng (draft-ietf-opsawg-pcapng), with frames of
// SocketCAN (link type 227), of Ethernet (1), and of both from the pseudo-interface "any" (113 and
// 276).
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/learn/ether.hpp"
#include "tools/learn/formats.hpp"

namespace mlcca::learn {
namespace {

constexpr std::uint32_t kEthernet = 1;
constexpr std::uint32_t kSocketCan = 227;
constexpr std::uint32_t kCooked = 113;
constexpr std::uint32_t kCooked2 = 276;
constexpr std::uint16_t kCan = 0x000c;     // ETH_P_CAN
constexpr std::uint16_t kCanFd = 0x000d;   // ETH_P_CANFD
constexpr std::uint16_t kOutgoing = 4;     // PACKET_OUTGOING
constexpr std::uint16_t kEtherDevice = 1;  // ARPHRD_ETHER
constexpr std::uint8_t kFdFlag = 0x04;     // CANFD_FDF
constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::size_t kLongestPacket = 1U << 18U;  // the limit of the formats
constexpr std::size_t kBlockHead = 12;             // type and size, and the size again at the end
constexpr std::uint32_t kLargestBlock = 16U << 20U;
constexpr std::size_t kMostDescribed = 4096;  // most interfaces of a section
// Types of blocks of pcapng.
constexpr std::uint32_t kPacket = 2;        // obsolete
constexpr std::uint32_t kSimplePacket = 3;  // without a time
constexpr std::uint32_t kEnhancedPacket = 6;
constexpr const char* kNoFrame = "a packet that is neither a frame of CAN nor a sound one of IPv4";

std::string at_offset(std::uint64_t offset) { return "offset " + std::to_string(offset); }

bool is_known(std::uint32_t link) {
  return link == kEthernet || link == kSocketCan || link == kCooked || link == kCooked2;
}

std::string unknown_link(std::uint32_t link) {
  return "link type " + std::to_string(link) +
         " has neither frames of CAN nor of Ethernet: record a CAN interface (SocketCAN, 227), an "
         "Ethernet interface (1) or any (113, 276)";
}

/// The header that "any" puts before a packet.
struct Cooked {
  bool local = false;
  std::uint16_t device = 0;  ///< ARPHRD_*
  std::uint32_t index = 0;   ///< index of the interface; 0: not stated
  Bytes sender;              ///< address of the sender: 6 bytes, or empty
  std::uint16_t protocol = 0;
};

/// Cuts the header off the packet. False if the packet is shorter.
bool take_cooked(Bytes& packet, std::uint32_t link, Cooked& head) {
  const bool second = link == kCooked2;
  const std::size_t size = second ? 20 : 16;
  if (packet.size() < size) return false;
  head.local = (second ? packet[10] : number_at<std::uint16_t>(packet, 0, true)) == kOutgoing;
  head.device = number_at<std::uint16_t>(packet, second ? 8 : 2, true);
  head.protocol = number_at<std::uint16_t>(packet, second ? 0 : 14, true);
  if (second) head.index = number_at<std::uint32_t>(packet, 4, true);
  const std::size_t bytes = second ? packet[11] : number_at<std::uint16_t>(packet, 4, true);
  if (bytes == 6) head.sender = packet.subspan(second ? 12 : 6, 6);
  packet = packet.subspan(size);
  return true;
}

/// The packets of one interface of a recording, or of all interfaces that "any" has.
class Packets {
 public:
  /// `named`: the recording states the name.
  Packets(std::string name, bool named, std::uint32_t link, Recording& recording)
      : name_(std::move(name)), named_(named), link_(link), recording_(recording) {
    if (link == kSocketCan) number(0, Medium::can);
    if (link == kEthernet) number(0, Medium::ethernet);
  }

  /// Reads one packet. False if it cannot be read. Other Ethernet traffic is not an error.
  bool take(Bytes packet, std::uint64_t ns) {
    if (link_ == kEthernet) {
      Frame frame;
      return hand_over(read_ethernet(packet, frame), frame, ns, 0);
    }
    Cooked head;
    if (link_ != kSocketCan) {
      if (!take_cooked(packet, link_, head)) return false;
      if (head.protocol != kCan && head.protocol != kCanFd) return take_other(packet, ns, head);
    }
    return take_socketcan(packet, ns, number(head.index, Medium::can), head.local, recording_);
  }

 private:
  bool take_other(Bytes packet, std::uint64_t ns, const Cooked& head) {
    if (head.device != kEtherDevice) return true;
    Frame frame;
    frame.local = head.local;
    std::ranges::copy(head.sender, frame.datagram.emplace().mac.begin());
    return hand_over(read_ethertype(head.protocol, packet, frame), frame, ns, head.index);
  }

  bool hand_over(Carries carries, Frame& frame, std::uint64_t ns, std::uint32_t index) {
    if (carries == Carries::broken) return false;
    frame.ns = ns;
    frame.interface = number(index, Medium::ethernet);
    if (carries == Carries::datagram) recording_.take(frame);
    return true;
  }

  /// The number of an interface. "any" has frames of several interfaces, and states for some of
  /// them which one it was.
  std::uint32_t number(std::uint32_t index, Medium medium) {
    const auto known = numbers_.find({index, medium});
    if (known != numbers_.end()) return known->second;
    const std::string name = index == 0 ? name_ : name_ + "-" + std::to_string(index);
    Interfaces& all = recording_.interfaces;
    const auto out =
        named_ && index == 0 ? all.number_of(name, medium) : all.number_of_made_up(name, medium);
    if (numbers_.size() < Interfaces::kMost) numbers_[{index, medium}] = out;
    return out;
  }

  std::string name_;
  bool named_;
  std::uint32_t link_;
  Recording& recording_;
  std::map<std::pair<std::uint32_t, Medium>, std::uint32_t> numbers_;
};

/// An interface of one section of pcapng.
struct NgInterface {
  std::uint32_t link = 0;           ///< link type
  std::optional<Packets> packets;   ///< nullopt if that is not known
  std::uint64_t units = 1'000'000;  ///< units of its times in a second
};

/// The units in a second by if_tsresol: a power of ten, or of two if the highest bit is set.
std::uint64_t units_of(std::uint8_t resolution) {
  constexpr unsigned most_bits = 60;
  constexpr unsigned most_digits = 18;
  const unsigned power = resolution & 0x7fU;
  if ((resolution & 0x80U) != 0) return std::uint64_t{1} << std::min(power, most_bits);
  std::uint64_t units = 1;
  for (unsigned i = 0; i < std::min(power, most_digits); ++i) units *= 10;
  return units;
}

/// Reads if_name and if_tsresol from the options of an interface description.
void read_options(Bytes options, bool big, std::string& name, std::uint64_t& units) {
  for (std::size_t at = 0; at + 4 <= options.size();) {
    const auto code = number_at<std::uint16_t>(options, at, big);
    const std::size_t size = number_at<std::uint16_t>(options, at + 2, big);
    at += 4;
    if (code == 0 || at + size > options.size()) return;
    const Bytes value = options.subspan(at, size);
    if (code == 2) name.assign(value.begin(), value.end());
    if (code == 9 && size == 1) units = units_of(value.front());
    at += (size + 3) / 4 * 4;
  }
}

std::uint64_t in_ns(std::uint64_t units, std::uint64_t per_second) {
  const std::uint64_t seconds = units / per_second;
  const std::uint64_t rest = units % per_second;
  __extension__ using Wide = unsigned __int128;
  return seconds * kSecond + static_cast<std::uint64_t>(Wide{rest} * kSecond / per_second);
}

class PcapNg {
 public:
  explicit PcapNg(Recording& recording) : recording_(recording) {}

  Result<void> read() {
    for (std::uint64_t at = 0;;) {
      const Bytes head = recording_.input.from(at, kBlockHead);
      if (head.empty()) return {};
      if (head.size() < kBlockHead)
        return recording_.cut(at_offset(at) + ": the file ends within a block");
      const auto type = number_at<std::uint32_t>(head, 0, big_);
      if (type == 0x0a0d0d0a) {
        const auto magic = number_at<std::uint32_t>(head, 8, true);
        if (magic != 0x1a2b3c4d && magic != 0x4d3c2b1a)
          return fail(at_offset(at + 8) + ": no byte-order magic of pcapng");
        big_ = magic == 0x1a2b3c4d;
        interfaces_.clear();
      }
      const auto size = number_at<std::uint32_t>(head, 4, big_);
      const auto what = [&] {
        return at_offset(at + 4) + ": a block of " + std::to_string(size) + " bytes";
      };
      if (size < kBlockHead || size % 4 != 0 || size > kLargestBlock)
        return fail(what() + ": a multiple of 4, 12 to " + std::to_string(kLargestBlock));
      const Bytes all = recording_.input.from(at, size);
      if (all.size() < size) return recording_.cut(what() + " does not fit into the file");
      block(type, all.subspan(8, size - kBlockHead), at);
      at += size;
    }
  }

 private:
  void block(std::uint32_t type, Bytes body, std::uint64_t at) {
    if (type == 1 && body.size() >= 8 && interfaces_.size() < kMostDescribed) {
      NgInterface one;
      const std::uint32_t link = one.link = number_at<std::uint16_t>(body, 0, big_);
      std::string name;
      read_options(body.subspan(8), big_, name, one.units);
      const bool named = !name.empty();
      if (!named) name = (link == kEthernet ? "eth" : "can") + std::to_string(interfaces_.size());
      if (is_known(link)) one.packets.emplace(name, named, link, recording_);
      interfaces_.push_back(std::move(one));
    }
    if (type == kPacket || type == kSimplePacket)
      recording_.pass_over(at_offset(at) + ": a block of type " + std::to_string(type) +
                           ", whose packets are not read");
    if (type != kEnhancedPacket || body.size() < 20) return;
    const auto interface = number_at<std::uint32_t>(body, 0, big_);
    const auto size = number_at<std::uint32_t>(body, 12, big_);
    if (interface >= interfaces_.size() || size > body.size() - 20) {
      recording_.pass_over(at_offset(at) + ": a packet of an interface that is not described");
      return;
    }
    NgInterface& from = interfaces_[interface];
    const auto units = std::uint64_t{number_at<std::uint32_t>(body, 4, big_)} << 32U |
                       number_at<std::uint32_t>(body, 8, big_);
    if (!from.packets)
      recording_.pass_over(at_offset(at) + ": " + unknown_link(from.link));
    else if (!from.packets->take(body.subspan(20, size), in_ns(units, from.units)))
      recording_.pass_over(at_offset(at) + ": " + kNoFrame);
  }

  Recording& recording_;
  std::vector<NgInterface> interfaces_;
  bool big_ = true;
};

}  // namespace

bool take_socketcan(Bytes packet, std::uint64_t ns, std::uint32_t interface, bool local,
                    Recording& recording) {
  if (packet.size() < 8) return false;
  Frame frame;
  frame.ns = ns;
  frame.interface = interface;
  frame.local = local;
  frame.id = number_at<std::uint32_t>(packet, 0, true);
  const std::size_t size = packet[4];
  frame.fd = size > 8 || (packet[5] & kFdFlag) != 0;
  if (size > (frame.fd ? 64U : 8U) || size > packet.size() - 8) return false;
  frame.data = packet.subspan(8, size);
  recording.take(frame);
  return true;
}

Result<void> read_pcap(Recording& recording) {
  constexpr std::size_t header = 24;
  constexpr std::size_t before = 16;  // length of the header of a packet
  const Bytes head = recording.input.from(0, header);
  if (head.size() < header) return fail("the file ends within its header");
  const auto magic = number_at<std::uint32_t>(head, 0, true);
  const bool big = magic == 0xa1b2c3d4 || magic == 0xa1b23c4d;
  const bool nanoseconds = magic == 0xa1b23c4d || magic == 0x4d3cb2a1;
  const auto link = number_at<std::uint32_t>(head, 20, big) & 0xffffU;
  if (!is_known(link)) return fail(unknown_link(link));
  Packets packets(recording.stem, false, link, recording);
  for (std::uint64_t at = header;;) {
    const Bytes begun = recording.input.from(at, before);
    if (begun.empty()) return {};
    if (begun.size() < before)
      return recording.cut(at_offset(at) + ": the file ends within a packet");
    const auto size = number_at<std::uint32_t>(begun, 8, big);
    const auto what = [&] {
      return at_offset(at) + ": a packet of " + std::to_string(size) + " bytes";
    };
    if (size > kLongestPacket)
      return fail(what() + ": " + std::to_string(kLongestPacket) + " are the limit");
    const Bytes packet = recording.input.from(at, before + size);
    if (packet.size() < before + size) return recording.cut(what() + " does not fit into the file");
    const std::uint64_t fraction = number_at<std::uint32_t>(packet, 4, big);
    const auto ns = number_at<std::uint32_t>(packet, 0, big) * kSecond +
                    (nanoseconds ? fraction : fraction * 1000);
    if (!packets.take(packet.subspan(before, size), ns))
      recording.pass_over(at_offset(at) + ": " + kNoFrame);
    at += before + size;
  }
}

Result<void> read_pcapng(Recording& recording) { return PcapNg(recording).read(); }

}  // namespace mlcca::learn
