// SPDX-License-Identifier: BSD-2-Clause
// What is loaded: the file, or what a rollout has put in force in its place.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/cluster/shared.hpp"
#include "daemon/gateway/rollout.hpp"
#include "daemon/gateway/text_source.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

constexpr const char* kUnchecked =
    "whether this description takes others off a network is not known: the one in force in the "
    "cluster is not kept here";

void note_damage(Described& described, const std::string& damage) {
  if (!damage.empty()) described.notes.push_back("what is kept of the cluster: " + damage);
}

/// The description that a rollout has put in force in place of the file; nullopt if its text is
/// lost or damaged.
std::optional<Described> rolled_out(Described& file, const TextSource& rolled,
                                    const ReadText& read_text) {
  std::string damage;
  const auto text = rolled.text(damage);
  note_damage(file, damage);
  if (!text) return std::nullopt;
  auto other = read_text(*text);
  if (!other || other->digest != rolled.digest) return std::nullopt;
  other->file_digest = file.file_digest;
  other->notes = std::move(file.notes);
  return std::move(*other);
}

using SharedPorts = std::optional<std::vector<cc::SharedPort>>;

/// The shared ports of the description in force; nullopt if its text is not available.
SharedPorts ports_in(const TextSource& in_force, const ReadText& read_text, Described& file) {
  std::string damage;
  const auto text = in_force.text(damage);
  note_damage(file, damage);
  if (!text) return std::nullopt;
  const auto known = read_text(*text);
  if (!known || known->digest != in_force.digest) return std::nullopt;
  return cc::shared_ports(known->state->system(), known->self);
}

/// Checks that a file which is not the description in force takes no other gateways off a network.
/// If that is not known, the file is refused; at a start it is loaded, and others are assumed to be
/// on all networks.
DescribedResult held_against(Described file, const SharedPorts& in_force, bool starts) {
  if (!in_force && !starts) {
    std::vector<std::string> lines{kUnchecked};
    lines.insert(lines.end(), file.notes.begin(), file.notes.end());
    return std::unexpected(StartError{.lines = std::move(lines)});
  }
  if (!in_force) {
    file.notes.push_back(std::string(kUnchecked) + ": all its networks are closed until it is");
    file.unchecked = true;
    file.state->share_all(file.self);
    return file;
  }
  std::string why = cc::no_longer_shared(*in_force, file.state->system(), file.self);
  if (why.empty()) return file;
  return std::unexpected(StartError{.lines = {std::move(why)}, .bad_input = true});
}

}  // namespace

/// A file that has changed since the rollout is what the operator wants, so it takes precedence.
ReadDescription Rollout::reader(ReadDescription read, const cc::Member* member) const {
  const auto source = [&](const Digest& digest) {
    return TextSource{.digest = digest,
                      .kept = parts_.texts.reader(),
                      .stored = member == nullptr ? nullptr : in_store(digest, *member)};
  };
  const Scene& scene = parts_.scene;
  SharedPorts here;
  if (scene.state && scene.digest == following_.in_force)
    here = cc::shared_ports(scene.state->system(), scene.self);
  return [read = std::move(read), rolled = source(following_.rolled),
          in_force = source(following_.in_force), here = std::move(here), following = following_,
          read_text = parts_.read, starts = member == nullptr]() -> DescribedResult {
    auto file = read();
    if (!file) return file;
    file->file_digest = file->digest;
    if (following.replaces(file->digest))
      if (auto other = rolled_out(*file, rolled, read_text)) return std::move(*other);
    if (file->digest == in_force.digest || in_force.digest == Digest{}) return file;
    const SharedPorts ports = here ? here : ports_in(in_force, read_text, *file);
    return held_against(std::move(*file), ports, starts);
  };
}

}  // namespace mlcca
