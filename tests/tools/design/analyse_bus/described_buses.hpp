// SPDX-License-Identifier: BSD-2-Clause
// Parts of the descriptions that tests of mlccactl analyse-bus have.
#pragma once
#include <string>

#include "tests/tools/design/analyse_bus/bus_test.hpp"

namespace mlcca {

inline std::string attribute(const std::string& name, const std::string& value) {
  return "<Attribute><Name>" + name + "</Name>" + value + "</Attribute>";
}
inline std::string time_value(unsigned ms) {
  return "<Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-3</Magnitude></Dimension>"
         "<Value>" +
         std::to_string(ms) + "</Value>";
}
inline std::string payload_of_7() {
  return attribute("MaxPayload",
                   "<Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension><Value>7</Value>");
}

inline std::string delays(unsigned ms) {
  return "<Provision>" + attribute("Latency", time_value(ms)) + "</Provision>";
}

/// Two buses with a gateway; a channel from the first to the second.
inline std::string two_buses(const std::string& publisher_attributes, const std::string& second_bus,
                             const std::string& gateway = delays(0)) {
  return test::system_of(
      "<EventChannel name=\"speed\"><SubjectUID>0x1</SubjectUID></EventChannel>\n"
      "<Network name=\"near\"><Kind>can</Kind><Profile>raw</Profile><Bus bitrate=\"125000\"/>"
      "<Binding channel=\"speed\"><Identifier "
      "form=\"standard\">0x100</Identifier></Binding></Network>\n"
      "<Network name=\"far\"><Kind>can</Kind><Profile>raw</Profile>" +
      second_bus +
      "<Binding channel=\"speed\"><Identifier "
      "form=\"standard\">0x200</Identifier></Binding></Network>\n"
      "<Gateway name=\"bridge\">" +
      gateway +
      "<Port network=\"near\"><Interface name=\"can0\"/></Port>"
      "<Port network=\"far\"><Interface name=\"can1\"/></Port></Gateway>\n"
      "<Publisher name=\"wheel\" channel=\"speed\" network=\"near\"><Attributes>" +
      publisher_attributes +
      "</Attributes></Publisher>\n"
      "<Subscriber name=\"brake\" channel=\"speed\" network=\"far\"><Attributes>" +
      attribute("Deadline", time_value(30)) + "</Attributes></Subscriber>\n");
}

}  // namespace mlcca
