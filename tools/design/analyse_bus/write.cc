// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/analyse_bus/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <ranges>

#include "base/many.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

using core::BusFate;
using Json = nlohmann::ordered_json;

constexpr std::uint64_t kMicrosecond = 1'000;  // ns
constexpr double kWhole = 1e6;                 // per unit of 1e-6
constexpr int kFormVersion = 1;                // version of the JSON

std::string in_us(std::uint64_t ns) {
  if (ns == core::can::kNever) return "-";
  return fmt::format("{}.{:03}", ns / kMicrosecond, ns % kMicrosecond);
}

std::string slack_of(std::uint64_t deadline, std::uint64_t response) {
  return deadline >= response ? in_us(deadline - response) : "-" + in_us(response - deadline);
}

std::string identifier_of(const BusMessage& m) {
  if (!m.tag_known) return "tag not known";
  return m.extended ? fmt::format("0x{:08x}", m.id) : fmt::format("0x{:03x}", m.id);
}

double as_us(std::uint64_t ns) {
  return static_cast<double>(ns) / static_cast<double>(kMicrosecond);
}

/// Microseconds; null without a bound.
Json us_or_null(std::uint64_t ns) {
  return ns == core::can::kNever ? Json(nullptr) : Json(as_us(ns));
}

/// The queue of a gateway; nullptr for a node's own, and for a FIFO whose length is not stated.
const core::can::Queue* queue_of(const AnalysedBus& analysed, std::size_t i) {
  const auto& queues = analysed.bus.assumptions.queues;
  const auto queue = analysed.bus.messages[i].message.queue;
  return queue < queues.size() ? &queues[queue] : nullptr;
}
bool has_length(const core::can::Queue& queue) {
  return queue.length != std::numeric_limits<std::uint32_t>::max();
}

/// The response time in us; "-" if there is none.
std::string response_of(const core::BusRow& row) {
  return row.response ? in_us(*row.response) : "-";
}

bool has_bound(const core::BusRow& row) {
  return row.response && *row.response != core::can::kNever;
}

std::string verdict_of(const AnalysedBus& analysed, std::size_t i) {
  switch (analysed.rows[i].fate) {
    case BusFate::met:
      return analysed.by_admission[i] ? "by admission" : "";
    case BusFate::late:
      return "late";
    case BusFate::not_bounded:
      return "not bounded";
    case BusFate::queue_too_short: {
      const auto* const queue = queue_of(analysed, i);
      return fmt::format("queue too short: {} of {}", queue == nullptr ? 0 : queue->length,
                         analysed.rows[i].frames.value_or(0));
    }
    case BusFate::refused_for_others:
      return "refused for others";
    case BusFate::refused:
      return "refused by check";
    case BusFate::run_time:
      return "at run time, in place of others";
  }
  return {};
}

/// The response time that check computed beside the messages that it grants, if it differs from
/// this one; otherwise empty.
std::string checked_of(const BusMessage& m, const core::BusRow& row) {
  const auto checked = m.granted_response ? m.granted_response : m.refused_response;
  if (!checked || checked == row.response) return {};
  return *checked == core::can::kNever ? "no bound" : in_us(*checked);
}

std::string_view word_of(BusFate fate) {
  switch (fate) {
    case BusFate::met:
      return "met";
    case BusFate::refused:
      return "refused-by-check";
    case BusFate::late:
      return "late";
    case BusFate::not_bounded:
      return "not-bounded";
    case BusFate::queue_too_short:
      return "queue-too-short";
    case BusFate::run_time:
      return "run-time";
    case BusFate::refused_for_others:
      break;
  }
  return "refused";
}

std::string_view word_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::fit:
      return "fit";
    case Outcome::run_time:
      return "run-time";
    case Outcome::unfit:
      break;
  }
  return "unfit";
}

bool has_short_queue(const AnalysedBus& analysed) {
  for (std::size_t i = 0; i < analysed.responses.size(); ++i)
    if (const auto* queue = queue_of(analysed, i);
        queue != nullptr && analysed.bus.messages[i].standing.counted &&
        analysed.responses[i].bounded && analysed.responses[i].queued_frames > queue->length)
      return true;
  return false;
}

bool is_late_though_granted(const AnalysedBus& analysed, std::size_t i) {
  const BusMessage& m = analysed.bus.messages[i];
  return m.held && m.granted_response && !analysed.responses[i].meets(m.sent().deadline);
}

