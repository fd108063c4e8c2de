// SPDX-License-Identifier: BSD-2-Clause
// mlcca-sources: reads one source whose data untrusted peers write, and sends facts to mlccad.
// Standard input is a connection to mlccad (daemon/net/sources/facts.hpp); the process ends with
// it.
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <systemd/sd-event.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <deque>
#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "base/at_once.hpp"
#include "base/loop_timer.hpp"
#include "base/standard_streams.hpp"
#include "base/system_error.hpp"
#include "base/throttle.hpp"
#include "daemon/net/sources/facts.hpp"
#include "tools/sources/open.hpp"
#include "tools/sources/peer.hpp"
#include "tools/sources/sandbox.hpp"

namespace mlcca::sources {
namespace {

using net::facts::Message;

constexpr int kConversation = STDIN_FILENO;
constexpr int kPatience = 10'000;  // ms to wait for the question

void say(const std::string& text) { write_at_once(STDERR_FILENO, "mlcca-sources: " + text + '\n'); }

Result<net::facts::Question> read_question() {
  net::facts::QuestionReader reader;
  std::array<char, net::facts::kMaxMessage> buffer{};
  for (;;) {
    pollfd readable{.fd = kConversation, .events = POLLIN, .revents = 0};
    const int ready = ::poll(&readable, 1, kPatience);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return fail("no request says what to watch");
    const auto size = ::recv(kConversation, buffer.data(), buffer.size(), 0);
    if (size < 0) return system_error("standard input is to be a socket");
    if (size == 0) return fail("no request says what to watch");
    auto question = reader.take({buffer.data(), static_cast<std::size_t>(size)});
    if (!question) return std::unexpected(question.error());
    if (*question) return std::move(**question);
  }
}

/// Sends snapshots one after another. While one waits for mlccad to read, only the latest further
/// one is kept.
class Answers {
 public:
  Result<void> start(sd_event* loop) {
    sd_event_source* raw = nullptr;
    if (const int e = sd_event_add_io(loop, &raw, kConversation, EPOLLRDHUP, on_io, this); e < 0)
      return system_error("watching the conversation", -e);
    io_.reset(raw);
    loop_ = loop;
    return {};
  }

  void take(core::mesh::Snapshot snapshot) {
    latest_ = std::move(snapshot);
    go_on();
  }

 private:
  static int on_io(sd_event_source*, int, std::uint32_t events, void* self) noexcept {
    auto& answers = *static_cast<Answers*>(self);
    if ((events & ~EPOLLOUT) != 0)
      sd_event_exit(answers.loop_, 0);
    else
      answers.go_on();
    return 0;
  }

  void go_on() {
    while (!messages_.empty() || latest_) {
      if (messages_.empty()) {
        const auto answer = net::facts::answer(*std::exchange(latest_, std::nullopt));
        messages_.assign(answer.begin(), answer.end());
      }
      const Message& next = messages_.front();
      if (::send(kConversation, next.data(), next.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
        if (errno != EAGAIN && errno != EINTR) sd_event_exit(loop_, 0);
        sd_event_source_set_io_events(io_.get(), EPOLLRDHUP | EPOLLOUT);
        return;
      }
      messages_.pop_front();
    }
    sd_event_source_set_io_events(io_.get(), EPOLLRDHUP);
  }

  sd_event* loop_ = nullptr;
  EventSource io_;
  std::deque<Message> messages_;
  std::optional<core::mesh::Snapshot> latest_;
};

Result<void> serve() {
  if (auto trusted = net::trust_owner_of(kConversation); !trusted) return trusted;
  if (auto entered = enter_sandbox(); !entered) return entered;
  const auto question = read_question();
  if (!question) return std::unexpected(question.error());
  sd_event* raw = nullptr;
  if (const int e = sd_event_new(&raw); e < 0) return system_error("event loop", -e);
  const std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop(raw);
  Answers answers;
  if (auto started = answers.start(raw); !started) return started;
  const auto report = [&answers](core::mesh::Snapshot snapshot) {
    answers.take(std::move(snapshot));
  };
  const auto source = net::open_here(question->source, question->mesh, raw, report);
  // The process goes on without a source, so that the problem stays reported and mlccad does not
  // start another process in vain.
  LoopTimer refused;
  if (!source) {
    const auto report_why = [&] {
      report({.links = {}, .next_hops = {}, .problem = source.error().text});
      refused.set(kPollInterval);
    };
    if (auto started = refused.start(raw, report_why); !started) return started;
  }
  if (const int e = sd_event_loop(raw); e < 0) return system_error("event loop", -e);
  return {};
}

}  // namespace
}  // namespace mlcca::sources

int main(int argc, char**) {
  mlcca::keep_standard_streams();
  ::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): a log without a reader
  if (argc != 1) {
    mlcca::sources::say("usage: mlcca-sources, with a connection to mlccad as standard input");
    return 2;
  }
  try {
    const auto served = mlcca::sources::serve();
    if (served) return 0;
    mlcca::sources::say(served.error().text);
  } catch (const std::exception& e) {
    mlcca::sources::say(e.what());
  }
  return 1;
}
