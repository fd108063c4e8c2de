// SPDX-License-Identifier: BSD-2-Clause
// mlccad: reads the command line, connects the parts, and runs the event loop.
#include <fmt/format.h>
#include <grp.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <systemd/sd-device.h>
#include <systemd/sd-event.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string_view>
#include <vector>

#include "base/at_once.hpp"
#include "base/handle.hpp"
#include "base/listen.hpp"
#include "base/many.hpp"
#include "base/result.hpp"
#include "base/standard_streams.hpp"
#include "core/admission/state.hpp"
#include "daemon/early_closing.hpp"
#include "daemon/gates/close_unpinned.hpp"
#include "daemon/gates/former_layouts.hpp"
#include "daemon/gateway/controller.hpp"
#include "daemon/gateway/in_time.hpp"
#include "daemon/loop.hpp"
#include "daemon/options.hpp"
#include "daemon/ports/gates_lock.hpp"
#include "daemon/real_outside.hpp"
#include "description/kinds.hpp"
#include "description/read.hpp"

namespace {

using namespace mlcca;  // NOLINT(google-build-using-namespace): the program itself

// The exit statuses. mlccad.service does not restart after kBadInput.
constexpr int kFailed = 1;
constexpr int kBadInput = 2;

/// Whether the gates of every gateway can hold what the description needs; reports the reason if
/// not.
bool has_room(const core::System& system, const std::string& description) {
  const core::State state(system);
  for (std::size_t g = 0; g < system.gateways.size(); ++g)
    if (const auto lack = state.exceeds_capacity(g)) {
      to_stderr(description + ": " + *lack + '\n');
      return false;
    }
  return true;
}

/// Whether the description has the gateway. The machine that checks it need not be one of the
/// gateways.
bool has_gateway(const core::System& system, const Options& options) {
  const auto& gateways = system.gateways;
  if (options.gateway.empty()
          ? !gateways.empty()
          : std::ranges::find(gateways, options.gateway, &core::Gateway::name) != gateways.end())
    return true;
  to_stderr(
      fmt::format("{}: {}\n", options.description,
                  options.gateway.empty()
                      ? "no Gateway is described, and mlccad is one: describe it with its Ports"
                      : fmt::format("no Gateway is called '{}'", options.gateway)));
  return false;
}

int check_description(const Options& options) {
  const auto system = description::read(options.description);
  if (system) {
    if (!has_gateway(*system, options)) return kBadInput;
    if (!has_room(*system, options.description)) return kBadInput;
    const auto line = fmt::format(
        "{}: {}, {}, {}, {}, {}\n", options.description, many(system->channels.size(), "channel"),
        many(system->networks.size(), "network"), many(system->gateways.size(), "gateway"),
        many(system->publishers.size(), "publisher"),
        many(system->subscribers.size(), "subscriber"));
    return printed("mlccad", line) ? 0 : kFailed;
  }
  for (const auto& problem : description::shortened(system.error()))
    to_stderr(description::to_string(problem) + '\n');
  return kBadInput;
}

/// The socket that systemd has passed, or a new one.
Result<Fd> control_socket(const Options& options) {
  auto given = handed_over(SOCK_STREAM);
  if (!given || *given) return given;
  return listen_at(options.socket, SOCK_STREAM, 0666, serve::Server::kBacklog);
}

constexpr std::uint64_t kGroupLimit = 5'000'000'000;  // ns

struct ControlGroup {
  gid_t id = static_cast<gid_t>(-1);
  bool hangs = false;  ///< a thread waits for the look-up without limit
};

/// Looks up a group. The entry contains its members, who may be many, so the buffer grows.
Result<gid_t> group_named(const std::string& name) {
  constexpr std::size_t most_bytes = std::size_t{1} << 26U;
  std::vector<char> buffer(1024);
  group entry{};
  group* found = nullptr;
  int error = ERANGE;
  while (error == ERANGE && buffer.size() < most_bytes) {
    buffer.resize(buffer.size() * 2);
    error = ::getgrnam_r(name.c_str(), &entry, buffer.data(), buffer.size(), &found);
  }
  if (found != nullptr) return found->gr_gid;
  if (error == 0) return fail("there is no group " + name);
  return fail(fmt::format("group {} cannot be looked up: {}", name,
                          std::strerror(error)));  // NOLINT(concurrency-mt-unsafe)
}

/// Looks up the control group while heart-beats continue.
ControlGroup control_group(const Options& options, const SystemLog& journal, Controller& gateway) {
  const auto found = in_time([name = options.group] { return group_named(name); }, kGroupLimit,
                             [&gateway] { gateway.beat(); });
  if (found && *found) return {**found, false};
  journal.write(
      {Kind::problem,
       4,
       (found ? found->error().text
              : "within 5 s the look-up of groups has not answered for " + options.group) +
           ": until the next start only root may change anything",
       0,
       {},
       {},
       {},
       {}});
  return {.hangs = !found};
}

int give_up(const SystemLog& journal, const std::string& line) {
  journal.write({Kind::problem, 3, line, 0, {}, {}, {}, {}});
  return kFailed;
}

/// Closes gates that an earlier daemon has left, because this one cannot command them, and ends.
int close_and_give_up(const SystemLog& journal, const std::string& why) {
  const auto closed = gates::close_unpinned();
  if (!closed)
    journal.write({Kind::problem,
                   2,
                   "not every gate could be closed: " + closed.error().text,
                   0,
                   {},
                   {},
                   {},
                   {}});
  else if (!closed->empty())
    journal.write(
        {Kind::stopped, 3, fmt::format("closed: {}", fmt::join(*closed, ", ")), 0, {}, {}, {}, {}});
  return give_up(journal, why);
}

/// Raises the limit of descriptors: a port takes about 25, and the default limit, which suits
/// select(2), is enough for about 30 ports.
void allow_many_descriptors() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) < 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