/// Whether a granted message is late beside everything that is sent if all best cases are real.
bool is_late_at_best(const AnalysedBus& analysed) {
  std::vector<core::can::Message> present;
  std::vector<bool> late;
  for (std::size_t i = 0; i < analysed.responses.size(); ++i) {
    const BusMessage& m = analysed.bus.messages[i];
    if (!m.present) continue;
    present.push_back(m.sent());
    late.push_back(is_late_though_granted(analysed, i));
  }
  const auto responses = analyse(analysed.bus.assumptions, present);
  for (std::size_t i = 0; i < present.size(); ++i)
    if (late[i] && !responses[i].meets(present[i].deadline)) return true;
  return false;
}

/// Why check grants a message that is late here.
std::string why_granted(const AnalysedBus& analysed) {
  if (is_late_at_best(analysed))
    return "mlccactl check grants a message that is late here: it counts what it refuses as "
           "silent, "
           "but no gate is between a bus and its own nodes.\n";
  const std::string text =
      "mlccactl check grants a message that is late here beside what may be granted in the place "
      "of others: ";
  if (std::ranges::any_of(analysed.bus.messages, [](const BusMessage& m) {
        return m.several && m.standing.counted && m.outcome != Outcome::fit;
      }))
    return text +
           "what goes to several places is decided for each of them, and its deadline here is that "
           "of the strictest, which holds only while that place is granted.\n";
  return text + "a node of the bus that is refused at run time sends all the same.\n";
}

/// The assumptions of the response times of a described bus, as far as they matter for its
/// messages.
std::string assumed_text(const AnalysedBus& analysed) {
  bool differs = false;
  bool dropped = false;
  bool competes = false;
  bool by_admission = false;
  bool late_though_granted = false;
  for (std::size_t i = 0; i < analysed.responses.size(); ++i) {
    const BusMessage& m = analysed.bus.messages[i];
    differs = differs || !checked_of(m, analysed.rows[i]).empty();
    dropped = dropped || !m.standing.counted;
    competes = competes || (m.standing.counted && !m.present);
    by_admission = by_admission || analysed.by_admission[i];
    late_though_granted = late_though_granted || is_late_though_granted(analysed, i);
  }
  std::string text;
  if (differs)
    text +=
        "Check us counts what mlccactl check grants, and the message of the row. Response us also "
        "counts what the bus's own nodes send although it is refused.\n";
  if (late_though_granted) text += why_granted(analysed);
  if (dropped)
    text +=
        "What is refused and comes from another network is dropped before this bus. Its row has "
        "the time that mlccactl check refuses it for, or none.\n";
  if (competes)
    text +=
        "Response us also counts what may be granted in the place of others, as if all of it came "
        "at once.\n";
  if (by_admission)
    text +=
        "By admission: the response is the deadline, or less. A gateway grants nothing beside "
        "which "
        "a granted message would be late, and the analysis has no smaller bound.\n";
  return text;
}

/// A phrase about the deadlines of the messages that count.
std::string deadlines_of(const AnalysedBus& analysed) {
  const auto& all = analysed.bus.messages;
  if (!all.empty() && std::ranges::none_of(all, [](const auto& m) { return m.standing.counted; }))
    return "no message is admitted";
  if (analysed.late) return "a deadline can be missed";
  if (!analysed.bus.sure) return "whether every deadline is met is not known";
  return "every deadline is met";
}

/// A sentence about the bus, behind its load.
std::string summary_of(const AnalysedBus& analysed) {
  const bool queue = has_short_queue(analysed);
  std::string text = deadlines_of(analysed);
  if (analysed.met_alone) text += " only while what is not counted is silent";
  if (queue)
    text += ", and frames can be lost in a queue that is too short";
  else if (analysed.kept_alone)
    text += ", and no frame is lost in a queue only while what is not counted is silent";
  if (const auto refused = refused_by_check(analysed); refused != 0)
    text += fmt::format(", {} mlccactl check refuses {}", analysed.late || queue ? "and" : "but",
                        many(refused, "message"));
  return text;
}

/// Sentences why an order of priorities may exist although none was found. Empty: there is none.
std::vector<std::string> order_may_exist(const AnalysedBus& analysed) {
  std::vector<std::string> why;
  const auto& messages = analysed.bus.messages;
  const bool searched_whole = std::ranges::all_of(messages, [](const BusMessage& m) {
    return m.message.queue == core::can::kOwnQueue && m.message.frames == 1;
  });
  if (!searched_whole)
    why.emplace_back(
        "One may exist: for messages that wait in a queue of a gateway or of a node, and for "
        "events "
        "of several frames, the search is on the safe side.");
  for (const BusMessage& m : messages)
    if (m.from_elsewhere && m.message.jitter > 0)
      why.push_back(fmt::format(
          "{} comes here from another network with a jitter {}. A better order of the identifiers "
          "there can lessen that: change that bus first, then analyse again.",
          printable(m.name),
          m.message.jitter == core::can::kNever
              ? "that is not bounded"
              : fmt::format("of {} us", in_us(m.message.jitter))));
  return why;
}

