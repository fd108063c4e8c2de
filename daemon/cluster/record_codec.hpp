// SPDX-License-Identifier: BSD-2-Clause
// Encodes the records of a cluster for the store, as protobuf (cluster.proto). Records of other
// gateways are checked against this description; what does not fit is rejected completely.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/messages.hpp"
#include "core/cluster/types.hpp"
#include "core/model/system.hpp"

namespace mlcca::cluster {

/// The readers return nullopt for a value that is not a valid record of this description.
class RecordCodec final : public core::cluster::Codec {
 public:
  /// For the description with that digest. Copies what it needs of the system.
  RecordCodec(const core::System& system, const core::cluster::Digest& digest);

  [[nodiscard]] std::string write(const core::cluster::Beat& beat) const override;
  [[nodiscard]] std::string write(const core::cluster::Taken& taken) const override;
  [[nodiscard]] std::string write(const core::cluster::RouteRequest& asked) const override;
  [[nodiscard]] std::string write(const core::cluster::VoteOf& vote) const override;
  [[nodiscard]] std::string write(const core::cluster::Current& current) const override;
  [[nodiscard]] std::string write(const core::cluster::Next& next) const override;
  [[nodiscard]] std::string write(const core::cluster::RolloutVote& vote) const override;

  using Text = std::string_view;
  [[nodiscard]] std::optional<core::cluster::Beat> beat(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::Taken> taken(Text value,
                                                          std::size_t network) const override;
  [[nodiscard]] bool of_other_description(Text taken) const override;
  [[nodiscard]] std::optional<core::cluster::RouteRequest> asked(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::VoteOf> vote(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::Current> current(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::Next> next(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::RolloutVote> rollout_vote(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::Epoch> epoch(Text value) const override;

 private:
  struct Bounds {
    std::size_t nodes = 0;   ///< nodes of the network's mesh
    std::size_t queues = 0;  ///< queues of gateways on it
  };
  [[nodiscard]] std::vector<std::string> names_of(const std::vector<std::size_t>& gateways) const;
  [[nodiscard]] std::optional<std::vector<std::size_t>> gateways_of(
      const std::vector<std::string>& names) const;
  [[nodiscard]] bool is_known(const core::cluster::Source& source) const;

  core::cluster::Digest digest_;
  std::vector<std::string> gateways_, networks_;
  std::vector<Bounds> bounds_;  ///< by network
  std::size_t publishers_;
};

/// The request for a reservation, as the store has it under x/<gateway>/<number>.
struct StoredRequest {
  /// The most requests of one, `requests` and `also` together: each of them is decided by itself at
  /// each gateway on the way.
  static constexpr std::size_t kMostRequests = 256;
  std::string channel;
  std::vector<control::Request> requests;
  std::vector<control::Request> also = {};  ///< others of it, whose publishers count
  /// The gateway that must agree is to make this admission in its own name.
  bool on_behalf = false;
  /// For an admission that is made so: the gateway that has asked for it, and its number there.
  std::string for_gateway = {};
  std::uint64_t for_number = 0;
  [[nodiscard]] std::size_t size() const { return requests.size() + also.size(); }
};
[[nodiscard]] std::string text_of(const StoredRequest& asked);
/// nullopt if it is not such a text, or has requests of another kind.
[[nodiscard]] std::optional<StoredRequest> asked_in(std::string_view text);

}  // namespace mlcca::cluster
