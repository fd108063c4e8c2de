// SPDX-License-Identifier: BSD-2-Clause
// Gates that are plain values: which one is in place on an interface, and whether it was denied.
#pragma once
#include <cstdlib>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "daemon/ports/gate_set.hpp"

namespace mlcca::test {

/// What a kernel would have of the gates.
struct FakeHooks {
  std::map<int, std::string> in_place;  ///< what was put there last, by ifindex
  std::set<std::string> denied;         ///< gates that deny everything
  std::set<int> unpinned;
  std::size_t loaded = 0;
  bool lacks_memory = false;  ///< loading fails
  bool refuses = false;       ///< putting a gate in place fails
};

/// "eth7 for 3 slots".
inline std::string name_of(const GateSpec& spec) {
  if (const auto* const can = std::get_if<gates::GateConfig>(&spec)) return can->name;
  const auto& ethernet = std::get<gates::EtherConfig>(spec);
  return ethernet.name + " for " + std::to_string(ethernet.slots) + " slots";
}

class FakeGate final : public HeldGate {
 public:
  FakeGate(const GateSpec& spec, FakeHooks& hooks)
      : ifindex_(ifindex_of(spec)), name_(name_of(spec)), hooks_(hooks) {}

  [[nodiscard]] bool is(const GateSpec& spec) const override { return name_of(spec) == name_; }
  Result<void> put() override {
    if (hooks_.refuses) return fail("no permission to attach " + name_);
    hooks_.in_place[ifindex_] = name_;
    return {};
  }
  Result<void> reattach() override {
    hooks_.in_place[ifindex_] = name_ + ", again";
    return {};
  }
  void deny_all() override { hooks_.denied.insert(name_); }
  void unpin() override { hooks_.unpinned.insert(ifindex_); }
  /// These have no slots: nothing that is tested with them may ask for one.
  [[nodiscard]] gates::PortGate& port_gate() override { std::abort(); }
  [[nodiscard]] gates::Gate* can_gate() override { return nullptr; }

 private:
  int ifindex_;
  std::string name_;
  FakeHooks& hooks_;
};

/// `hooks` must outlive it.
inline GateSet::Load load_into(FakeHooks& hooks) {
  return [&hooks](const GateSpec& spec) -> Result<std::unique_ptr<HeldGate>> {
    if (hooks.lacks_memory) return fail("no memory for " + name_of(spec));
    ++hooks.loaded;
    return std::make_unique<FakeGate>(spec, hooks);
  };
}

inline net::Link ethernet(int ifindex, const std::string& name) {
  net::Link link;
  link.ifindex = ifindex;
  link.name = name;
  link.is_ethernet = true;
  link.up = link.running = true;
  return link;
}

}  // namespace mlcca::test
