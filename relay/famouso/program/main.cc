// SPDX-License-Identifier: BSD-2-Clause
// mlcca-famouso: the event channel handler for existing programs of FAMOUSO, and the broker of its
// buses. It runs as a user of its own without capabilities; what its programs publish passes the
// gates where the description has that user as publisher.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <net/if.h>
#include <pwd.h>
#include <sys/epoll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/at_once.hpp"
#include "base/big_endian.hpp"
#include "base/clock.hpp"
#include "base/command_line.hpp"
#include "base/many.hpp"
#include "base/number.hpp"
#include "control/version.hpp"
#include "description/read.hpp"
#include "relay/famouso/bus_broker.hpp"
#include "relay/famouso/handler.hpp"
#include "relay/famouso/peer_user.hpp"
#include "relay/famouso/program/described_tags.hpp"
#include "relay/famouso/subscriber_program.hpp"
#include "relay/run.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint64_t kRound = 1'000'000'000;  // ns between two rounds for what is due without an
                                                 // event
constexpr std::uint64_t kInAMilli = 1'000'000;
constexpr std::uint16_t kPort = 5005;
constexpr TagNumber kFirstTag = 5;  // lower tags belong to the protocols
constexpr std::size_t kMostFrames = 64;
constexpr std::uint64_t kUid = 0x6d6c'6363'6100'0001;  // "mlcca" and a number

struct Options {
  std::string socket = "/run/mlcca/control.sock";
  std::string listen;
  std::vector<std::string> users;
  bool any_user = false;
  std::vector<std::string> brokers;
  std::vector<std::string> tags;
  std::string description = "/etc/mlcca/system.xml";
  bool subscriptions = false;
  std::string uid = fmt::format("{:#018x}", kUid);
  std::string state_directory = "/var/lib/mlcca-famouso";
};

// --- what options mean ---------------------------------------------------------------------------

struct Address {
  std::uint32_t address = INADDR_LOOPBACK;
  std::uint16_t port = kPort;
};
/// Parses "5005" or "127.0.0.1:5005".
Result<Address> address_in(const std::string& text) {
  Address out;
  const auto colon = text.find(':');
  const auto port = number_in<std::uint16_t>(
      colon == std::string::npos ? text : std::string_view(text).substr(colon + 1));
  in_addr address{};
  constexpr std::uint32_t loopback = 127;
  if (colon != std::string::npos) {
    if (::inet_pton(AF_INET, text.substr(0, colon).c_str(), &address) != 1)
      return fail("--listen " + text + ": must be a port, or an address and a port");
    out.address = ntohl(address.s_addr);
  }
  if (!port) return fail("--listen " + text + ": must be a port, or an address and a port");
  if (out.address >> 24U != loopback)
    return fail("--listen " + text +
                ": must be an address of this host, 127.x.x.x: programs of other hosts have no "
                "user that could be asked for");
  out.port = *port;
  return out;
}

Result<std::set<uid_t>> users_in(const std::vector<std::string>& names) {
  std::set<uid_t> out;
  for (const std::string& name : names) {
    if (const auto number = number_in<uid_t>(name)) {
      out.insert(*number);
      continue;
    }
    const passwd* const user = ::getpwnam(name.c_str());  // NOLINT(concurrency-mt-unsafe)
    if (user == nullptr) return fail("--user " + name + ": there is no such user");
    out.insert(user->pw_uid);
  }
  return out;
}

/// Parses options like "0x5377697463685f5f=0x3ffe".
Result<std::vector<TagBroker::Dealt>> tags_in(const std::vector<std::string>& texts) {
  std::vector<TagBroker::Dealt> out;
  for (const std::string& text : texts) {
    const auto equals = text.find('=');
    const auto subject = prefixed_number_in<SubjectId>(std::string_view(text).substr(0, equals));
    const auto tag = equals == std::string::npos
                         ? std::nullopt
                         : prefixed_number_in<TagNumber>(std::string_view(text).substr(equals + 1));
    if (!subject || *subject == 0 || !tag || *tag < kFirstTag || *tag > kHighestTag)
      return fail("--tag " + text + ": must be SUBJECT=TAG, such as 0x5377697463685f5f=0x3ffe, " +
                  fmt::format("with a tag of {:#x} to {:#x}", kFirstTag, kHighestTag));
    const auto clashes = [&](const auto& other) {
      return other.first == *subject || other.second == *tag;
    };
    if (std::ranges::any_of(out, clashes))
      return fail("--tag " + text + ": the subject or the tag is stated twice");
    out.emplace_back(*subject, *tag);
  }
  return out;
}

