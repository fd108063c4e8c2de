// SPDX-License-Identifier: BSD-2-Clause
// The verb analyse-bus: its arguments, the analysis, and the exit status.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <span>
#include <string>

#include "core/can/level.hpp"
#include "core/can/sender.hpp"
#include "core/design/bus_responses.hpp"
#include "core/design/hints.hpp"
#include "core/model/text.hpp"
#include "tools/design/analyse_bus/bus.hpp"
#include "tools/design/analyse_bus/write.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::uint32_t kMostDataRate = 8'000'000;  // as in a description

struct Options {
  std::string file;
  BusOptions bus;
  std::string bitrate;
  std::string data_bitrate;
  std::string background;
  std::uint32_t faults = 0;
  double fault_interval_ms = 0;
  bool assign = false;
};

bool is_table(const std::string& file) { return !file.ends_with(".xml"); }

Buses read_input(const std::string& file, const BusOptions& options) {
  if (!is_table(file)) return read_description(file, options);
  errno = 0;
  if (std::error_code error; std::filesystem::is_directory(file, error))
    return {{}, {file + ": is a folder"}};
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.good() && !stream.eof())
    return {{}, {fmt::format("{}: {}", file, ::strerror(errno != 0 ? errno : EIO))}};
  return read_table(text, file, options);
}

template <class Form>
std::vector<core::can::Message> messages_of(const Bus& bus, Form form) {
  std::vector<core::can::Message> messages;
  messages.reserve(bus.messages.size());
  for (const BusMessage& m : bus.messages) messages.push_back(std::invoke(form, m));
  return messages;
}

std::string words_of(core::can::Unusable why) {
  switch (why) {
    case core::can::Unusable::jitter:
      return "its jitter is longer than what is analysed";
    case core::can::Unusable::transmission:
      return "its frames are longer than what is analysed, or of no length";
    case core::can::Unusable::period:
      return "it has no period";
    default:
      return "its frames or its queue are not right";
  }
}

/// A sentence about a message that cannot be analysed; empty if there is none.
std::string unusable_words(const Bus& bus, const std::vector<core::can::Message>& sorted) {
  for (std::size_t i = 0; i < sorted.size(); ++i)
    if (const auto why = unusable(bus.assumptions, sorted[i]); why != core::can::Unusable::no)
      return fmt::format("Because of {} nothing is bounded{}: {}.", printable(bus.messages[i].name),
                         why == core::can::Unusable::jitter ? " that it may win against" : "",
                         bus.messages[i].unbounded_on.empty()
                             ? words_of(why)
                             : fmt::format("it is not bounded on {}, from where it comes",
                                           printable(bus.messages[i].unbounded_on)));
  return {};
}

