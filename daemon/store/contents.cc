// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/contents.hpp"

#include <algorithm>

namespace mlcca::store {
namespace {

bool holds(const std::vector<std::string>& sorted, const std::string& text) {
  return std::ranges::binary_search(sorted, text);
}

struct Apply {
  Contents& to;

  void operator()(const Admitted& entry) const {
    to.next_id = std::max(to.next_id, entry.request.id + 1);
    to.admissions.put(entry.request);
  }
  void operator()(const Removed& entry) const { to.admissions.erase(entry.id); }
  void operator()(const Released& entry) const {
    const auto place = std::ranges::lower_bound(to.released, entry.subject);
    if (place == to.released.end() || *place != entry.subject)
      to.released.insert(place, entry.subject);
  }
  void operator()(const Reinstated& entry) const {
    const auto [first, last] = std::ranges::equal_range(to.released, entry.subject);
    to.released.erase(first, last);
  }
  void operator()(const Granted& entry) const {
    if (entry.state.empty())
      to.granted.erase(entry.subject);
    else
      to.granted.insert_or_assign(entry.subject, entry.state);
  }
  void operator()(const Gated& entry) const {
    if (entry.ifindex == 0)
      to.gated.erase(entry.identity);
    else
      to.gated.insert_or_assign(entry.identity, entry);
  }
};

struct Inverse {
  const Contents& of;
  using Answer = std::optional<Entry>;

  Answer operator()(const Admitted& entry) const {
    const control::Request* old = of.admissions.find(entry.request.id);
    if (old == nullptr) return Removed{entry.request.id};
    if (*old == entry.request) return std::nullopt;
    return Admitted{*old};
  }
  Answer operator()(const Removed& entry) const {
    const control::Request* old = of.admissions.find(entry.id);
    if (old == nullptr) return std::nullopt;
    return Admitted{*old};
  }
  Answer operator()(const Released& entry) const {
    if (holds(of.released, entry.subject)) return std::nullopt;
    return Reinstated{entry.subject};
  }
  Answer operator()(const Reinstated& entry) const {
    if (!holds(of.released, entry.subject)) return std::nullopt;
    return Released{entry.subject};
  }
  Answer operator()(const Granted& entry) const {
    const auto old = of.granted.find(entry.subject);
    const std::string before = old == of.granted.end() ? std::string() : old->second;
    if (before == entry.state) return std::nullopt;
    return Granted{entry.subject, before};
  }
  Answer operator()(const Gated& entry) const {
    const auto old = of.gated.find(entry.identity);
    if (old == of.gated.end()) {
      if (entry.ifindex == 0) return std::nullopt;
      return Gated{.identity = entry.identity, .network = {}, .interface = {}, .ifindex = 0};
    }
    if (old->second == entry) return std::nullopt;
    return old->second;
  }
};

}  // namespace

void Contents::apply(const Entry& entry) { std::visit(Apply{*this}, entry); }

std::optional<Entry> Contents::inverse(const Entry& entry) const {
  return std::visit(Inverse{*this}, entry);
}

}  // namespace mlcca::store
