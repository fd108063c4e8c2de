// SPDX-License-Identifier: BSD-2-Clause
// Any octets as a file that is imported: an error that names the file, or a description that can be
// read, which the same file gives again. The first octet says the format.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "description/read.hpp"
#include "tests/fuzz/demand.hpp"
#include "tools/design/import/draft.hpp"
#include "tools/design/import/formats.hpp"

namespace {

using namespace mlcca;
using namespace mlcca::tools::design;
using fuzz::demand;

void check(ImportedNetwork network) {
  for (const auto& lack : network.lacks.all())
    demand(lack.count >= lack.items.size() && lack.items.size() <= kMostItems,
           "a list is too long");
  network.name = "net";
  auto other = network;
  other.file = "other";
  if (network.is_part) merge(network, std::move(other));
  complete(network);
  std::vector<ImportedNetwork> networks = {std::move(network)};
  auto again = networks;
  const auto draft = draft_of(networks, {"fuzz", "gate", {"can0"}});
  demand(draft == draft_of(again, {"fuzz", "gate", {"can0"}}), "another draft");
  const auto read = description::read_memory(draft, "draft");
  demand(read.has_value(), "a draft that cannot be read");
  demand(read->channels.size() == networks.front().messages.size(), "a message is lost");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto names = format_list();
  const auto* format = format_called(names.at((data[0] & 0x3fU) % names.size()));
  ImportOptions options;
  if ((data[0] & 0x40U) != 0) options.profile = core::Profile::j1939;
  if ((data[0] & 0x80U) != 0) options.profile = core::Profile::raw;
  if (options.profile) options.node = 1;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  static_cast<void>(recognise(text));
  auto network = format->read(text, "fuzz.file", options);
  if (!network) {
    demand(network.error().text.starts_with("fuzz.file:"), "an error of no file");
    return 0;
  }
  check(std::move(*network));
  return 0;
}
