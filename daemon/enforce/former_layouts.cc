// SPDX-License-Identifier: BSD-2-Clause
// Of a word of another layout no more is known than its head: version and `open`.
#include "daemon/enforce/former_layouts.hpp"

#include <bpf/bpf.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "bpf/gate.h"
#include "daemon/enforce/pins.hpp"
#include "daemon/enforce/publish.hpp"

namespace mlcca::enforce {
namespace {

struct Head {
  std::uint32_t layout_version;
  std::uint32_t open;
};
static_assert(offsetof(gate_control, layout_version) == offsetof(Head, layout_version) &&
              offsetof(gate_control, open) == offsetof(Head, open));

void close_word(int map) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  void* const memory = ::mmap(nullptr, page, PROT_READ | PROT_WRITE, MAP_SHARED, map, 0);
  if (memory == MAP_FAILED) return;
  publish(static_cast<Head*>(memory)->open, std::uint32_t{0});
  ::munmap(memory, page);
}

}  // namespace

void close_former_layouts(const std::string& root) {
  const std::string ours = "v" + std::to_string(GATE_LAYOUT_VERSION);
  std::error_code error;
  for (const auto& layout : std::filesystem::directory_iterator(root, error)) {
    const std::string name = layout.path().filename();
    if (!name.starts_with("v") || name == ours) continue;
    const std::string pins = layout.path();
    if (const Fd word = open_pin(pins + "/control"); word) close_word(word.get());
    for (const char* pin : {"/control", "/deadman", "/events"}) remove_pin(pins + pin);
  }
}

}  // namespace mlcca::enforce
