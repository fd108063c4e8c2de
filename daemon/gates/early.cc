// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/early.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <linux/if_link.h>

#include <cerrno>
#include <filesystem>

#include "daemon/gates/complaints.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/roster.hpp"

namespace mlcca::gates {
namespace {

constexpr std::uint32_t kNoted = 4096;  // the latest ones; the kernel uses no id twice

std::string notes_pin(const std::string& root) { return root + "/early_programs"; }

Result<Fd> open_notes(const std::string& root) {
  const std::string path = notes_pin(root);
  const auto is_ours = [](int notes) { return is_hash(notes, sizeof(std::uint32_t), 1); };
  std::string was;
  auto there = open_own(path, is_ours, was);
  if (!there || *there) return there;
  Fd made(bpf_map_create(BPF_MAP_TYPE_LRU_HASH, "early_programs", sizeof(std::uint32_t), 1, kNoted,
                         nullptr));
  if (!made) return failure("make " + path, errno);
  const auto pinned = pin(made.get(), path);
  if (!pinned) return std::unexpected(pinned.error());
  if (*pinned) return made;
  return open_own(path, is_ours, was);
}

}  // namespace

std::uint32_t early_program(std::uint32_t ifindex) {
  const Complaints silenced;
  std::uint32_t id = 0;
  return bpf_xdp_query_id(static_cast<int>(ifindex), XDP_FLAGS_DRV_MODE, &id) == 0 ? id : 0;
}

std::vector<std::uint32_t> other_early_programs(std::uint32_t ifindex, std::uint32_t ours) {
  const Complaints silenced;
  LIBBPF_OPTS(bpf_xdp_query_opts, found);
  std::vector<std::uint32_t> others;
  if (bpf_xdp_query(static_cast<int>(ifindex), 0, &found) != 0) return others;
  for (const std::uint32_t id : {found.hw_prog_id, found.drv_prog_id, found.skb_prog_id})
    if (id != 0 && id != ours) others.push_back(id);
  return others;
}

bool put_early(std::uint32_t ifindex, int program_fd, bool replace) {
  const Complaints silenced;
  const std::uint32_t how = replace ? 0 : XDP_FLAGS_UPDATE_IF_NOEXIST;
  return bpf_xdp_attach(static_cast<int>(ifindex), program_fd, XDP_FLAGS_DRV_MODE | how, nullptr) ==
         0;
}

void remove_early(std::uint32_t ifindex, int program_fd) {
  const Complaints silenced;
  LIBBPF_OPTS(bpf_xdp_attach_opts, only, .old_prog_fd = program_fd);
  bpf_xdp_detach(static_cast<int>(ifindex), XDP_FLAGS_DRV_MODE, &only);
}

Result<void> note_early(const std::string& root, std::uint32_t program) {
  const auto notes = open_notes(root);
  if (!notes) return std::unexpected(notes.error());
  const std::uint8_t noted = 1;
  if (bpf_map_update_elem(notes->get(), &program, &noted, BPF_ANY) != 0)
    return failure("note a program in " + notes_pin(root), errno);
  return {};
}

bool is_noted_early(const std::string& root, std::uint32_t program) {
  const Fd notes = open_pin(notes_pin(root));
  std::uint8_t noted = 0;
  return notes && bpf_map_lookup_elem(notes.get(), &program, &noted) == 0;
}

Result<bool> put_early_in_place(const GateLocation& place, int program_fd) {
  const std::string root =
      std::filesystem::path(place.directory).parent_path().parent_path().string();
  const std::uint32_t id = program_info(program_fd).id;
  if (auto noted = note_early(root, id); !noted) return std::unexpected(noted.error());
  const std::uint32_t there = early_program(place.ifindex);
  if (there == id) return true;
  if (there != 0 && !is_noted_early(root, there) && !is_of_a_gate(there)) return false;
  return put_early(place.ifindex, program_fd, there != 0);
}

}  // namespace mlcca::gates
