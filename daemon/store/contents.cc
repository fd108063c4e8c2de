// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/contents.hpp"

#include <algorithm>
#include <utility>

namespace mlcca::store {
namespace {

/// Sets the text of a subject; an empty text removes it.
template <class Subject>
void put(std::map<Subject, std::string>& to, const Subject& subject, const std::string& text) {
  if (text.empty())
    to.erase(subject);
  else
    to.insert_or_assign(subject, text);
}
template <class Subject>
std::string get(const std::map<Subject, std::string>& from, const Subject& subject) {
  const auto known = from.find(subject);
  return known == from.end() ? std::string() : known->second;
}

auto key_of(const Contradicted& entry) { return std::pair(entry.network, entry.subject); }

bool holds(const std::vector<std::string>& sorted, const std::string& text) {
  return std::ranges::binary_search(sorted, text);
}

struct Apply {
  Contents& to;

  void operator()(const Admitted& entry) const {
    to.next_id = std::max(to.next_id, entry.request.id + 1);
    to.admissions.put(entry.request, entry.by, entry.through);
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
  void operator()(const Granted& entry) const { put(to.granted, entry.subject, entry.state); }
  void operator()(const NextId& entry) const { to.next_id = std::max(to.next_id, entry.id); }
  void operator()(const Enforced& entry) const { put(to.enforced, entry.subject, entry.slots); }
  void operator()(const Gated& entry) const {
    if (entry.ifindex == 0)
      to.gated.erase(entry.identity);
    else
      to.gated.insert_or_assign(entry.identity, entry);
  }
  void operator()(const Contradicted& entry) const {
    if (entry.how.empty())
      to.contradicted.erase(key_of(entry));
    else
      to.contradicted.insert_or_assign(key_of(entry), entry);
  }
  void operator()(const Membership& entry) const { to.membership = entry; }
  void operator()(const Introduced& entry) const { to.introduced = entry.done; }
};

struct Inverse {
  const Contents& of;
  using Answer = std::optional<Entry>;

  Answer operator()(const Admitted& entry) const {
    const control::Request* old = of.admissions.find(entry.request.id);
    if (old == nullptr) return Removed{entry.request.id};
    Admitted before{*old, of.admissions.user_of(old->id), of.admissions.through(old->id)};
    if (before == entry) return std::nullopt;
    return before;
  }
  Answer operator()(const Removed& entry) const {
    const control::Request* old = of.admissions.find(entry.id);
    if (old == nullptr) return std::nullopt;
    return Admitted{*old, of.admissions.user_of(old->id), of.admissions.through(old->id)};
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
    std::string before = get(of.granted, entry.subject);
    if (before == entry.state) return std::nullopt;
    return Granted{entry.subject, std::move(before)};
  }
  Answer operator()(const NextId& entry) const {
    if (entry.id <= of.next_id) return std::nullopt;
    return NextId{of.next_id};
  }
  Answer operator()(const Enforced& entry) const {
    std::string before = get(of.enforced, entry.subject);
    if (before == entry.slots) return std::nullopt;
    return Enforced{entry.subject, std::move(before)};
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
  Answer operator()(const Contradicted& entry) const {
    const auto old = of.contradicted.find(key_of(entry));
    if (old == of.contradicted.end()) {
      if (entry.how.empty()) return std::nullopt;
      return Contradicted{entry.network, entry.subject, 0, {}};
    }
    if (old->second == entry) return std::nullopt;
    return old->second;
  }
  Answer operator()(const Membership& entry) const {
    if (of.membership == entry) return std::nullopt;
    return of.membership;
  }
  Answer operator()(const Introduced& entry) const {
    if (of.introduced == entry.done) return std::nullopt;
    return Introduced{of.introduced};
  }
};

}  // namespace

void Contents::apply(const Entry& entry) { std::visit(Apply{*this}, entry); }

std::optional<Entry> Contents::inverse(const Entry& entry) const {
  return std::visit(Inverse{*this}, entry);
}

}  // namespace mlcca::store