/// A sentence about two nodes that claim the same address; empty if there are none.
std::string address_clash(const Bus& bus, const std::vector<core::can::Message>& sorted) {
  for (std::size_t i = 0; i < sorted.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (shares_address(std::vector{sorted[k], sorted[i]}, 1))
        return core::address_words(printable(bus.messages[k].name), printable(bus.messages[i].name),
                                   sorted[i].sender, printable(bus.network)) +
               ".";
  return {};
}

/// A sentence that names the message because of which something has no bound; empty if everything
/// has one. `sorted` are the messages, highest priority first.
std::string unbounded_words(const AnalysedBus& analysed,
                            const std::vector<core::can::Message>& sorted) {
  const auto& bus = analysed.bus;
  const auto name = [&](std::size_t i) { return printable(bus.messages[i].name); };
  const auto first = std::ranges::find(analysed.responses, false, &core::can::Response::bounded);
  if (first == analysed.responses.end()) return {};
  if (std::string words = address_clash(bus, sorted); !words.empty()) return words;
  if (std::string words = unusable_words(bus, sorted); !words.empty()) return words;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    if (const auto late = sorted[i].jitter / sorted[i].period; late >= core::can::kMaxInstances)
      return fmt::format(
          "{} has so much jitter that {} of its events may wait at once, and at most {} in a row "
          "are analysed{}.",
          name(i), late + 1, core::can::kMaxInstances,
          std::ranges::count(analysed.responses, false, &core::can::Response::bounded) > 1
              ? ": what it may win against is not bounded either"
              : "");
  for (std::size_t i = 0; i < sorted.size(); ++i)
    if (const auto taken = sorted[i].transmission + sorted[i].pauses;
        sorted[i].pauses != 0 && taken > sorted[i].period) {
      const auto words = core::format_bound(Attribute::latency, taken, sorted[i].period);
      return fmt::format(
          "{} is not bounded: its {} frames take up to {} with the pauses between them, and the "
          "next event comes after {}.",
          name(i), sorted[i].frames, words.bound, words.limit);
    }
  constexpr std::uint64_t whole = 1'000'000;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const auto load = utilisation_ppm(bus.assumptions, std::span(sorted).first(i + 1));
    if (load >= whole)
      return fmt::format(
          "With {} the messages up to there take {:.2f} % of the bus: what has no better "
          "identifier is not bounded.",
          name(i), static_cast<double>(load) / 10'000);
  }
  const auto bounded_without = [&](auto&& leave_out) {
    core::can::Assumptions less = bus.assumptions;
    leave_out(less);
    const auto responses = analyse(less, sorted);
    return std::ranges::all_of(responses, &core::can::Response::bounded);
  };
  const core::FaultHypothesis& faults = bus.assumptions.faults;
  if (faults.count != 0 && bounded_without([](core::can::Assumptions& less) { less.faults = {}; }))
    return fmt::format(
        "{} is the first that is not bounded: the errors that are assumed ({} within {} ms) and "
        "what "
        "is sent again leave no time for it, without them all are bounded.",
        name(static_cast<std::size_t>(first - analysed.responses.begin())), faults.count,
        static_cast<double>(faults.interval) / 1e6);
  if (bus.assumptions.background != 0 &&
      bounded_without([](core::can::Assumptions& less) { less.background = 0; }))
    return fmt::format(
        "{} is the first that is not bounded: the background load of {} % leaves no time for it, "
        "without that all are bounded.",
        name(static_cast<std::size_t>(first - analysed.responses.begin())),
        static_cast<double>(bus.assumptions.background) / 10'000);
  return fmt::format(
      "{} is the first that is not bounded: what may go before its frames or block them leaves no "
      "time for all of them.",
      name(static_cast<std::size_t>(first - analysed.responses.begin())));
}

/// What happens to messages that fit if the messages that do not count are sent, too.
struct Harm {
  bool late = false;  ///< a message would miss its deadline
  bool lost = false;  ///< a message would be in time, but its queue too short
};

/// `messages` are those that count; `fit` is the result without the others.
Harm harm_of_uncounted(const Bus& bus, std::vector<core::can::Message> messages,
                       const std::vector<bool>& fit) {
  if (bus.uncounted.empty()) return {};
  const std::size_t counted = messages.size();
  for (const auto& message : bus.uncounted) {
    if (!message) return {.late = true};
    messages.push_back(*message);
  }
  const auto responses = analyse(bus.assumptions, messages);
  Harm harm;
  for (std::size_t i = 0; i < counted; ++i) {
    if (!responses[i].meets(messages[i].deadline))
      harm.late = true;
    else if (fit[i] && !fits(bus.assumptions, messages[i], responses[i]))
      harm.lost = true;
  }
  return harm;
}

/// As unbounded_words(), for a message that does not count: it makes no other one unbounded.
std::string unbounded_elsewhere(const Bus& bus) {
  const auto found = std::ranges::find_if(bus.messages, [](const BusMessage& m) {
    return !m.standing.counted && !m.unbounded_on.empty();
  });
  if (found == bus.messages.end()) return {};
  return fmt::format("{} is not bounded here: it is not bounded on {}, from where it comes.",
                     printable(found->name), printable(found->unbounded_on));
}

/// The same bus with only those messages that count.
AnalysedBus with_counted(const AnalysedBus& all) {
  AnalysedBus out;
  out.bus = all.bus;
  out.bus.messages.clear();
  for (std::size_t i = 0; i < all.bus.messages.size(); ++i) {
    if (!all.bus.messages[i].standing.counted) continue;
    out.bus.messages.push_back(all.bus.messages[i]);
    out.responses.push_back(all.responses[i]);
    out.fit.push_back(all.fit[i]);
  }
  return out;
}

core::BusDecision decision_of(const BusMessage& m) {
  return {.outcome = m.outcome,
          .held = m.held,
          .counted = m.standing.counted,
          .in_vain = m.in_vain,
          .refused_response = m.refused_response,
          .refused_jitter = m.refused_jitter,
          .refused_frames = m.refused_frames};
}

/// In time, with room in the queue. A message that does not come to the bus fits if check refuses
/// it for neither reason.
bool is_fit(const Bus& bus, const BusMessage& m, const core::can::Response& response) {
  if (!m.standing.counted) return !m.refused_response && !m.refused_frames;
  return fits(bus.assumptions, m.sent(), response);
}

/// Computes the response of each message beside those that count.
void analyse_messages(AnalysedBus& result) {
  const Bus& bus = result.bus;
  std::vector<core::can::Message> messages;
  std::vector<core::Standing> standing;
  for (const BusMessage& m : bus.messages) {
    messages.push_back(m.sent());
    standing.push_back(m.standing);
  }
  for (const core::BusResponse& r :
       core::responses_beside(bus.assumptions, messages, standing, bus.known)) {
    result.responses.push_back(r.response);
    result.by_admission.push_back(r.by_admission);
  }
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const bool fit = is_fit(bus, bus.messages[i], result.responses[i]);
    result.fit.push_back(fit);
    result.rows.push_back(core::row_of(decision_of(bus.messages[i]), bus.assumptions, messages[i],
                                       result.responses[i]));
    if (!bus.messages[i].standing.counted) continue;
    result.late = result.late || !result.responses[i].meets(messages[i].deadline);
    result.schedulable = result.schedulable && fit;
  }
}

core::BusLoad load_of(const AnalysedBus& there) {
  std::vector<core::BusLoadPart> parts;
  parts.reserve(there.bus.messages.size());
  for (const BusMessage& m : there.bus.messages) parts.push_back({m.sent(), m.present});
  return core::load_of(there.bus.assumptions, parts);
}

AnalysedBus analysed(Bus bus, bool assign) {
  AnalysedBus result;
  if (!bus.why_not.empty()) {
    bus.messages.clear();
    result.schedulable = false;
    result.bus = std::move(bus);
    return result;
  }
  std::ranges::stable_sort(bus.messages, {},
                           [](const BusMessage& m) { return m.message.priority; });
  result.bus = std::move(bus);
  analyse_messages(result);
  // A message that is decided at run time does not count as refused.
  if (std::ranges::any_of(result.bus.messages, [](const BusMessage& m) {
        return m.in_vain && (m.outcome != Outcome::run_time || m.held);
      }))
    result.schedulable = false;
  const AnalysedBus there = with_counted(result);
  const auto sent = messages_of(there.bus, &BusMessage::sent);
  const Harm harm = harm_of_uncounted(there.bus, sent, there.fit);
  result.met_alone = !result.late && harm.late;
  result.kept_alone = harm.lost;
  result.schedulable = result.schedulable && result.bus.sure && !result.met_alone && !harm.lost;
  result.load = load_of(there);
  result.why_unbounded = unbounded_words(there, sent);
  if (result.why_unbounded.empty()) result.why_unbounded = unbounded_elsewhere(result.bus);
  result.assigned = assign;
  if (assign)
    result.order =
        assign_priorities(result.bus.assumptions, messages_of(result.bus, &BusMessage::message));
  return result;
}

/// Parses a number in bit/s, or a rate with a unit. Throws what CLI11 reports.
std::uint32_t rate_of(const std::string& option, const std::string& text, std::uint32_t most) {
  if (text.empty()) return 0;
  const auto rate = parse_bus_rate(text, most);
  if (!rate)
    throw CLI::ValidationError(
        option, rate.error().text + (most == kMostArbitrationRate
                                         ? "; of the data phase of FD frames it is --data-bitrate"
                                         : ""));
  return *rate;
}

/// Converts the options that are texts. Throws what CLI11 reports.
void understand(Options& options) {
  options.bus.bitrate = rate_of("--bitrate", options.bitrate, kMostArbitrationRate);
  options.bus.data_bitrate = rate_of("--data-bitrate", options.data_bitrate, kMostDataRate);
  if (!options.background.empty()) {
    const auto share = parse_share(options.background, 1'000'000, Rounding::up);
    if (!share) throw CLI::ValidationError("--background-load", share.error().text);
    if (*share >= 1'000'000)
      throw CLI::ValidationError("--background-load",
                                 "'" + options.background + "': must be less than 1 (100%)");
    options.bus.background = static_cast<std::uint32_t>(*share);
  }
  if (options.faults == 0 && options.fault_interval_ms != 0)
    throw CLI::ValidationError("--fault-interval-ms", "needs --faults, how many errors that often");
  if (options.faults > 0) {
    constexpr double most = 1e9;
    if (std::isnan(options.fault_interval_ms) || options.fault_interval_ms <= 0 ||
        options.fault_interval_ms > most)
      throw CLI::ValidationError("--faults",
                                 "needs --fault-interval-ms, more than 0 and at most 1e9");
    options.bus.faults = {.count = options.faults,
                          .interval = static_cast<Value>(options.fault_interval_ms * 1e6)};
  }
  if (options.bus.data_bitrate != 0 && options.bus.bitrate > options.bus.data_bitrate)
    throw CLI::ValidationError("--data-bitrate", "must not be less than --bitrate");
  if (is_table(options.file) && options.bus.bitrate == 0)
    throw CLI::ValidationError("--bitrate", "is needed for a table of messages: bit/s of the bus");
  if (is_table(options.file) && !options.bus.network.empty())
    throw CLI::ValidationError("--network", "is for SYSTEM.xml: a table is one bus");
}

Exit run(const Options& options, bool json, Color color) {
  auto read = read_input(options.file, options.bus);
  if (!read.problems.empty()) {
    const std::string first = read.problems.front();
    read.problems.erase(read.problems.begin());
    return say(Refusal{Exit::usage, first, std::move(read.problems)}, json);
  }
  std::vector<AnalysedBus> buses;
  buses.reserve(read.buses.size());
  for (Bus& bus : read.buses) buses.push_back(analysed(std::move(bus), options.assign));
  const auto said = say(json ? write_json(buses) : write_text(buses, color));
  if (said != Exit::fine) return said;
  const bool all = std::ranges::all_of(
      buses, [](const AnalysedBus& bus) { return bus.schedulable && refused_by_check(bus) == 0; });
  return all ? Exit::fine : Exit::refused;
}

}  // namespace

