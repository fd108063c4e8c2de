// SPDX-License-Identifier: BSD-2-Clause
// How often the messages of a DBC file come: cycles, least distances and send types.
#pragma once
#include <string>
#include <string_view>

#include "core/model/system.hpp"
#include "mlcca/attribute.hpp"
#include "tools/design/import/dbc.hpp"
#include "tools/design/import/lacks.hpp"

namespace mlcca::tools::design {

/// When a message is sent, by its send type or those of its signals.
struct DbcSendType {
  bool known = true;    ///< false: the text of the type has no meaning here
  bool stated = false;  ///< false: no type is stated, or one that says so ("NoMsgSendType")
  bool cyclic = false;  ///< in a cycle
  bool active = false;  ///< the cycle runs, or is another one, only while a signal is active
  bool events = false;  ///< when something happens, or when it is asked for
};

/// The meaning of a value of GenMsgSendType or GenSigSendType. Known are the types of the tables of
/// Vector and of vehicle manufacturers, in upper or lower case, also with an x or underscores.
DbcSendType send_type_of(std::string_view type);

struct DbcTiming {
  Value period = 0;  ///< ns
  core::Arrival arrival{};
  std::string remark;    ///< an assumption, for an XML comment; empty: none
  bool assumed = false;  ///< no time is stated
};

/// The timing of a message. `default_period` (ns) is that of a message without any stated time.
/// Adds assumptions, and times that have no place in the result, to `lacks`.
DbcTiming timing_of(const DbcMessage& message, Value default_period, Lacks& lacks);

}  // namespace mlcca::tools::design
