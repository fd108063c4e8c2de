// SPDX-License-Identifier: BSD-2-Clause
#include "relay/layers/can_layer.hpp"

#include <linux/can/raw.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <optional>
#include <utility>

#include "relay/fd_length.hpp"
#include "relay/layers/sockets.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint32_t kFragmentBit = 1U << 21U;
constexpr std::uint32_t kForm = CAN_EFF_FLAG | CAN_RTR_FLAG;
/// Filters of a socket (CAN_RAW_FILTER_MAX). If more are needed, all frames are received and looked
/// up here.
constexpr std::size_t kMostFilters = 512;

/// Bits of an identifier that distinguish Cyphal's publishers: not the priority, which may differ
/// in each transfer, and not the reserved bits, which receivers ignore.
constexpr std::uint32_t kPublisherOfCyphal = 0x1fffff;

/// Most padding of a CAN FD frame: its lengths up to 64 are at most 16 apart.
constexpr std::size_t kMostPadding = 15;
Octets without_padding(Octets event, std::size_t longest) {
  return event.size() > longest && event.size() - longest <= kMostPadding ? event.first(longest)
                                                                          : event;
}

class RawSocket : public FrameSocket {
 public:
  explicit RawSocket(Fd socket) : socket_(std::move(socket)) {}
  static Result<std::unique_ptr<FrameSocket>> open(std::uint32_t ifindex);

