// SPDX-License-Identifier: BSD-2-Clause
#include "client/kept_answer.hpp"

#include <algorithm>
#include <array>
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

// Texts that occur often in an answer are encoded in one octet, a control character which occurs in
// no text of the daemon. Names of attributes (with the unit) are encoded by their index, and so are
// places on the route. Tab, line feed and carriage return encode nothing.
constexpr char kFirstAttribute = 1;
constexpr char kPublisher = 11;
constexpr char kFirstOfRoute = 16;
constexpr std::size_t kMostOfRoute = 15;

struct Word {
  char octet = 0;
  std::string_view text;
};
constexpr std::array<Word, 4> kPhrases = {
    {{12, "exactly met"}, {14, " to spare"}, {15, "end to end"}, {31, "capacity of "}}};
static_assert(kFirstAttribute + kAttributes <= 9);

char octet(char first, std::size_t number) {
  return static_cast<char>(static_cast<std::size_t>(first) + number);
}

/// The words of one delivery. They refer to `publisher` and `route`, which must not change.
class Words {
 public:
  Words(const std::string& publisher, const std::vector<std::string>& route)
      : all_(kPhrases.begin(), kPhrases.end()) {
    all_.push_back({kPublisher, publisher});
    for (std::size_t i = 0; i < std::min(route.size(), kMostOfRoute); ++i)
      all_.push_back({octet(kFirstOfRoute, i), route[i]});
  }

  void shorten(std::string& text) const {
    for (const Word& word : all_) {
      const auto at = word.text.size() > 1 ? text.find(word.text) : std::string::npos;
      if (at != std::string::npos) text.replace(at, word.text.size(), 1, word.octet);
    }
  }
  void lengthen(std::string& text) const {
    for (const Word& word : all_)
      if (const auto at = text.find(word.octet); at != std::string::npos)
        text.replace(at, 1, word.text);
  }

 private:
  std::vector<Word> all_;
};

void shorten(const Words& words, control::Row& row) {
  words.shorten(row.where);
  words.shorten(row.margin);
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const AttributeInfo& known = info(attribute_at(i));
    if (row.attribute != known.name || row.unit != known.unit) continue;
    row.attribute.assign(1, octet(kFirstAttribute, i));
    row.unit.clear();
    return;
  }
}

void lengthen(const Words& words, Check& check) {
  words.lengthen(check.where);
  words.lengthen(check.margin);
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
  if (!delivery.problem.empty()) out.problems.push_back(delivery.problem);
  out.route = delivery.route;
  const Words words(out.publisher, out.route);
  for (std::string* place : {&out.from, &out.to}) words.shorten(*place);
  out.rows.reserve(delivery.checks.size());
  for (const Check& check : delivery.checks) {
    out.rows.push_back(row_of(check));
    shorten(words, out.rows.back());
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
  for (Delivery& delivery : out->deliveries) {
    const Words words(delivery.publisher, delivery.route);
    for (std::string* place : {&delivery.from, &delivery.to}) words.lengthen(*place);
    for (Check& check : delivery.checks) lengthen(words, check);
  }
  out->state = state_;
  if (out->deliveries.empty() || !reason_.empty()) out->reason = reason_;
  return out;
}

}  // namespace mlcca::client
