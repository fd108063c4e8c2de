// SPDX-License-Identifier: BSD-2-Clause
// Any octets as a table of messages for analyse-bus: problems with a line number, or a bus that is
// analysed to an end.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/can/analysis.hpp"
#include "tests/fuzz/demand.hpp"
#include "tools/design/analyse_bus/bus.hpp"

namespace {

using namespace mlcca;
using fuzz::demand;

/// A long table is read; its analysis takes seconds, and is tested elsewhere.
constexpr std::size_t kMostAnalysed = 12;

void analyse(const tools::design::Bus& bus) {
  std::vector<core::can::Message> messages;
  for (const auto& m : bus.messages) {
    demand(m.bytes <= 64 && m.id <= 0x1fffffff && m.message.frames >= 1, "a message of no bus");
    messages.push_back(m.message);
  }
  if (messages.size() > kMostAnalysed) return;
  const auto responses = core::can::analyse(bus.assumptions, messages);
  demand(responses.size() == messages.size(), "a message without a response");
  for (std::size_t i = 0; i < messages.size(); ++i)
    demand(!responses[i].bounded || responses[i].response >= messages[i].transmission,
           "faster than the message is long");
  static_cast<void>(core::can::utilisation_ppm(bus.assumptions, messages));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  tools::design::BusOptions options;
  options.bitrate = (data[0] & 1U) != 0 ? 125'000 : 1'000'000;
  options.data_bitrate = (data[0] & 2U) != 0 ? 5'000'000 : 0;
  options.unknown_senders = (data[0] & 4U) != 0;
  if ((data[0] & 8U) != 0) options.background = 300'000;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto read = tools::design::read_table(text, "fuzz.csv", options);
  demand(read.problems.empty() != read.buses.empty(), "neither a bus nor a problem, or both");
  for (const std::string& problem : read.problems)
    demand(problem.starts_with("fuzz.csv:"), "a problem of no line");
  for (const auto& bus : read.buses) analyse(bus);
  return 0;
}