/// Ends at once. Nothing is left incomplete: what was answered is on disk, the gates stay as they
/// are for the grace period, and the next start takes them over (docs/adr/0026).
[[noreturn]] void out_of_memory() {
  static constexpr std::string_view line =
      "mlccad: out of memory: ended at once; the gates stay as they are for the grace\n";
  write_at_once(STDERR_FILENO, line);
  std::abort();
}

/// Reports an exception of a library that no callback catches (libnl has no memory). The default
/// handler would wait for the reader of its output.
[[noreturn]] void ended_by_an_exception() {
  try {
    if (const auto thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    out_of_memory();
  } catch (const std::exception& e) {
    write_at_once(STDERR_FILENO, fmt::format("mlccad: ended by an error: {}\n", e.what()));
  } catch (...) {
    write_at_once(STDERR_FILENO, "mlccad: ended by an error\n");
  }
  std::abort();
}

int run(const Options& options) {
  allow_many_descriptors();
  const SystemLog journal = SystemLog::automatic();
  auto alone = lock_gates(options.bpf_root);
  if (!alone) return give_up(journal, alone.error().text);
  auto control = gates::Control::create(options.bpf_root);
  if (!control) return close_and_give_up(journal, control.error().text);
  if (const auto closed = gates::close_former_layouts(options.bpf_root); !closed) {
    control->close_all();
    return give_up(journal, closed.error().text);
  }
  auto links = net::Links::open();
  if (!links) {
    control->close_all();
    return give_up(journal, links.error().text);
  }
  const EventLoop events = new_event_loop();
  if (!events) {
    control->close_all();
    return give_up(journal, "there is no event loop to be had");
  }
  RealOutside world(options, journal, std::move(*control), std::move(*links), net::udev_facts,
                    events.get());
  if (const auto started = world.start_cluster(); !started) {
    world.outside().control.close_all();
    return give_up(journal, started.error().text);
  }
  Controller gateway(options, world.outside());
  gateway.hold(std::move(*alone));
  if (const auto problem = gateway.start()) {
    for (const std::string& line : problem->lines)
      journal.write({Kind::problem, 3, line, 0, {}, {}, {}, {}});
    // Another daemon may run with another bpffs, whose gates are open.
    journal.write({Kind::stopped,
                   3,
                   fmt::format("not started: the gates of {} deny everything, and no others were "
                               "changed",
                               options.bpf_root),
                   0,
                   {},
                   {},
                   {},
                   {}});
    const int status = problem->bad_input ? kBadInput : kFailed;
    if (gateway.is_reading()) std::_Exit(status);  // the thread may hang
    return status;
  }
  auto loop = Loop::open(events.get(), gateway, world);
  auto socket = control_socket(options);
  if (!loop || !socket) {
    gateway.stop();
    return give_up(journal, !loop ? loop.error().text : socket.error().text);
  }
  const ControlGroup group = control_group(options, journal, gateway);
  auto server = serve::Server::open(
      events.get(), std::move(*socket), group.id,
      [&gateway](const auto& request, const auto& peer) { return gateway.answer(request, peer); });
  if (!server) {
    gateway.stop();
    return give_up(journal, server.error().text);
  }
  gateway.on_commit([&server](const Result<void>& done) { (*server)->release(done); });
  (*server)->on_close([&gateway](std::uint64_t session) { gateway.session_closed(session); });
  gateway.on_slice([&server](std::uint64_t session) { (*server)->resume(session); });
  gateway.on_begin([&server](std::uint64_t session) { return (*server)->is_gone(session); });
  world.log().on_event([&server](const control::Event& event) { (*server)->publish(event); });
  const int status = loop->run();
  notify("STOPPING=1\nSTATUS=everything is denied");
  gateway.stop();
  if (gateway.is_reading() || group.hangs) std::_Exit(status);  // the thread may hang
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  keep_standard_streams();
  // The loop uses what a thread has read. With separate arenas, memory that is returned to the
  // arena of a thread could not be used by others, up to a fifth of all memory
  // (docs/reference/limits.md).
  ::mallopt(M_ARENA_MAX, 1);
  std::set_new_handler(out_of_memory);
  std::set_terminate(ended_by_an_exception);
  // A file that must not grow makes the write fail, and must not end the gateway.
  // NOLINTBEGIN(cert-err33-c): they cannot fail for a known signal
  ::signal(SIGXFSZ, SIG_IGN);
  ::signal(SIGPIPE, SIG_IGN);  // a log without a reader
  // NOLINTEND(cert-err33-c)
  ::umask(S_IRWXG | S_IRWXO);  // new files are for their user only, unless stated otherwise
  const Parsed parsed = parse_options(argc, argv);
  if (parsed.exit) return parsed.status;
  if (parsed.options.close_mode) return close_early(parsed.options);
  if (parsed.options.check_only) return check_description(parsed.options);
  return run(parsed.options);
}
