// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/bus_broker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "base/big_endian.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;

}  // namespace

Result<BusBroker> BusBroker::make(const Uid& uid, DealtFile file, Stated stated, Log log) {
  std::vector<NodeBroker::Dealt> nodes;
  for (const auto& [of, number] : file.nodes())
    nodes.emplace_back(big_endian(of), static_cast<NodeNumber>(number));
  std::vector<TagBroker::Dealt> tags(file.tags().begin(), file.tags().end());
  for (const auto& [subject, tag] : stated) {
    const auto clashes = [&](const auto& dealt) {
      return (dealt.first == subject) != (dealt.second == tag);
    };
    if (const auto other = std::ranges::find_if(tags, clashes); other != tags.end())
      return fail(fmt::format(
          "tag {:#x} of {:#018x} cannot be dealt: before, tag {:#x} was dealt to {:#018x}. Stop "
          "all nodes of the bus, and remove the file of what was dealt",
          tag, subject, other->second, other->first));
    tags.emplace_back(subject, tag);
  }
  BusBroker out(uid, std::move(file), nodes, tags, std::move(log));
  if (auto done = out.write_down(); !done) return std::unexpected(done.error());
  return out;
}

/// Stores the assignments that were made since the last call.
Result<void> BusBroker::write_down() {
  while (file_.nodes().size() < nodes_.dealt().size()) {
    const auto& [uid, number] = nodes_.dealt()[file_.nodes().size()];
    if (auto done = file_.add_node(from_big_endian(uid), number); !done) return done;
    log_(fmt::format("node {:#x} is {:#018x}", number, from_big_endian(uid)));
  }
  while (file_.tags().size() < tags_.dealt().size()) {
    const auto& [subject, tag] = tags_.dealt()[file_.tags().size()];
    if (auto done = file_.add_tag(subject, tag); !done) return done;
    log_(fmt::format("tag {:#x} is of {:#018x}", tag, subject));
  }
  return {};
}

bool BusBroker::may_answer(std::uint64_t now) {
  if (now - second_ >= kSecond) {
    second_ = now;
    answered_ = 0;
  }
  return ++answered_ <= kMostPerSecond;
}

/// A node that gets no answer asks without end, so each is logged once.
void BusBroker::say_what_is_used_up() {
  const auto say = [this](const std::string& what) {
    log_(what +
         " are assigned. To assign them again, stop all nodes of the bus and this program, and "
         "remove " +
         file_.path());
  };
  if (const auto& uid = nodes_.without_number(); uid && std::exchange(says_numbers_, false))
    say(fmt::format("node {:#018x} gets no number, since all", from_big_endian(*uid)));
  if (const auto subject = tags_.without_tag(); subject && std::exchange(says_tags_, false))
    say(fmt::format("{:#018x} gets no tag, since all", *subject));
}

std::vector<Frame> BusBroker::take(const Frame& frame, std::uint64_t now) {
  if (!may_answer(now)) return {};
  std::vector<Frame> out;
  if (const auto answer = nodes_.take(frame, now)) out.push_back(*answer);
  if (const auto answer = tags_.take(frame)) out.insert(out.end(), answer->begin(), answer->end());
  say_what_is_used_up();
  const auto written = write_down();
  const std::string trouble = written ? "" : written.error().text;
  if (trouble != std::exchange(trouble_, trouble) && !trouble.empty())
    log_("not answered, since it cannot be written down: " + trouble);
  if (!written) out.clear();
  return out;
}

}  // namespace mlcca::relay
