// SPDX-License-Identifier: BSD-2-Clause
#include "tools/requests.hpp"

#include <fmt/format.h>
#include <pwd.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/number.hpp"
#include "mlcca/arithmetic.hpp"
#include "tools/times.hpp"
#include "tools/values.hpp"

namespace mlcca::tools {
namespace {

using Parse = Result<control::Attribute>(std::string_view, Role);

Result<std::vector<control::Attribute>> attributes(const std::vector<std::string>& texts, Role role,
                                                   Parse& parse) {
  std::vector<control::Attribute> result;
  for (const auto& text : texts) {
    auto attribute = parse(text, role);
    if (!attribute) return std::unexpected(std::move(attribute).error());
    if (std::ranges::find(result, attribute->name, &control::Attribute::name) != result.end())
      return fail(fmt::format("{}: {} is given twice", text, attribute->name));
    result.push_back(std::move(*attribute));
  }
  return result;
}

/// The number of a user. The daemon does not resolve names for clients, because a directory service
/// that hangs would delay it.
Result<std::string> user_number(const std::string& user) {
  if (user.find_first_not_of("0123456789") == std::string::npos) return user;
  std::vector<char> buffer(std::size_t{1} << 20);
  passwd entry{};
  passwd* found = nullptr;
  const int error = ::getpwnam_r(user.c_str(), &entry, buffer.data(), buffer.size(), &found);
  if (error != 0)
    return fail(fmt::format("--user '{}' cannot be looked up ({}); a number needs no look-up", user,
                            std::strerror(error)));  // NOLINT(concurrency-mt-unsafe)
  if (found == nullptr) return fail(fmt::format("there is no user '{}'", user));
  return std::to_string(found->pw_uid);
}

/// Parses "robot-can=0x123" or "robot-can=101".
Result<control::Identifier> identifier(const std::string& text) {
  const auto equals = text.rfind('=');
  const auto wrong = [&] {
    return fail(
        fmt::format("--identifier '{}': must be NETWORK=ID, such as robot-can=0x123", text));
  };
  if (equals == std::string::npos || equals == 0) return wrong();
  const std::string_view number = std::string_view(text).substr(equals + 1);
  const auto id = prefixed_number_in<std::uint32_t>(number);
  if (!id) return wrong();
  constexpr std::size_t standard_digits = std::string_view("0x7ff").size();
  constexpr std::uint32_t last_standard = 0x7ff;
  const bool is_long = number.starts_with("0x") && number.size() > standard_digits;
  return control::Identifier{
      .network = text.substr(0, equals), .id = *id, .extended = *id > last_standard || is_long};
}

Result<std::vector<control::Identifier>> identifiers(const std::vector<std::string>& texts) {
  std::vector<control::Identifier> out;
  for (const auto& text : texts) {
    auto one = identifier(text);
    if (!one) return std::unexpected(std::move(one).error());
    out.push_back(std::move(*one));
  }
  return out;
}

Result<control::ChannelRequest> delivery(const Arguments& from) {
  auto required = attributes(from.require, Role::required, parse_stated);
  if (!required) return std::unexpected(std::move(required).error());
  auto offered = attributes(from.offer, Role::offered, parse_stated);
  if (!offered) return std::unexpected(std::move(offered).error());
  if (from.subject.empty() && !from.identifiers.empty())
    return fail("--identifier goes with --subject: other channels are described");
  auto named = identifiers(from.identifiers);
  if (!named) return std::unexpected(std::move(named).error());
  auto user = user_number(from.user);
  if (!user) return std::unexpected(std::move(user).error());
  return control::ChannelRequest{.channel = from.subject.empty() ? from.channel : from.subject,
                                 .from = from.from,
                                 .to = from.to,
                                 .offered = std::move(*offered),
                                 .required = std::move(*required),
                                 .node = from.node,
                                 .priority = from.priority,
                                 .user = std::move(*user),
                                 .subscriber = from.subscriber,
                                 .publisher = from.publisher,
                                 .from_node = from.from_node,
                                 .to_node = from.to_node,
                                 .unlisted = !from.subject.empty(),
                                 .identifiers = std::move(*named),
                                 .address = from.address};
}

Result<std::uint64_t> lease(const Arguments& from) {
  if (from.lease.empty())
    return from.hold ? static_cast<std::uint64_t>(kHoldLease.count()) : std::uint64_t{0};
  auto span = parse_span(from.lease);
  if (!span) return fail("--lease " + span.error().text);
  if (*span == 0) return fail(fmt::format("--lease '{}': must be more than 0", from.lease));
  return span;
}

/// Parses the rate of a link. It is rounded down, to the worse side for a channel.
Result<std::uint64_t> link_rate(std::string_view text) {
  return text == "0" ? std::uint64_t{0} : parse_bit_rate(text, Rounding::down);
}

Result<control::LinkChange> link_change(std::string_view text) {
  const auto wrong = [&](std::string_view why) {
    return fail(fmt::format("--link '{}': {}", text, why));
  };
  const auto equals = text.find('=');
  const auto ends = text.substr(0, equals);
  const auto slash = ends.find('/');
  const auto nodes = ends.substr(slash == std::string_view::npos ? 0 : slash + 1);
  const auto comma = nodes.find(',');
  if (equals == std::string_view::npos || comma == std::string_view::npos || comma == 0 ||
      comma + 1 == nodes.size() || slash == 0)
    return wrong("must be FROM,TO=RATE or NETWORK/FROM,TO=RATE, such as laptop,relay=6Mbit/s");
  const auto rate = link_rate(text.substr(equals + 1));
  if (!rate) return wrong(rate.error().text + "; 0 stands for a link that is gone");
  return control::LinkChange{
      .network = std::string(ends.substr(0, slash == std::string_view::npos ? 0 : slash)),
      .from = std::string(nodes.substr(0, comma)),
      .to = std::string(nodes.substr(comma + 1)),
      .rate = *rate};
}

/// Parses the moment of an option; 0 if it is not given.
Result<std::uint64_t> moment(std::string_view option, const std::string& text, std::uint64_t now) {
  if (text.empty()) return std::uint64_t{0};
  auto result = parse_moment(text, now);
  if (!result) return fail(fmt::format("{} {}", option, result.error().text));
  return result;
}

}  // namespace

Result<control::Query> query(const Arguments& from) {
  auto request = delivery(from);
  if (!request) return std::unexpected(std::move(request).error());
  return control::Query{std::move(*request)};
}

Result<control::AnnounceRequest> announce(const Arguments& from) {
  const bool publishes = from.role == "publisher";
  auto stated = attributes(from.state, publishes ? Role::offered : Role::required, parse_attribute);
  if (!stated) return std::unexpected(std::move(stated).error());
  return control::AnnounceRequest{
      .channel = from.channel,
      .role = publishes ? control::Role::publisher : control::Role::subscriber,
      .name = from.end,
      .attributes = std::move(*stated)};
}

Result<control::Admit> admit(const Arguments& from) {
  auto request = delivery(from);
  if (!request) return std::unexpected(std::move(request).error());
  const auto lease_ns = lease(from);
  if (!lease_ns) return std::unexpected(lease_ns.error());
  request->key = from.key;
  request->lease_ns = *lease_ns;
  request->hold = from.hold;
  return control::Admit{std::move(*request)};
}

Result<control::WhatIfRequest> what_if(const Arguments& from) {
  control::WhatIfRequest request;
  for (const auto& text : from.links) {
    auto change = link_change(text);
    if (!change) return std::unexpected(std::move(change).error());
    change->one_way = from.one_way;
    request.links.push_back(std::move(*change));
  }
  request.without = from.without;
  return request;
}

Result<control::ClusterRequest> cluster(const Arguments& from) {
  const bool reads = from.part == "status" || from.part == "members";
  if (from.check && from.part != "status") return fail("--check goes with status alone");
  if (from.yes && from.part != "drain") return fail("--yes goes with drain alone");
  if (from.until_restart && from.part != "drain")
    return fail("--until-restart goes with drain alone");
  if (!from.network.empty() && from.part != "reservations")
    return fail("--network goes with reservations alone");
  if (!from.gateway.empty() && reads)
    return fail(fmt::format("cluster {} is of all gateways: '{}' is one too many", from.part,
                            from.gateway));
  return control::ClusterRequest{.part = from.part == "status" ? "" : from.part,
                                 .network = from.network,
                                 .gateway = from.gateway};
}

Result<control::ModeRequest> mode(const Arguments& from) {
  control::ModeRequest request{.mode = from.mode};
  if (from.when_clean.empty()) return request;
  const auto span = parse_span(from.when_clean);
  if (!span) return fail("--when-clean: " + span.error().text);
  if (*span == 0) return fail("--when-clean: without it the gates enforce at once");
  request.when_clean_ns = *span;
  return request;
}

Result<control::HistoryRequest> history(const Arguments& from, std::uint64_t now_unix_ns) {
  const auto since = moment("--since", from.since, now_unix_ns);
  if (!since) return std::unexpected(since.error());
  const auto until = moment("--until", from.until, now_unix_ns);
  if (!until) return std::unexpected(until.error());
  if (!from.until.empty() && *until < *since)
    return fail(fmt::format("--until '{}' is before --since '{}'", from.until, from.since));
  return control::HistoryRequest{.channel = from.channel,
                                 .kind = from.kind,
                                 .since_unix_ns = *since,
                                 .until_unix_ns = *until,
                                 .limit = from.limit};
}

}  // namespace mlcca::tools