  [[nodiscard]] int fd() const override { return socket_.get(); }
  [[nodiscard]] Result<void> filter(const std::vector<can_filter>& filters) override {
    if (::setsockopt(socket_.get(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                     static_cast<socklen_t>(filters.size() * sizeof(can_filter))) != 0)
      return system_error("CAN_RAW_FILTER");
    return {};
  }
  Got receive(Frame& to) override;
  [[nodiscard]] bool pending() const override { return batch_.pending(); }
  Sent send(const canfd_frame& frame, bool fd) override {
    const std::size_t size = fd ? CANFD_MTU : CAN_MTU;
    const ssize_t n = ::send(socket_.get(), &frame, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    return n >= 0 ? Sent::sent : failure_of_send();
  }
  [[nodiscard]] std::uint64_t dropped() const override { return dropped_; }

 private:
  Fd socket_;
  Batch batch_{sizeof(canfd_frame)};
  std::uint64_t dropped_ = 0;
};

Result<std::unique_ptr<FrameSocket>> RawSocket::open(std::uint32_t ifindex) {
  Fd socket(::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  if (!socket) return system_error("a socket for CAN");
  const int on = 1;
  if (::setsockopt(socket.get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) != 0)
    return system_error("CAN_RAW_FD_FRAMES");
  if (const auto done = ask_for_times(socket); !done) return std::unexpected(done.error());
  widen(socket);
  auto out = std::make_unique<RawSocket>(std::move(socket));
  if (const auto done = out->filter({}); !done) return std::unexpected(done.error());
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(ifindex);
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::bind(out->fd(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return system_error("bind");
  return std::unique_ptr<FrameSocket>(std::move(out));
}

FrameSocket::Got RawSocket::receive(Frame& to) {
  const Batch::Message message = batch_.next(socket_);
  const auto [n, flags, said] = message.received;
  if (n < 0) return errno == ENODEV || errno == ENXIO ? Got::gone : Got::nothing;
  if (said.says_dropped) dropped_ = said.dropped;
  std::memcpy(&to.frame, message.data, static_cast<std::size_t>(n));
  to.fd = n == CANFD_MTU;
  to.local = (flags & MSG_DONTROUTE) != 0;
  to.unix_ns = said.unix_ns;
  if (n != CANFD_MTU && n != CAN_MTU) to.frame.len = CANFD_MAX_DLEN + 1;  // CAN XL: not used
  return Got::frame;
}

}  // namespace

Result<std::unique_ptr<FrameSocket>> open_frame_socket(std::uint32_t ifindex) {
  return RawSocket::open(ifindex);
}

Result<std::unique_ptr<Layer>> CanLayer::open(const control::Endpoint& endpoint) {
  auto socket = RawSocket::open(endpoint.ifindex);
  if (!socket) return fail(endpoint.interface + ": " + socket.error().text);
  if (endpoint.profile != "j1939")
    return std::unique_ptr<Layer>(std::make_unique<CanLayer>(std::move(*socket)));
  auto alarm = Alarm::beside((*socket)->fd());
  if (!alarm) return fail(endpoint.interface + ": " + alarm.error().text);
  return std::unique_ptr<Layer>(std::make_unique<CanLayer>(std::move(*socket), std::move(*alarm)));
}

// --- who follows ---------------------------------------------------------------------------------

Result<CanLayer::Form> CanLayer::form_of(const control::Endpoint& endpoint) {
  if (endpoint.profile == "famouso") return Form::famouso;
  if (endpoint.profile == "cyphal") return Form::cyphal;
  if (endpoint.profile == "j1939" && endpoint.fragmented && endpoint.classic)
    return Form::transport;
  if (endpoint.fragmented)
    return fail("events of several frames are not carried on buses of profile " + endpoint.profile +
                ", as " + endpoint.network + " is one");
  if (!endpoint.classic && !endpoint.fd)
    return fail("CAN XL frames are not carried: " + endpoint.network);
  return Form::plain;
}

std::size_t CanLayer::filters() const { return identities_ + carriers_.size(); }

/// Sets the filters of the socket for the present followers. `before`: the former number of
/// filters.
Result<void> CanLayer::set_filters(std::size_t before) {
  if (filters() == before || (before > kMostFilters && filters() > kMostFilters)) return {};
  if (filters() > kMostFilters) return socket_->filter({can_filter{0, 0}});
  std::vector<can_filter> filters;
  for (const auto& [mask, by_id] : by_mask_)
    for (const auto& [id, all] : by_id) filters.push_back({id, mask});
  for (const auto& [carrier, needed] : carriers_)
    filters.push_back({carrier.first, carrier.second});
  return socket_->filter(filters);
}

/// Counts the endpoints that need the carrier frames of the endpoint's source (announcements and
/// packets), which may carry messages of other channels as well.
void CanLayer::follow_carriers(const control::Endpoint& endpoint, bool more) {
  constexpr std::uint32_t number = 0x03ffff00;
  for (const std::uint32_t id :
       {j1939::announcement_of(endpoint.id), j1939::packet_of(endpoint.id)}) {
    const std::uint32_t mask = endpoint.mask | number;
    const auto known = carriers_.try_emplace({id & mask, mask}, 0).first;
    known->second += more ? 1 : std::size_t{0} - 1;
    if (known->second == 0) carriers_.erase(known);
  }
}

Result<void> CanLayer::follow(Follower follower, const control::Endpoint& endpoint,
                              std::uint64_t /*subject*/, std::size_t longest) {
  const auto form = form_of(endpoint);
  if (!form) return std::unexpected(form.error());
  const std::size_t before = filters();
  auto& all = by_mask_[endpoint.mask][endpoint.id & endpoint.mask];
  all.push_back({follower, *form, endpoint.classic, endpoint.fd, longest});
  if (*form == Form::transport) follow_carriers(endpoint, true);
  if (all.size() == 1) ++identities_;
  return set_filters(before);
}

void CanLayer::leave(Follower follower, const control::Endpoint& endpoint,
                     std::uint64_t /*subject*/) {
  const auto mask = by_mask_.find(endpoint.mask);
  if (mask == by_mask_.end()) return;
  const auto known = mask->second.find(endpoint.id & endpoint.mask);
  if (known == mask->second.end()) return;
  const std::size_t before = filters();
  std::erase_if(known->second, [&](const Following& f) {
    if (f.follower != follower) return false;
    if (f.form == Form::transport) follow_carriers(endpoint, false);
    return true;
  });
  if (known->second.empty()) {
    mask->second.erase(known);
    if (mask->second.empty()) by_mask_.erase(mask);
    --identities_;
  }
  // If this fails, more frames are received than needed, which does no harm.
  static_cast<void>(set_filters(before));
}

// --- what comes ----------------------------------------------------------------------------------

bool CanLayer::receive(std::size_t most, const OnEvent& on_event) {
  send_due(0);
  for (std::size_t count = 0; count < most || socket_->pending(); ++count) {
    FrameSocket::Frame frame;
    const auto got = socket_->receive(frame);
    if (got != FrameSocket::Got::frame) return got != FrameSocket::Got::gone;
    if (!frame.local) take(frame, on_event);
  }
  return true;
}

void CanLayer::expire() {
  const std::uint64_t now = now_();
  fragments_.expire(now);
  transfers_.expire(now);
  messages_.expire(now);
}

/// Calls `use` for each follower of frames with this identifier.
template <class Use>
void CanLayer::each_of(std::uint32_t id, const Use& use) const {
  for (const auto& [mask, by_id] : by_mask_) {
    const auto known = by_id.find(id & mask);
    if (known == by_id.end()) continue;
    for (const Following& f : known->second) use(f);
  }
}

/// Whether a frame with this identifier is an event by itself.
bool CanLayer::is_complete(Form form, std::uint32_t id) {
  return form == Form::plain || form == Form::transport ||
         (form == Form::famouso && (id & kFragmentBit) == 0);
}

void CanLayer::take(const FrameSocket::Frame& frame, const OnEvent& on_event) {
  const std::uint32_t id = frame.frame.can_id;
  if ((id & (CAN_ERR_FLAG | CAN_RTR_FLAG)) != 0 || frame.frame.len > CANFD_MAX_DLEN) return;
  const Octets data(frame.frame.data, frame.frame.len);
  if (!carriers_.empty() && !frame.fd && (id & CAN_EFF_FLAG) != 0) {
    if (j1939::is_announcement(id)) take_announcement(id, data);
    if (j1939::is_packet(id)) take_packet(frame, data, on_event);
  }
  bool taken = false;  // a frame is reassembled once, for all followers
  std::optional<std::vector<std::uint8_t>> joined;
  each_of(id, [&](const Following& f) {
    if (!f.takes(frame)) return;
    if (is_complete(f.form, id)) {
      hand_over(f, frame, data, on_event);
      return;
    }
    if (!std::exchange(taken, true))
      joined = f.form == Form::cyphal ? transfers_.take(id & kPublisherOfCyphal, data, now_())
                                      : fragments_.take(id & ~kFragmentBit & ~kForm, data, now_());
    if (joined) hand_over(f, frame, *joined, on_event);
  });
}

void CanLayer::take_announcement(std::uint32_t id, Octets data) {
  const auto message = j1939::Reassembly::announced(id, data);
  if (!message) return;
  bool wanted = false;
  each_of(*message, [&](const Following& f) { wanted |= f.form == Form::transport; });
  messages_.announce(id, data, wanted, now_());
}

void CanLayer::take_packet(const FrameSocket::Frame& frame, Octets data, const OnEvent& on_event) {
  const auto message = messages_.take(frame.frame.can_id, data, now_());
  if (!message) return;
  each_of(message->id, [&](const Following& f) {
    if (f.form == Form::transport) hand_over(f, frame, message->event, on_event);
  });
}

/// Hands an event to a follower. `last`: the frame that completes the event.
void CanLayer::hand_over(const Following& to, const FrameSocket::Frame& last, Octets event,
                         const OnEvent& on_event) {
  if (last.fd) event = without_padding(event, to.longest);
  if (event.size() > to.longest)
    ++losses_.too_long;
  else
    on_event({to.follower, event, last.unix_ns, last.frame.can_id & CAN_EFF_MASK});
}

// --- what goes -----------------------------------------------------------------------------------

Sent CanLayer::send_frame(const control::Endpoint& endpoint, std::uint32_t id, Octets data) {
  const bool fd = !endpoint.classic;
  const auto length = fd ? fd_length(data.size()) : classic_length(data.size());
  if (!length || data.size() > endpoint.frame_bytes) return Sent::too_long;
  canfd_frame frame{};
  frame.can_id = id & ~CAN_RTR_FLAG;
  frame.len = *length;
  std::ranges::copy(data, std::begin(frame.data));  // std::copy, because the data of an empty event
                                                    // may be null
  return socket_->send(frame, fd);
}

Sent CanLayer::send_fragments(const control::Endpoint& endpoint, Octets event) {
  auto fragments = afp::Fragments::of(afp::kCan, event);
  if (!fragments) return Sent::too_long;
  while (const auto fragment = fragments->next())
    if (const Sent sent = send_frame(endpoint, endpoint.id | kFragmentBit, *fragment);
        sent != Sent::sent)
      return sent;
  return Sent::sent;
}

/// Transfer-IDs are counted for each subject-id and node, as the specification requires; so their
/// number is bounded, whatever channels come and go.
Sent CanLayer::send_transfer(const control::Endpoint& endpoint, Octets event) {
  std::uint8_t& number = numbers_[endpoint.id];
  const auto frames = cyphal::frames_of(event, endpoint.frame_bytes, number);
  if (!frames || (frames->size() > 1 && !endpoint.fragmented)) return Sent::too_long;
  number = (number + 1) & cyphal::kNumbers;
  for (const auto& frame : *frames)
    if (const Sent sent = send_frame(endpoint, endpoint.id, frame); sent != Sent::sent) return sent;
  return Sent::sent;
}

/// If the endpoint leaves the priority open, the frames have that of the transport protocol, the
/// lowest one.
Sent CanLayer::send_message(const control::Endpoint& endpoint, Octets event) {
  constexpr std::uint32_t priorities = 0x1c000000;
  const std::uint32_t id =
      (endpoint.mask & priorities) == 0 ? endpoint.id | priorities : endpoint.id;
  const std::uint32_t announcement = j1939::announcement_of(id);
  auto frames = j1939::frames_of(event, id);
  if (frames.empty()) return Sent::too_long;
  if (!sending_.add({.announcement = announcement,
                     .packet = j1939::packet_of(id),
                     .frames = std::move(frames)}))
    return Sent::dropped;
  return send_due(announcement);
}

/// Sends the frames that are due. Returns the result for `first`, the identifier of an event's
/// first frame; `sent` if it still waits.
Sent CanLayer::send_due(std::uint32_t first) {
  if (!sending_.due()) return Sent::sent;
  Sent of_first = Sent::sent;
  sending_.run(now_, [&](std::uint32_t id, const j1939::Data& data) {
    canfd_frame frame{};
    frame.can_id = id;
    frame.len = static_cast<std::uint8_t>(data.size());
    std::ranges::copy(data, std::begin(frame.data));
    const Sent how = socket_->send(frame, false);
    if (id == first)
      of_first = how;
    else if (how != Sent::sent)
      ++losses_.unsent;
    return how == Sent::sent;
  });
  if (alarm_) alarm_->set(sending_.due());
  return of_first;
}

Sent CanLayer::send(const control::Endpoint& endpoint, std::uint64_t /*subject*/, Octets event) {
  const auto form = form_of(endpoint);
  if (!form) return Sent::failed;
  switch (*form) {
    case Form::famouso:
      if (event.size() > afp::kCan.payload) return send_fragments(endpoint, event);
      return send_frame(endpoint, endpoint.id & ~kFragmentBit, event);
    case Form::cyphal:
      return send_transfer(endpoint, event);
    case Form::transport:
      if (event.size() > CAN_MAX_DLEN) return send_message(endpoint, event);
      break;
    case Form::plain:
      break;
  }
  return send_frame(endpoint, endpoint.id, event);
}

Losses CanLayer::losses() const {
  Losses out = losses_;
  const afp::Losses& of_fragments = fragments_.losses();
  out.malformed += of_fragments.malformed;
  out.incomplete += of_fragments.incomplete;
  out.crowded += of_fragments.crowded;
  const cyphal::Losses& of_transfers = transfers_.losses();
  out.malformed += of_transfers.malformed;
  out.incomplete += of_transfers.incomplete;
  out.crowded += of_transfers.crowded;
  out.malformed += messages_.losses().malformed;
  out.incomplete += messages_.losses().incomplete;
  out.in_socket += socket_->dropped();
  return out;
}

}  // namespace mlcca::relay
