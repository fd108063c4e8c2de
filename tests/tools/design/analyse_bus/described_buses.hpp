// SPDX-License-Identifier: BSD-2-Clause
// Parts of the descriptions that tests of mlccactl analyse-bus have.
#pragma once
#include <fmt/format.h>

#include <string>
#include <vector>

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

inline std::string time_us(const std::string& name, unsigned us) {
  return "<Attribute><Name>" + name +
         "</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-6</Magnitude>"
         "</Dimension><Value>" +
         std::to_string(us) + "</Value></Attribute>";
}

/// A channel from one bus to another with its binding on each; identifier 0: none.
struct Line {
  std::string name;
  std::string from;
  std::string to;
  unsigned id_a;
  unsigned id_b;
  unsigned period;
  unsigned deadline;
};
inline std::string system_with(const std::vector<Line>& lines, const std::string& port = "") {
  std::string channels;
  std::string ends;
  std::string a;
  std::string b;
  unsigned subject = 0;
  for (const Line& l : lines) {
    channels += "<EventChannel name=\"" + l.name + "\"><SubjectUID>" +
                fmt::format("0x{:x}", ++subject) + "</SubjectUID></EventChannel>\n";
    const auto binding = [&](unsigned id) {
      return id == 0 ? std::string()
                     : "<Binding channel=\"" + l.name + "\"><Identifier form=\"standard\">" +
                           fmt::format("0x{:x}", id) + "</Identifier></Binding>";
    };
    a += binding(l.id_a);
    b += binding(l.id_b);
    const auto attributes = "<Attributes>" + time_us("Period", l.period) +
                            time_us("Deadline", l.deadline) +
                            attribute("MaxPayload",
                                      "<Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>"
                                      "<Value>8</Value>") +
                            "</Attributes>";
    ends += "<Publisher name=\"" + l.name + "\" channel=\"" + l.name + "\" network=\"" + l.from +
            "\">" + attributes + "</Publisher>\n<Subscriber name=\"to-" + l.name + "\" channel=\"" +
            l.name + "\" network=\"" + l.to + "\"/>\n";
  }
  const std::string bus = "\"><Kind>can</Kind><Profile>raw</Profile><Bus bitrate=\"500000\"/>";
  return test::system_of(
      channels + "<Network name=\"a" + bus + a + "</Network>\n<Network name=\"b" + bus + b +
      "</Network>\n<Gateway name=\"g\">" + delays(0) +
      "<Port network=\"a\"><Interface name=\"can0\"/></Port><Port network=\"b\"" + port +
      "><Interface name=\"can1\"/></Port></Gateway>\n" + ends);
}

/// X is the lowest of seven on a, and wins against V on b.
inline std::vector<Line> late_on_the_second() {
  std::vector<Line> lines;
  for (unsigned i = 0; i < 6; ++i)
    lines.push_back({"h" + std::to_string(i), "a", "a", 0x10 + i, 0, 20000, 20000});
  lines.push_back({"V", "b", "b", 0, 0x20, 5000, 900});
  lines.push_back({"low", "b", "b", 0, 0x30, 50000, 50000});
  lines.push_back({"X", "a", "b", 0x50, 0x10, 2000, 4000});
  return lines;
}

}  // namespace mlcca
