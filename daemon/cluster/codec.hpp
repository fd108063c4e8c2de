// SPDX-License-Identifier: BSD-2-Clause
// The records of a cluster as they are in the store: protobuf (cluster.proto). What somebody else
// has written is believed as far as it can be of this description, and not at all otherwise.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/messages.hpp"
#include "core/cluster/types.hpp"
#include "core/model/system.hpp"

namespace mlcca::cluster {

class Codec final : public core::cluster::Codec {
 public:
  /// Of the description of that digest. What it needs of the system it copies.
  Codec(const core::System& system, const core::cluster::Digest& digest);

  [[nodiscard]] std::string write(const core::cluster::Beat& beat) const override;
  [[nodiscard]] std::string write(const core::cluster::Taken& taken) const override;
  [[nodiscard]] std::string write(const core::cluster::Asked& asked) const override;
  [[nodiscard]] std::string write(const core::cluster::VoteOf& vote) const override;
  [[nodiscard]] std::string write(const core::cluster::Current& current) const override;
  [[nodiscard]] std::string write(const core::cluster::Next& next) const override;
  [[nodiscard]] std::string write(const core::cluster::RolloutVote& vote) const override;

  using Text = std::string_view;
  [[nodiscard]] std::optional<core::cluster::Beat> beat(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::Taken> taken(Text value,
                                                          std::size_t network) const override;
  [[nodiscard]] std::optional<core::cluster::Asked> asked(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::VoteOf> vote(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::Current> current(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::Next> next(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::RolloutVote> rollout_vote(Text value) const override;
  [[nodiscard]] std::optional<core::cluster::Epoch> epoch(Text value) const override;

 private:
  struct Bounds {
    std::size_t nodes = 0;   ///< of the network's mesh
    std::size_t queues = 0;  ///< of gateways there
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

/// What an admission asks for, as x/<gateway>/<number> has it.
struct Asked {
  std::string channel;
  std::vector<control::Request> requests;
  std::vector<control::Request> also = {};  ///< of the same gateway, that bring publishers of it
};
[[nodiscard]] std::string text_of(const Asked& asked);
/// Nothing: it is no such text, or has requests of another kind.
[[nodiscard]] std::optional<Asked> asked_in(std::string_view text);

}  // namespace mlcca::cluster
