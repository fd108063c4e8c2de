// SPDX-License-Identifier: BSD-2-Clause
// What one gateway may hold of the networks that it shares with others: what the description
// promises, and what it has reserved beyond that, in a store in which all gateways reserve.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "core/model/system.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core {

/// Other gateways carry what each of these admissions needs of them.
struct Agreement {
  std::vector<AdmissionId> admissions;
  std::vector<std::size_t> gateways;
  /// Admissions that another gateway has made. It knows who carries what does not lead over this
  /// one.
  std::vector<AdmissionId> left{};

  [[nodiscard]] bool empty() const {
    return left.empty() && (admissions.empty() || gateways.empty());
  }
};

class Permits {
 public:
  Permits(const System& system, std::size_t self)
      : self_(self),
        standing_(system.networks.size()),
        reserved_(system.networks.size()),
        of_source_(system.networks.size()),
        grown_(system.networks.size(), 0),
        ended_(system.networks.size()) {}

  [[nodiscard]] std::size_t self() const { return self_; }

  /// By network, as Baseline::all() has it.
  void set_standing(std::vector<std::vector<cluster::Standing>> standing);
  /// What was reserved under that number is this from now on: the store has committed it.
  /// `by_another`: another gateway has reserved it, and this one carries it while that lasts.
  /// `agreed`: lasts as long as the reservation.
  void put(std::uint64_t reservation, cluster::Footprint footprint, bool by_another = false,
           Agreement agreed = {});
  void erase(std::uint64_t reservation);
  /// What was reserved may not be used any more, though it may still count; nor may what another
  /// gateway could be elected for. `standing_too`: nor may anything else of shared networks.
  void close(bool standing_too);
  /// All of it may be used again.
  void open();
  [[nodiscard]] bool is_open() const { return open_; }
  /// What the description promises may be used, whatever is reserved.
  [[nodiscard]] bool standing_is_open() const { return standing_open_; }

  /// What a flow would hold of a network.
  struct Use {
    std::size_t network = 0;
    cluster::Source source;
    Value bytes_per_second = 0;
    const can::Message* message = nullptr;
    std::span<const cluster::PathPart> paths;
    bool elected = false;  ///< another gateway could carry it too
  };
  /// `without`: as if that reservation were not there.
  [[nodiscard]] bool allow(const Use& use,
                           std::optional<std::uint64_t> without = std::nullopt) const;

  /// From now on a delivery over other gateways needs the agreement of each of them to one of its
  /// admissions. The description is their agreement to one of which both ends are described.
  void need_agreements() { needs_agreements_ = true; }
  [[nodiscard]] bool needs_agreements() const { return needs_agreements_; }
  /// `without`: as if that reservation were not there.
  [[nodiscard]] bool is_agreed(AdmissionId admission, std::size_t gateway,
                               std::optional<std::uint64_t> without = std::nullopt) const {
    const auto by = agreed_.find({admission, gateway});
    return open_ && by != agreed_.end() &&
           std::ranges::any_of(by->second,
                               [without](std::uint64_t number) { return number != without; });
  }
  /// Whether it is for another gateway to know who has agreed to what does not lead over this one.
  [[nodiscard]] bool is_left_to_another(AdmissionId admission) const {
    return open_ && left_.contains(admission);
  }
  /// As grown() and ended_since(), of the agreements.
  [[nodiscard]] std::uint64_t more_agreed() const { return more_agreed_; }
  [[nodiscard]] std::uint64_t less_agreed() const { return disagreed_.end(); }
  [[nodiscard]] std::optional<std::span<const AdmissionId>> disagreed_since(
      std::uint64_t less_agreed) const {
    return disagreed_.since(less_agreed);
  }

  /// What others have reserved is enough, whether or not it may be used now.
  [[nodiscard]] bool is_reserved_by_another(const Use& use) const;

  [[nodiscard]] std::span<const cluster::Standing> standing(std::size_t network) const {
    return standing_[network];
  }
  /// What is reserved of a network, by number.
  [[nodiscard]] const std::map<std::uint64_t, cluster::Part>& reserved(std::size_t network) const {
    return reserved_[network];
  }
  /// Something is reserved there for what an admission has brought.
  [[nodiscard]] bool has_reserved(std::size_t network, AdmissionId admission) const {
    const auto& all = of_source_[network];
    const auto it = all.lower_bound({.publisher = 0, .admission = admission, .from = 0});
    return it != all.end() && it->first.publisher == 0 && it->first.admission == admission;
  }
  /// Change whenever more, or less, of a network may be used than before.
  [[nodiscard]] std::uint64_t grown(std::size_t network) const { return grown_[network]; }
  [[nodiscard]] std::uint64_t shrunk(std::size_t network) const { return ended_[network].end(); }
  /// The traffic of which less may be used since shrunk() was that number; nullopt: any may be.
  [[nodiscard]] std::optional<std::span<const cluster::Source>> ended_since(
      std::size_t network, std::uint64_t shrunk) const {
    return ended_[network].since(shrunk);
  }

 private:
  struct Allowed;
  /// The latest of what has ended, as many as fit.
  template <class What>
  class Ends {
   public:
    void add(const What& what) {
      constexpr std::size_t most = 1024;
      if (latest_.size() == most) forget();
      latest_.push_back(what);
    }
    /// Anything may have ended.
    void add_any() {
      forget();
      ++first_;
    }
    [[nodiscard]] std::uint64_t end() const { return first_ + latest_.size(); }
    [[nodiscard]] std::optional<std::span<const What>> since(std::uint64_t number) const {
      if (number < first_) return std::nullopt;
      return std::span(latest_).subspan(number - first_);
    }

   private:
    void forget() {
      first_ += latest_.size();
      latest_.clear();
    }
    std::vector<What> latest_;
    std::uint64_t first_ = 0;  ///< number of the oldest of them
  };
  [[nodiscard]] Allowed allowed_by(const cluster::Standing& standing, const Use& use) const;
  [[nodiscard]] static Allowed allowed_by(const cluster::Part& part, const Use& use);
  void changed();
  void agree(std::uint64_t reservation, Agreement agreement);
  void disagree(std::uint64_t reservation);

  std::size_t self_;
  std::vector<std::vector<cluster::Standing>> standing_;          // by network, flows rising
  std::vector<std::map<std::uint64_t, cluster::Part>> reserved_;  // by network
  std::vector<std::map<cluster::Source, std::set<std::uint64_t>>> of_source_;  // by network
  std::set<std::uint64_t> by_another_;
  bool open_ = true;
  bool standing_open_ = true;
  std::vector<std::uint64_t> grown_;
  std::vector<Ends<cluster::Source>> ended_;  // by network
  bool needs_agreements_ = false;
  /// By admission and gateway: the reservations with which it has agreed.
  std::map<std::pair<AdmissionId, std::size_t>, std::set<std::uint64_t>> agreed_;
  std::map<AdmissionId, std::set<std::uint64_t>> left_;  // by which reservations
  std::map<std::uint64_t, Agreement> agreements_;        // of a reservation
  std::uint64_t more_agreed_ = 0;
  Ends<AdmissionId> disagreed_;
};

/// What covers that path of a mesh: as much payload, in events that take no less of its time.
[[nodiscard]] bool covers(const cluster::PathPart& promised, const cluster::PathPart& wanted);

}  // namespace mlcca::core
