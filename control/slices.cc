// SPDX-License-Identifier: BSD-2-Clause
#include "control/slices.hpp"

#include <algorithm>
#include <concepts>
#include <iterator>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "control/fields.hpp"

namespace mlcca::control {
namespace {

template <class Row>
void move_behind(std::vector<Row>& rows, std::vector<Row>& more) {
  rows.insert(rows.end(), std::make_move_iterator(more.begin()),
              std::make_move_iterator(more.end()));
}

void put(Gates& to, Gates& from) {
  for (Gate& gate : from.gates) {
    const bool same = !to.gates.empty() && to.gates.back().interface == gate.interface &&
                      to.gates.back().network == gate.network;
    if (!same) {
      to.gates.push_back(std::move(gate));
      continue;
    }
    move_behind(to.gates.back().control, gate.control);
    move_behind(to.gates.back().channels, gate.channels);
  }
}
void put(Reservations& to, Reservations& from) {
  for (Resource& resource : from.resources) {
    const auto same = std::ranges::find_if(to.resources, [&](const Resource& r) {
      return r.name == resource.name && r.kind == resource.kind;
    });
    if (same == to.resources.end())
      to.resources.push_back(std::move(resource));
    else
      move_behind(same->reservations, resource.reservations);
  }
}
/// Merges a slice into `to`: lists are appended, single values replaced.
template <class Body>
void put(Body& to, Body& from) {
  for_each_field(from, [&](const Field& field, auto& source) {
    using T = std::remove_cvref_t<decltype(source)>;
    with_field(to, field.number, [&](auto& target) {
      if constexpr (std::same_as<std::remove_cvref_t<decltype(target)>, T>) {
        if constexpr (requires { target.push_back(target.front()); } &&
                      !std::same_as<T, std::string>)
          move_behind(target, source);
        else
          target = std::move(source);
      }
    });
  });
}

/// Distributes rows over slices: rows go to the current slice until it is full, then to a new one.
class Slicer {
 public:
  Slicer(std::uint64_t id, std::size_t rows) : id_(id), rows_(rows) {}

  std::vector<Reply> operator()(Routes& all) {
    slice<Routes>();
    for (RouteReport& row : all.routes) {
      const std::size_t lines = 1 + row.route.size() + lines_of(row.media);
      slice<Routes>().routes.push_back(std::move(row));
      filled_ += lines;
    }
    fill(all.links, &Routes::links);
    fill(all.problems, &Routes::problems);
    fill(all.can_rules, &Routes::can_rules);
    fill(all.transfers, &Routes::transfers);
    for (Reply& reply : out_)
      std::get<Routes>(reply.body).transfers_left_out = all.transfers_left_out;
    return std::move(out_);
  }
  std::vector<Reply> operator()(Channels& all) {
    slice<Channels>();
    for (Channel& row : all.channels) {
      const std::size_t lines =
          1 + row.subscribers.size() + row.rows.size() + row.route.size() + lines_of(row.media);
      slice<Channels>().channels.push_back(std::move(row));
      filled_ += lines;
    }
    fill(all.endpoints, &Channels::endpoints);
    fill(all.admissions_left_out, &Channels::admissions_left_out);
    for (Reply& reply : out_) {
      std::get<Channels>(reply.body).left_out = all.left_out;
      std::get<Channels>(reply.body).grace_ns = all.grace_ns;
      std::get<Channels>(reply.body).local_problem = all.local_problem;
    }
    return std::move(out_);
  }
  /// Each slice repeats everything but the interfaces.
  std::vector<Reply> operator()(Status& all) {
    auto interfaces = std::move(all.interfaces);
    all.interfaces.clear();
    slice<Status>() = all;
    for (Interface& row : interfaces) {
      const std::size_t lines = 16 + row.unknown.size();
      auto& to = slice<Status>();
      if (to.interfaces.empty()) to = all;
      to.interfaces.push_back(std::move(row));
      filled_ += lines;
    }
    return std::move(out_);
  }
  std::vector<Reply> operator()(Networks& all) {
    slice<Networks>();
    for (Network& row : all.networks) {
      const std::size_t lines = 1 + row.gateways.size();
      slice<Networks>().networks.push_back(std::move(row));
      filled_ += lines;
    }
    return std::move(out_);
  }
  std::vector<Reply> operator()(Transfers& all) {
    slice<Transfers>();
    fill(all.transfers, &Transfers::transfers);
    return std::move(out_);
  }
  std::vector<Reply> operator()(Subscriptions& all) {
    slice<Subscriptions>();
    fill(all.networks, &Subscriptions::networks);
    fill(all.onward, &Subscriptions::onward);
    return std::move(out_);
  }
  std::vector<Reply> operator()(ClusterMembers& all) {
    return slice_list(all, &ClusterMembers::members);
  }
  std::vector<Reply> operator()(ClusterReservations& all) {
    return slice_list(all, &ClusterReservations::reservations);
  }
  std::vector<Reply> operator()(WhatIf& all) {
    slice<WhatIf>().unchanged = all.unchanged;
    fill(all.outlooks, &WhatIf::outlooks);
    for (Reply& reply : out_) std::get<WhatIf>(reply.body).unchanged = all.unchanged;
    return std::move(out_);
  }
  std::vector<Reply> operator()(Reservations& all) {
    slice<Reservations>();
    for (Resource& resource : all.resources) {
      auto rows = std::move(resource.reservations);
      resource.reservations.clear();
      slice<Reservations>().resources.push_back(resource);
      ++filled_;
      for (Reservation& row : rows) {
        auto& resources = slice<Reservations>().resources;
        if (resources.empty()) resources.push_back(resource);
        resources.back().reservations.push_back(std::move(row));
        ++filled_;
      }
    }
    return std::move(out_);
  }
  std::vector<Reply> operator()(Gates& all) {
    slice<Gates>();
    for (Gate& gate : all.gates) {
      auto control = std::move(gate.control);
      auto channels = std::move(gate.channels);
      gate.control.clear();
      gate.channels.clear();
      slice<Gates>().gates.push_back(gate);
      ++filled_;
      fill_gate(gate, control, &Gate::control);
      fill_gate(gate, channels, &Gate::channels);
    }
    return std::move(out_);
  }
  template <class Whole>
  std::vector<Reply> operator()(Whole& all) {
    out_.push_back({id_, std::move(all)});
    return std::move(out_);
  }