/// Why this tag of the description contradicts those of --tag; nullopt if it does not.
std::optional<std::string> clash(const std::vector<TagBroker::Dealt>& stated, SubjectId subject,
                                 TagNumber tag) {
  for (const auto& [other, number] : stated)
    if ((other == subject) != (number == tag))
      return fmt::format(
          "the description has the tag {:#x} for the subject {:#018x}, and --tag {:#x} "
          "for {:#018x}",
          tag, subject, number, other);
  return std::nullopt;
}

Result<Uid> uid_in(const std::string& text) {
  const auto number = prefixed_number_in<std::uint64_t>(text);
  if (!number || *number == 0)
    return fail("--uid " + text + ": must be a number of 64 bits other than 0");
  return big_endian(*number);
}

/// The meaning of the options, after they were checked.
struct Settings {
  std::optional<Address> listen;
  std::optional<std::set<uid_t>> users;  ///< nullopt: all users
  struct BrokerOf {
    std::string interface;
    std::vector<TagBroker::Dealt> tags;  ///< stated by the description and by --tag
  };
  std::vector<BrokerOf> brokers;
  Uid uid{};
};

/// Adds the tags of the system to those of the options. Fails if two of them contradict each other.
Result<void> add_described(const core::System& system, const std::string& network,
                           std::vector<TagBroker::Dealt>& tags) {
  const auto described = described_tags(system, network);
  if (!described) return std::unexpected(described.error());
  for (const auto& [subject, tag] : *described) {
    if (const auto why = clash(tags, subject, tag)) return fail(*why);
    tags.emplace_back(subject, tag);
  }
  return {};
}

/// Parses "can0", or "can0=NETWORK" with a network of the description. Fails with the first error.
Result<std::vector<Settings::BrokerOf>> brokers_in(const Options& options) {
  const auto stated = tags_in(options.tags);
  if (!stated) return std::unexpected(stated.error());
  std::optional<core::System> system;
  std::vector<Settings::BrokerOf> out;
  for (const std::string& text : options.brokers) {
    const auto equals = text.find('=');
    Settings::BrokerOf one{.interface = text.substr(0, equals), .tags = *stated};
    if (one.interface.empty() || one.interface.size() >= IFNAMSIZ || one.interface.contains('/'))
      return fail("--broker " + text + ": must be the name of an interface, such as can0");
    if (equals != std::string::npos) {
      if (!system) {
        auto read = description::read(options.description);
        if (!read) return fail(description::to_string(read.error().front()));
        system = std::move(*read);
      }
      if (const auto done = add_described(*system, text.substr(equals + 1), one.tags); !done)
        return fail("--broker " + text + ": " + done.error().text);
    }
    out.push_back(std::move(one));
  }
  return out;
}
Result<Settings> read(const Options& options) {
  Settings out;
  if (options.listen.empty() && options.brokers.empty() && !options.subscriptions)
    return fail("nothing is to be done: see --listen, --broker and --subscriptions");
  if (!options.listen.empty()) {
    const auto at = address_in(options.listen);
    if (!at) return std::unexpected(at.error());
    out.listen = *at;
    auto users = users_in(options.users);
    if (!users) return std::unexpected(users.error());
    if (users->empty() != options.any_user)
      return fail("--listen needs --user for each user whose programs may connect, or --any-user");
    if (!options.any_user) out.users = std::move(*users);
  }
  auto brokers = brokers_in(options);
  if (!brokers) return std::unexpected(brokers.error());
  out.brokers = std::move(*brokers);
  const auto uid = uid_in(options.uid);
  if (!uid) return std::unexpected(uid.error());
  out.uid = *uid;
  return out;
}

// --- a broker and its bus ------------------------------------------------------------------------

/// A bus and its broker. The interface may disappear and return; the assignments stay.
class Bus {
 public:
  Bus(std::string interface, BusBroker broker)
      : interface_(std::move(interface)), broker_(std::move(broker)) {}

