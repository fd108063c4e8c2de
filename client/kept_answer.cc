// SPDX-License-Identifier: BSD-2-Clause
#include "client/kept_answer.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "client/answers.hpp"
#include "control/buffer.hpp"
#include "control/codec.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::client {
namespace {

// Texts that occur often in an answer are encoded in one byte: names of attributes (with the unit)
// by their index, places on the route by theirs, and "end to end". The daemon sends no text that
// begins with one of these control characters.
constexpr char kFirstAttribute = 1;
constexpr char kEndToEnd = 15;
constexpr char kFirstOfRoute = 16;
constexpr std::size_t kMostOfRoute = 16;
constexpr std::string_view kEndToEndText = "end to end";

char octet(char first, std::size_t number) {
  return static_cast<char>(static_cast<std::size_t>(first) + number);
}

void shorten(const std::vector<std::string>& route, control::Row& row) {
  if (row.where == kEndToEndText) {
    row.where.assign(1, kEndToEnd);
  } else if (const auto at = std::ranges::find(route, row.where); at != route.end()) {
    const auto number = static_cast<std::size_t>(at - route.begin());
    if (number < kMostOfRoute) row.where.assign(1, octet(kFirstOfRoute, number));
  }
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const AttributeInfo& known = info(attribute_at(i));
    if (row.attribute != known.name || row.unit != known.unit) continue;
    row.attribute.assign(1, octet(kFirstAttribute, i));
    row.unit.clear();
    return;
  }
}

void lengthen(const std::vector<std::string>& route, Check& check) {
  if (check.where.size() == 1 && check.where.front() == kEndToEnd) check.where = kEndToEndText;
  if (check.where.size() == 1) {
    const auto number = static_cast<std::size_t>(check.where.front() - kFirstOfRoute);
    if (number < std::min(route.size(), kMostOfRoute)) check.where = route[number];
  }
  if (check.attribute.size() != 1) return;
  const auto number = static_cast<std::size_t>(check.attribute.front() - kFirstAttribute);
  if (number >= kAttributes) return;
  check.attribute = info(attribute_at(number)).name;
  check.unit = info(attribute_at(number)).unit;
}

control::Row row_of(const Check& check) {
  return {.where = check.where,
          .attribute = check.attribute,
          .unit = check.unit,
          .required = check.required,
          .provided_known = check.provided.has_value(),
          .provided = check.provided.value_or(0),
          .dynamic = false,
          .outcome = check.fits ? control::Outcome::fit : control::Outcome::unfit,
          .margin = check.margin};
}

control::Channel channel_of(const Delivery& delivery) {
  control::Channel out;
  out.granted = delivery.granted;
  out.publisher = delivery.publisher;
  out.from = delivery.from;
  out.to = delivery.to;
  out.reason = delivery.reason;
  out.set = delivery.set;
  if (!delivery.trouble.empty()) out.troubles.push_back(delivery.trouble);
  out.route = delivery.route;
  out.rows.reserve(delivery.checks.size());
  for (const Check& check : delivery.checks) {
    out.rows.push_back(row_of(check));
    shorten(out.route, out.rows.back());
  }
  return out;
}

}  // namespace

KeptAnswer::KeptAnswer(const std::shared_ptr<const Answer>& answer)
    : state_(answer->state), reason_(answer->reason) {
  if (answer->deliveries.empty()) return;
  if (std::ranges::find(answer->deliveries, reason_, &Delivery::reason) != answer->deliveries.end())
    reason_ = std::string();
  control::Channels all;
  all.channels.reserve(answer->deliveries.size());
  for (const Delivery& delivery : answer->deliveries) all.channels.push_back(channel_of(delivery));
  deliveries_ = control::encode(control::Reply{.id = 0, .body = std::move(all)});
  deliveries_.shrink_to_fit();
}

std::shared_ptr<const Answer> KeptAnswer::get() const {
  auto out = std::make_shared<Answer>();
  if (!deliveries_.empty()) {
    control::Buffer buffer;
    buffer.append(deliveries_);
    if (const auto reply = control::decode_reply(buffer); reply && *reply)
      if (auto answer = answer_of(**reply)) *out = std::move(*answer);
  }
  for (Delivery& delivery : out->deliveries)
    for (Check& check : delivery.checks) lengthen(delivery.route, check);
  out->state = state_;
  if (out->deliveries.empty() || !reason_.empty()) out->reason = reason_;
  return out;
}

}  // namespace mlcca::client
