// SPDX-License-Identifier: BSD-2-Clause
// Quality of service of DDS, as ROS 2 and XML profiles state it: what it says of periods, ages and
// losses.
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

/// A policy that has no counterpart, or a value that is not understood.
struct DdsPolicy {
  std::string name;
  std::string value;
  int line = 0;
};

/// A data writer or a data reader of a topic.
struct DdsEnd {
  bool writes = false;
  int line = 0;
  std::string node;
  std::string topic;
  std::string type;
  std::optional<Value> deadline, lifespan, lease;  ///< ns; none: not stated, or infinite
  std::vector<DdsPolicy> policies;
};

/// What a duration says.
enum class DdsDuration : std::uint8_t { finite, infinite, no_number };

/// Of ns; 0 and the "infinite" of DDS (2147483647 s) and of ROS 2 state nothing.
DdsDuration take_duration(std::optional<std::uint64_t> ns, std::optional<Value>& to);

/// Ends of one file, with which it says what has no counterpart.
class DdsEnds {
 public:
  /// What is wrong with one more; empty: nothing.
  std::string add(DdsEnd end);
  Lacks lacks;
  /// The network that they become; `error`: what was wrong with the file, if anything was;
  /// `lacking`: what it ought to have, where it has no end.
  Result<ImportedNetwork> take(const std::string& file, const ImportOptions& options,
                               const std::string& error, std::string_view lacking);

 private:
  std::vector<DdsEnd> ends_;
  std::set<std::string> nodes_;
};

/// qos_overrides in parameters of ROS 2 nodes.
Result<ImportedNetwork> import_ros2_params(std::string_view text, const std::string& file,
                                           const ImportOptions& options);
/// What `ros2 topic info --verbose` prints, of one topic or of several.
Result<ImportedNetwork> import_ros2_topics(std::string_view text, const std::string& file,
                                           const ImportOptions& options);
/// XML profiles of DDS-XML and Fast DDS.
Result<ImportedNetwork> import_dds_xml(std::string_view text, const std::string& file,
                                       const ImportOptions& options);

}  // namespace mlcca::tools::design