std::string order_text(const AnalysedBus& analysed) {
  if (!analysed.order) {
    const auto why = order_may_exist(analysed);
    if (why.empty())
      return "There is no order of the identifiers in which all deadlines are met.\n";
    std::string text =
        "No order of the identifiers was found in which all deadlines are met, with these "
        "jitters.\n";
    for (const std::string& sentence : why) text += sentence + '\n';
    return text;
  }
  std::string text =
      "In this order of the identifiers, highest priority first, all deadlines are met:\n";
  for (const std::size_t i : *analysed.order)
    text += fmt::format("  {}\n", printable(analysed.bus.messages[i].name));
  return text;
}

std::string sentences(std::string_view title, const std::vector<std::string>& all) {
  if (all.empty()) return {};
  constexpr std::size_t most = 20;
  std::string text = fmt::format("{}\n", title);
  for (const auto& one : all | std::views::take(most))
    text += fmt::format("  {}\n", printable(one));
  if (all.size() > most) text += fmt::format("  and {} more\n", all.size() - most);
  return text;
}

/// Names the events whose size is not stated.
std::string sizes_text(const Bus& bus) {
  std::vector<std::string> names;
  for (const BusMessage& m : bus.messages)
    if (!m.bytes) names.push_back(m.name);
  return sentences(
      "No MaxPayload is stated of these; their events count as one frame, the longest "
      "of the Binding:",
      names);
}

std::string load_text(const core::BusLoad& load) {
  const auto percent = [](std::uint64_t ppm) { return static_cast<double>(ppm) * 100 / kWhole; };
  std::string text = fmt::format("Bus load {:.2f} %", percent(load.present));
  if (load.at_most != load.present)
    text += fmt::format(", up to {:.2f} % with what may be granted in the place of others,",
                        percent(load.at_most));
  return text;
}

std::string bus_text(const AnalysedBus& analysed, Color color) {
  const Bus& bus = analysed.bus;
  std::string text;
  if (!bus.network.empty()) text += fmt::format("Network {}\n", printable(bus.network));
  if (!bus.why_not.empty()) return text + sentences("Not analysed:", bus.why_not);
  TextTable table({{"Message"},
                   {"Identifier", Align::right},
                   {"Frame us", Align::right},
                   {"Jitter us", Align::right},
                   {"Check us", Align::right},
                   {"Response us", Align::right},
                   {"Deadline us", Align::right},
                   {"Slack us", Align::right},
                   {""}});
  for (std::size_t i = 0; i < bus.messages.size(); ++i) {
    const BusMessage& m = bus.messages[i];
    const core::can::Message& sent = m.sent();
    const core::BusRow& row = analysed.rows[i];
    const Style style = row.fate == BusFate::met ? Style::plain : Style::bad;
    table.add({{m.name},
               {identifier_of(m)},
               {in_us(sent.longest_frame)},
               {row.jitter == 0 ? "" : in_us(row.jitter)},
               {checked_of(m, row)},
               {response_of(row), style},
               {in_us(sent.deadline)},
               {has_bound(row) ? slack_of(sent.deadline, *row.response) : "-", style},
               {verdict_of(analysed, i), style}});
  }
  if (table.empty())
    text += bus.left_out.empty()
                ? "Nothing that is described sends here.\n"
                : "What is described here has no subscriber, and is not counted.\n";
  else
    text += table.text(color);
  text += load_text(analysed.load) + " at " + print_bitrate(bus.assumptions.timing.bitrate);
  if (bus.assumptions.timing.data_bitrate != 0)
    text +=
        fmt::format(", {} in the data phase", print_bitrate(bus.assumptions.timing.data_bitrate));
  text += fmt::format(": {}\n", summary_of(analysed));
  text += assumed_text(analysed);
  text += sizes_text(bus);
  if (!analysed.why_unbounded.empty()) text += analysed.why_unbounded + "\n";
  text +=
      sentences("Not known:", bus.unknown) + sentences("Not counted:", bus.left_out) +
      sentences(bus.has_options
                    ? "With these options in the description 'mlccactl check' would refuse "
                      "these; their times are beside the messages that it would grant:"
                    : "'mlccactl check' refuses these; their times are beside the messages that "
                      "it grants:",
                bus.findings);
  if (analysed.assigned) text += order_text(analysed);
  return text;
}