void add_analyse_bus(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand(
      "analyse-bus", "response time of every message of a CAN bus, and whether it is in time");
  const auto options = std::make_shared<Options>();
  verb->add_option("file", options->file,
                   "table of the messages (columns name,id,extended,bytes,period_us, and if wanted "
                   "deadline_us,jitter_us,fd,frames,node), or the description of a system")
      ->required()
      ->type_name("FILE.csv|SYSTEM.xml");
  verb->add_option("--network", options->bus.network,
                   "only this CAN network of SYSTEM.xml; otherwise each of them")
      ->type_name("NAME");
  verb->add_option("--bitrate", options->bitrate,
                   "of the bus, such as 500k, at most 1M; SYSTEM.xml may state it")
      ->type_name("BIT/S");
  verb->add_option("--data-bitrate", options->data_bitrate,
                   "of the data phase of FD frames, such as 2M, at most 8M")
      ->type_name("BIT/S");
  verb->add_flag("--unknown-senders", options->bus.unknown_senders,
                 "other nodes may send: the longest frame of the bus may block");
  verb->add_option("--background-load", options->background,
                   "share of the bus that others take at any priority, such as 0.05")
      ->type_name("SHARE");
  verb->add_option("--faults", options->faults, "errors on the bus within --fault-interval-ms")
      ->check(CLI::Range(0U, ~0U))
      ->type_name("N");
  verb->add_option("--fault-interval-ms", options->fault_interval_ms, "see --faults")
      ->check(CLI::NonNegativeNumber)
      ->type_name("MS");
  verb->add_flag("--assign", options->assign,
                 "search for an order of the identifiers in which all deadlines are met");
  verb->callback([&context, options] {
    understand(*options);
    context.exit = run(*options, context.json, color_of(STDOUT_FILENO, context.no_color));
  });
}

}  // namespace mlcca::tools::design
