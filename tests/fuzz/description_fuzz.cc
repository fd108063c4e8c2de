// SPDX-License-Identifier: BSD-2-Clause
// Any octets as a description: read, or refused with problems that can be printed; never a crash,
// and nothing but a problem without a System.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "description/read.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view xml(reinterpret_cast<const char*>(data), size);
  const auto result = mlcca::description::read_memory(xml, "fuzz.xml");
  if (result) {
    for (const auto& p : result->publishers)
      if (p.channel >= result->channels.size()) std::abort();
    for (const auto& s : result->subscribers)
      if (s.channel >= result->channels.size()) std::abort();
    return 0;
  }
  if (result.error().empty()) std::abort();
  for (const auto& problem : result.error())
    for (const char c : to_string(problem))
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) std::abort();
  return 0;
}