 private:
  static std::size_t lines_of(const std::vector<MediumUse>& media) {
    std::size_t lines = 0;
    for (const MediumUse& use : media) lines += 1 + use.path.size();
    return lines;
  }
  template <class Body>
  Body& slice() {
    if (out_.empty() || filled_ >= rows_) {
      if (!out_.empty()) out_.back().more = true;
      out_.push_back({id_, Body{}});
      filled_ = 0;
    }
    return std::get<Body>(out_.back().body);
  }
  template <class Body, class Row>
  void fill(std::vector<Row>& rows, std::vector<Row> Body::* list) {
    if (out_.empty()) slice<Body>();
    for (Row& row : rows) {
      (slice<Body>().*list).push_back(std::move(row));
      ++filled_;
    }
  }
  /// Each slice repeats everything but the list.
  template <class Body, class Row>
  std::vector<Reply> slice_list(Body& all, std::vector<Row> Body::* list) {
    auto rows = std::move(all.*list);
    (all.*list).clear();
    slice<Body>() = all;
    for (Row& row : rows) {
      Body& to = slice<Body>();
      if ((to.*list).empty()) to = all;
      (to.*list).push_back(std::move(row));
      ++filled_;
    }
    return std::move(out_);
  }
  void fill_gate(const Gate& gate, std::vector<GateSlot>& rows,
                 std::vector<GateSlot> Gate::* list) {
    for (GateSlot& row : rows) {
      auto& gates = slice<Gates>().gates;
      if (gates.empty()) gates.push_back(gate);
      (gates.back().*list).push_back(std::move(row));
      ++filled_;
    }
  }

  std::uint64_t id_;
  std::size_t rows_;
  std::size_t filled_ = 0;
  std::vector<Reply> out_;
};

}  // namespace

Result<void> join(std::optional<Reply>& whole, Reply slice) {
  if (!whole || std::holds_alternative<Error>(slice.body)) {
    whole = std::move(slice);
    return {};
  }
  if (whole->body.index() != slice.body.index())
    return fail("mlccad sent slices of two kinds of reply to one request");
  whole->more = slice.more;
  std::visit(
      [&](auto& to) { put(to, std::get<std::remove_reference_t<decltype(to)>>(slice.body)); },
      whole->body);
  return {};
}

std::vector<Reply> slices_of(Reply whole, std::size_t rows) {
  return std::visit(Slicer(whole.id, rows), whole.body);
}

}  // namespace mlcca::control