Json message_json(const AnalysedBus& analysed, std::size_t i) {
  const BusMessage& m = analysed.bus.messages[i];
  const core::can::Message& sent = m.sent();
  const core::BusRow& row = analysed.rows[i];
  Json out{{"name", m.name},
           {"id", m.tag_known ? Json(m.id) : Json(nullptr)},
           {"extended", m.extended},
           {"bytes", m.bytes ? Json(*m.bytes) : Json(nullptr)},
           {"frames", sent.frames},
           {"frame_time_us", as_us(sent.longest_frame)},
           {"response_us", nullptr},
           {"deadline_us", us_or_null(sent.deadline)},
           {"slack_us", nullptr},
           {"period_us", as_us(sent.period)},
           {"jitter_us", us_or_null(row.jitter)},
           {"schedulable", static_cast<bool>(analysed.fit[i])},
           {"verdict", word_of(row.fate)}};
  if (m.granted) {
    out["granted"] = *m.granted;
    out["outcome"] = word_of(m.outcome);
    out["counted"] = m.standing.counted;
    out["by_admission"] = static_cast<bool>(analysed.by_admission[i]);
  }
  if (m.granted_response) {
    out["granted_response_us"] = as_us(*m.granted_response);
    out["granted_on_bus_us"] = as_us(m.granted_on_bus);
  }
  if (m.refused_response) {
    out["refused_response_us"] = us_or_null(*m.refused_response);
  }
  if (!m.node.empty()) out["node"] = m.node;
  if (const auto* queue = queue_of(analysed, i)) {
    out["queue"] = Json::object();
    out["queue"]["frames"] = nullptr;
    if (row.frames) out["queue"]["frames"] = *row.frames;
    if (has_length(*queue)) out["queue"]["length"] = queue->length;
  }
  if (has_bound(row)) {
    const std::uint64_t response = *row.response;
    out["on_bus_us"] = as_us(response - std::min(response, row.jitter));
    out["response_us"] = as_us(response);
    out["slack_us"] = sent.deadline >= response ? as_us(sent.deadline - response)
                                                : -as_us(response - sent.deadline);
  }
  return out;
}

Json bus_json(const AnalysedBus& analysed) {
  const Bus& bus = analysed.bus;
  Json out{{"network", bus.network.empty() ? Json(nullptr) : Json(bus.network)}};
  if (!bus.why_not.empty()) {
    out["schedulable"] = false;
    out["not_analysed"] = bus.why_not;
    out["messages"] = Json::array();
    return out;
  }
  out["bitrate"] = bus.assumptions.timing.bitrate;
  if (bus.assumptions.timing.data_bitrate != 0)
    out["data_bitrate"] = bus.assumptions.timing.data_bitrate;
  out["bus_load"] = static_cast<double>(analysed.load.present) / kWhole;
  out["bus_load_at_most"] = static_cast<double>(analysed.load.at_most) / kWhole;
  out["schedulable"] = analysed.schedulable;
  if (!analysed.why_unbounded.empty()) out["not_bounded"] = analysed.why_unbounded;
  if (!bus.unknown.empty()) out["unknown"] = bus.unknown;
  if (!bus.left_out.empty()) out["not_counted"] = bus.left_out;
  if (!bus.findings.empty()) out["findings"] = bus.findings;
  out["messages"] = Json::array();
  for (std::size_t i = 0; i < bus.messages.size(); ++i)
    out["messages"].push_back(message_json(analysed, i));
  if (!analysed.assigned) return out;
  out["assignment"] = nullptr;
  if (!analysed.order) {
    if (const auto why = order_may_exist(analysed); !why.empty()) out["assignment_may_exist"] = why;
    return out;
  }
  out["assignment"] = Json::array();
  for (const std::size_t i : *analysed.order) out["assignment"].push_back(bus.messages[i].name);
  return out;
}

}  // namespace

std::size_t refused_by_check(const AnalysedBus& analysed) {
  return static_cast<std::size_t>(
      std::ranges::count(analysed.bus.messages, Outcome::unfit, &BusMessage::outcome));
}

std::string write_text(const std::vector<AnalysedBus>& buses, Color color) {
  std::string text;
  for (const AnalysedBus& bus : buses) {
    if (!text.empty()) text += '\n';
    text += bus_text(bus, color);
  }
  return text;
}

std::string write_json(const std::vector<AnalysedBus>& buses) {
  Json out{{"version", kFormVersion}, {"schedulable", true}, {"networks", Json::array()}};
  for (const AnalysedBus& bus : buses) {
    if (!bus.schedulable || refused_by_check(bus) != 0) out["schedulable"] = false;
    out["networks"].push_back(bus_json(bus));
  }
  return out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mlcca::tools::design