  /// -1: the interface does not exist at present.
  [[nodiscard]] int fd() const { return socket_ ? socket_->fd() : -1; }
  /// Opens the interface if it exists. Returns true if there is a new descriptor to watch.
  bool open();
  void receive(std::uint64_t now);
  void expire(std::uint64_t now) {
    if (const auto frame = broker_.expire(now)) send(*frame);
  }
  [[nodiscard]] std::uint64_t due() const { return broker_.due().value_or(~std::uint64_t{0}); }

 private:
  void send(const Frame& frame);
  void report(const std::string& trouble);

  std::string interface_;
  BusBroker broker_;
  std::unique_ptr<FrameSocket> socket_;
  std::string trouble_;
};

/// Logs a trouble once, until it changes.
void Bus::report(const std::string& trouble) {
  if (trouble == std::exchange(trouble_, trouble)) return;
  say(interface_ + ": " + (trouble.empty() ? "in order" : trouble));
}

bool Bus::open() {
  if (socket_) return false;
  const std::uint32_t ifindex = ::if_nametoindex(interface_.c_str());
  if (ifindex == 0) {
    report("there is no such interface");
    return false;
  }
  auto socket = open_frame_socket(ifindex);
  constexpr std::uint32_t mask = CAN_EFF_FLAG | CAN_RTR_FLAG | kTagMask;
  Result<void> filtered;
  if (socket)
    filtered = (*socket)->filter(
        {{CAN_EFF_FLAG | kNodeRequest, mask}, {CAN_EFF_FLAG | kTagRequest, mask}});
  if (!socket || !filtered) {
    report(socket ? filtered.error().text : socket.error().text);
    return false;
  }
  socket_ = std::move(*socket);
  report("");
  say(interface_ + ": broker of " + many(broker_.tags(), "tag"));
  return true;
}

void Bus::receive(std::uint64_t now) {
  for (std::size_t i = 0; socket_ && (i < kMostFrames || socket_->pending()); ++i) {
    FrameSocket::Frame got;
    const auto how = socket_->receive(got);
    if (how == FrameSocket::Got::gone) socket_.reset();
    if (how != FrameSocket::Got::frame) return;
    if (got.fd || got.frame.len > CAN_MAX_DLEN) continue;
    Frame frame{.id = got.frame.can_id & CAN_EFF_MASK, .length = got.frame.len, .data = {}};
    std::copy_n(std::begin(got.frame.data), got.frame.len, frame.data.begin());
    for (const Frame& answer : broker_.take(frame, now)) send(answer);
  }
}

void Bus::send(const Frame& frame) {
  canfd_frame out{};
  out.can_id = frame.id | CAN_EFF_FLAG;
  out.len = frame.length;
  std::ranges::copy(frame.data, std::begin(out.data));
  if (!socket_) return;
  const Sent how = socket_->send(out, false);
  report(how == Sent::sent ? ""
                           : "answers do not leave: the queue is full, or the gate drops them "
                             "(control-user of the Port)");
}

// --- the program ---------------------------------------------------------------------------------

class Program {
 public:
  Result<void> prepare(const Options& options, const Settings& settings);
  int run();

 private:
  [[nodiscard]] bool watch(int fd) const {
    epoll_event event{.events = EPOLLIN, .data = {.fd = fd}};
    return ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) == 0;
  }
  [[nodiscard]] int time_to_wait(std::uint64_t now) const;
  void receive(int fd, std::uint64_t now);

  Fd epoll_{::epoll_create1(EPOLL_CLOEXEC)};
  Fd signals_;
  std::unique_ptr<EventChannelHandler> handler_;
  std::unique_ptr<SubscriberProgram> subscriber_;
  std::vector<Bus> buses_;
};

