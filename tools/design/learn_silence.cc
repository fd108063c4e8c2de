// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/learn_silence.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

#include "base/clock.hpp"
#include "base/many.hpp"
#include "base/standard_streams.hpp"
#include "control/client.hpp"
#include "tools/learn/live.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::uint64_t kOneSecond = 1'000'000'000;  // ns

}  // namespace

std::optional<control::Status> status_of_daemon(const std::string& socket) {
  auto client = control::Client::connect(socket, std::chrono::seconds{1});
  if (!client) return std::nullopt;
  auto reply = client->call({0, control::StatusRequest{}});
  auto* const status = reply ? std::get_if<control::Status>(&reply->body) : nullptr;
  if (status == nullptr) return std::nullopt;
  return std::move(*status);
}

void Received::begin(const std::vector<std::string>& interfaces) {
  for (const std::string& name : interfaces)
    if (learn::medium_of(name) == learn::Medium::can)
      before_.emplace(name, learn::received_on(name));
}

std::uint64_t Received::unseen_on(const std::string& interface) const {
  const auto before = before_.find(interface);
  const std::uint64_t now = learn::received_on(interface);
  return before == before_.end() || now < before->second ? 0 : now - before->second;
}

std::string reason_of_silence(const std::string& interface, bool is_up, std::uint64_t received,
                              const std::optional<control::Status>& status) {
  if (!is_up) return interface + ": it is down, so nothing comes";
  const bool enforces = status && status->mode != "audit" &&
                        std::ranges::any_of(status->interfaces, [&](const control::Interface& one) {
                          return one.name == interface && one.attached;
                        });
  if (enforces)
    return interface +
           ": a gate enforces there, and drops what is not admitted before it is seen: learn in "
           "audit mode (mlccactl mode audit)";
  if (received == 0) return interface + ": nothing came while it was listened to";
  return fmt::format(
      "{}: {} came in, and a filter in the kernel dropped {} before a program could see {}{}",
      interface, many(received, "frame"), received == 1 ? "it" : "them",
      received == 1 ? "it" : "them",
      status
          ? ": mlccactl status says what is in force there"
          : ". mlccad does not answer: without it its gates are closed, also after it was "
            "stopped. Start it in audit mode (mlccad --initial-mode audit), or learn where there "
            "is no gate");
}

Listening::Listening(std::uint64_t ns)
    : shows_(::isatty(STDERR_FILENO) != 0), end_(monotonic_ns() + ns) {}

Listening::~Listening() {
  if (shows_ && next_ != 0) to_stderr("\r\033[K");
}

void Listening::show() {
  const std::uint64_t now = monotonic_ns();
  if (!shows_ || now < next_) return;
  next_ = now + kOneSecond;
  to_stderr("\r\033[K" + line(frames_, end_ - std::min(now, end_)));
}

std::string Listening::line(std::uint64_t frames, std::uint64_t left_ns) {
  return fmt::format("{} so far, {} s left", many(frames, "frame"), left_ns / kOneSecond);
}

}  // namespace mlcca::tools::design
