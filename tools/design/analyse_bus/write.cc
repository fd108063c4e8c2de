// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/analyse_bus/write.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kMicrosecond = 1'000;  // ns
constexpr double kWhole = 1e6;                 // 1e-6 units

std::string in_us(std::uint64_t ns) {
  return fmt::format("{}.{:03}", ns / kMicrosecond, ns % kMicrosecond);
}

std::string slack_of(std::uint64_t deadline, std::uint64_t response) {
  return deadline >= response ? in_us(deadline - response) : "-" + in_us(response - deadline);
}

std::string identifier_of(const BusMessage& m) {
  return m.extended ? fmt::format("0x{:08x}", m.id) : fmt::format("0x{:03x}", m.id);
}

double as_us(std::uint64_t ns) {
  return static_cast<double>(ns) / static_cast<double>(kMicrosecond);
}

std::string verdict_of(const AnalysedBus& analysed, std::size_t i) {
  if (analysed.in_time[i]) return {};
  const core::can::Response& r = analysed.responses[i];
  if (!r.bounded) return "not bounded";
  return r.meets(analysed.bus.messages[i].message.deadline) ? "queue too short" : "late";
}

std::string order_text(const AnalysedBus& analysed) {
  if (!analysed.order)
    return "There is no order of the identifiers in which all deadlines are met.\n";
  std::string text =
      "In this order of the identifiers, highest priority first, all deadlines are met:\n";
  for (const std::size_t i : *analysed.order)
    text += fmt::format("  {}\n", printable(analysed.bus.messages[i].name));
  return text;
}

std::string bus_text(const AnalysedBus& analysed, Color color) {
  const Bus& bus = analysed.bus;
  std::string text;
  if (!bus.network.empty()) text += fmt::format("Network {}\n", printable(bus.network));
  Table table({{"Message"},
               {"Identifier", Align::right},
               {"Frame us", Align::right},
               {"Response us", Align::right},
               {"Deadline us", Align::right},
               {"Slack us", Align::right},
               {""}});
  for (std::size_t i = 0; i < bus.messages.size(); ++i) {
    const BusMessage& m = bus.messages[i];
    const core::can::Response& r = analysed.responses[i];
    const Style style = analysed.in_time[i] ? Style::plain : Style::bad;
    table.add({{m.name},
               {identifier_of(m)},
               {in_us(m.message.longest_frame)},
               {r.bounded ? in_us(r.response) : "-", style},
               {in_us(m.message.deadline)},
               {r.bounded ? slack_of(m.message.deadline, r.response) : "-", style},
               {verdict_of(analysed, i), style}});
  }
  if (table.empty())
    text += "Nothing that is described sends here.\n";
  else
    text += table.text(color);
  text += fmt::format("Bus load {:.2f} % at {}", static_cast<double>(analysed.load) * 100 / kWhole,
                      print_bitrate(bus.assumptions.timing.bitrate));
  if (bus.assumptions.timing.data_bitrate != 0)
    text +=
        fmt::format(", {} in the data phase", print_bitrate(bus.assumptions.timing.data_bitrate));
  text += analysed.schedulable ? ": every deadline is met\n" : ": a deadline can be missed\n";
  if (analysed.assigned) text += order_text(analysed);
  return text;
}

Json message_json(const AnalysedBus& analysed, std::size_t i) {
  const BusMessage& m = analysed.bus.messages[i];
  const core::can::Response& r = analysed.responses[i];
  const double deadline = as_us(m.message.deadline);
  Json out{{"name", m.name},
           {"id", m.id},
           {"extended", m.extended},
           {"bytes", m.bytes},
           {"frames", m.message.frames},
           {"frame_time_us", as_us(m.message.longest_frame)},
           {"response_us", nullptr},
           {"deadline_us", deadline},
           {"slack_us", nullptr},
           {"period_us", as_us(m.message.period)},
           {"jitter_us", as_us(m.message.jitter)},
           {"schedulable", static_cast<bool>(analysed.in_time[i])}};
  if (r.bounded) {
    out["response_us"] = as_us(r.response);
    out["slack_us"] = m.message.deadline >= r.response ? as_us(m.message.deadline - r.response)
                                                       : -as_us(r.response - m.message.deadline);
  }
  return out;
}

Json bus_json(const AnalysedBus& analysed) {
  const Bus& bus = analysed.bus;
  Json out = Json::object();
  if (!bus.network.empty()) out["network"] = bus.network;
  out["bitrate"] = bus.assumptions.timing.bitrate;
  if (bus.assumptions.timing.data_bitrate != 0)
    out["data_bitrate"] = bus.assumptions.timing.data_bitrate;
  out["bus_load"] = static_cast<double>(analysed.load) / kWhole;
  out["schedulable"] = analysed.schedulable;
  out["messages"] = Json::array();
  for (std::size_t i = 0; i < bus.messages.size(); ++i)
    out["messages"].push_back(message_json(analysed, i));
  if (!analysed.assigned) return out;
  out["assignment"] = nullptr;
  if (!analysed.order) return out;
  out["assignment"] = Json::array();
  for (const std::size_t i : *analysed.order) out["assignment"].push_back(bus.messages[i].name);
  return out;
}

}  // namespace

std::string write_text(const std::vector<AnalysedBus>& buses, Color color) {
  std::string text;
  for (const AnalysedBus& bus : buses) {
    if (!text.empty()) text += '\n';
    text += bus_text(bus, color);
  }
  return text;
}

std::string write_json(const std::vector<AnalysedBus>& buses) {
  Json out;
  if (buses.size() == 1) {
    out = bus_json(buses.front());
  } else {
    out["schedulable"] = true;
    out["networks"] = Json::array();
    for (const AnalysedBus& bus : buses) {
      if (!bus.schedulable) out["schedulable"] = false;
      out["networks"].push_back(bus_json(bus));
    }
  }
  return out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mlcca::tools::design
