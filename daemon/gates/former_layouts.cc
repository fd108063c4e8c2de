// SPDX-License-Identifier: BSD-2-Clause
// Of a control word with another layout only the head is known: version and `open`.
#include "daemon/gates/former_layouts.hpp"

#include <bpf/bpf.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "bpf/gate.h"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/publish.hpp"

namespace mlcca::gates {
namespace {

struct Head {
  std::uint32_t layout_version;
  std::uint32_t open;
};
static_assert(offsetof(gate_control, layout_version) == offsetof(Head, layout_version) &&
              offsetof(gate_control, open) == offsetof(Head, open));

}  // namespace

void close_word(int map) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  void* const memory = ::mmap(nullptr, page, PROT_READ | PROT_WRITE, MAP_SHARED, map, 0);
  if (memory == MAP_FAILED) return;
  publish(static_cast<Head*>(memory)->open, std::uint32_t{0});
  ::munmap(memory, page);
}

Result<void> close_former_layouts(const std::string& root) {
  const std::string ours = "v" + std::to_string(GATE_LAYOUT_VERSION);
  const auto names = names_in(root);
  if (!names) return failure("read " + root, names.error().value());
  for (const std::string& name : *names) {
    if (!name.starts_with("v") || name == ours) continue;
    const std::string pins = (std::filesystem::path(root) / name).string();
    if (const Fd word = open_pin(pins + "/control"); word) close_word(word.get());
    for (const char* pin : {"/control", "/deadman", "/events", "/until"}) remove_pin(pins + pin);
  }
  return {};
}

}  // namespace mlcca::gates