Result<void> Program::prepare(const Options& options, const Settings& settings) {
  sigset_t mask;
  sigemptyset(&mask);
  for (const int signal : {SIGTERM, SIGINT}) sigaddset(&mask, signal);
  ::sigprocmask(SIG_BLOCK, &mask, nullptr);
  signals_ = Fd(::signalfd(-1, &mask, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!epoll_ || !signals_ || !watch(signals_.get())) return fail("no descriptors are left");
  for (const auto& [interface, tags] : settings.brokers) {
    auto file = DealtFile::open(options.state_directory + "/" + interface);
    if (!file) return std::unexpected(file.error());
    const auto log = [prefix = interface + ": "](const std::string& text) { say(prefix + text); };
    auto broker = BusBroker::make(settings.uid, std::move(*file), tags, log);
    if (!broker) return fail(interface + ": " + broker.error().text);
    buses_.emplace_back(interface, std::move(*broker));
  }
  if (options.subscriptions) {
    subscriber_ = std::make_unique<SubscriberProgram>(
        options.socket, ::geteuid(),
        SubscriberProgram::Outside{.watch =
                                       [this](int fd, bool there) {
                                         // epoll forgets a closed descriptor by itself
                                         if (there && !watch(fd)) say("no descriptors are left");
                                       },
                                   .log = say,
                                   .now = monotonic_ns});
    if (!watch(subscriber_->fd())) return fail("no descriptors are left");
  }
  if (!settings.listen) return {};
  auto handler =
      EventChannelHandler::open(settings.listen->address, settings.listen->port, settings.users,
                                options.socket, {.log = say, .user_of = user_at_other_end});
  if (!handler) return std::unexpected(handler.error());
  handler_ = std::move(*handler);
  if (!watch(handler_->fd())) return fail("no descriptors are left");
  say("listening at port " + std::to_string(handler_->port()));
  return {};
}

int Program::time_to_wait(std::uint64_t now) const {
  std::uint64_t due = now + kRound;
  for (const Bus& bus : buses_) due = std::min(due, bus.due());
  if (subscriber_) due = std::min(due, subscriber_->due_at());
  return due <= now ? 0 : static_cast<int>((due - now + kInAMilli - 1) / kInAMilli);
}

void Program::receive(int fd, std::uint64_t now) {
  for (Bus& bus : buses_)
    if (bus.fd() == fd) bus.receive(now);
  if (subscriber_) subscriber_->receive(fd);
}

int Program::run() {
  notify("READY=1");
  std::array<epoll_event, 64> events{};
  for (std::uint64_t alive_at = 0;;) {
    for (Bus& bus : buses_)
      if (bus.open() && !watch(bus.fd())) say("no descriptors are left");
    const int count =
        ::epoll_wait(epoll_.get(), events.data(), events.size(), time_to_wait(monotonic_ns()));
    const std::uint64_t now = monotonic_ns();
    for (int i = 0; i < count; ++i) {
      const int fd = events.at(static_cast<std::size_t>(i)).data.fd;
      if (fd == signals_.get()) return EXIT_SUCCESS;
      receive(fd, now);
    }
    for (Bus& bus : buses_) bus.expire(now);
    if (handler_) handler_->turn(now);
    if (subscriber_) subscriber_->turn();
    if (now - alive_at < kRound) continue;
    alive_at = now;
    notify("WATCHDOG=1");
  }
}

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"mlcca-famouso - event channel handler and broker for what was built for FAMOUSO",
               "mlcca-famouso"};
  app.set_version_flag("--version", kVersion);
  app.add_option("--socket", options.socket, "control socket of mlccad")->capture_default_str();
  app.add_option("--listen", options.listen,
                 "programs connect to this port of 127.0.0.1, or to ADDRESS:PORT (FAMOUSO: 5005)");
  app.add_option("--user", options.users, "whose programs may connect; may be given several times");
  app.add_flag("--any-user", options.any_user, "all users of this host may connect");
  app.add_option(
      "--broker", options.brokers,
      "CAN interface whose nodes get numbers and tags, or INTERFACE=NETWORK with the tags "
      "that the description states there; may be given several times");
  app.add_option("--description", options.description, "of the networks of --broker")
      ->capture_default_str();
  app.add_option("--tag", options.tags,
                 "SUBJECT=TAG: the tag that the description states; may be given several times");
  app.add_flag("--subscriptions", options.subscriptions,
               "answer what nodes subscribe where the description accepts that, and pass it on");
  app.add_option("--uid", options.uid, "of the broker as a node")->capture_default_str();
  app.add_option("--state-directory", options.state_directory, "what was dealt is kept here")
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& end) {
    return end_of_parsing(app, end, kWrongUse, EXIT_FAILURE);
  }
  const auto settings = read(options);
  if (!settings) {
    say("mlcca-famouso: " + settings.error().text);
    return kWrongUse;
  }
  Program program;
  if (const auto done = program.prepare(options, *settings); !done) {
    say("mlcca-famouso: " + done.error().text);
    return EXIT_FAILURE;
  }
  return program.run();
}

}  // namespace
}  // namespace mlcca::relay

int main(int argc, char** argv) {
  return mlcca::relay::run_program("mlcca-famouso", mlcca::relay::main, argc, argv);
}
