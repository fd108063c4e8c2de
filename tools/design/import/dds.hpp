// SPDX-License-Identifier: BSD-2-Clause
// Imports the quality of service of DDS from ROS 2 output and XML profiles: what it states of
// periods, lifespans and losses.
#pragma once
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

/// A QoS policy that has no counterpart in a description, or whose value is not understood.
struct DdsPolicy {
  std::string name;
  std::string value;
  int line = 0;
};

/// A data writer or data reader of a topic.
struct DdsEnd {
  bool writes = false;
  int line = 0;
  std::string node;
  std::string topic;
  std::string type;
  std::optional<Value> deadline, lifespan, lease;  ///< ns; nullopt: not stated, or infinite
  std::vector<DdsPolicy> policies;
};

/// The kind of a duration.
enum class DdsDuration : std::uint8_t { finite, infinite, no_number };

/// Stores a duration of `ns` in `to`. 0 and the values for "infinite" of DDS (2147483647 s) and ROS
/// 2 leave `to` without a value.
DdsDuration take_duration(std::optional<std::uint64_t> ns, std::optional<Value>& to);

/// Collects the writers and readers of a file and converts them into a network.
class DdsEnds {
 public:
  /// Adds an end. Returns what is wrong with it; empty: nothing is.
  std::string add(DdsEnd end);
  Lacks lacks;
  /// The network of the ends. `error` is an error in the file, if there was one; `lacking` says
  /// what a file without any end should have had.
  Result<ImportedNetwork> take(const std::string& file, const ImportOptions& options,
                               const std::string& error, std::string_view lacking);

 private:
  std::vector<DdsEnd> ends_;
  std::set<std::string> nodes_;
};

/// Imports qos_overrides from a parameter file of ROS 2 nodes.
Result<ImportedNetwork> import_ros2_params(std::string_view text, const std::string& file,
                                           const ImportOptions& options);
/// Imports the output of `ros2 topic info --verbose` for one or several topics.
Result<ImportedNetwork> import_ros2_topics(std::string_view text, const std::string& file,
                                           const ImportOptions& options);
/// Imports XML profiles of DDS-XML and Fast DDS.
Result<ImportedNetwork> import_dds_xml(std::string_view text, const std::string& file,
                                       const ImportOptions& options);

}  // namespace mlcca::tools::design
