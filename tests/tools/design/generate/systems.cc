// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/design/generate/systems.hpp"

namespace mlcca::test {
namespace {

const std::string kTime = "<Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>";

std::string plain(const std::string& name, const std::string& value) {
  return "<Attribute><Name>" + name + "</Name><Value>" + value + "</Value></Attribute>";
}
std::string time(const std::string& name, const std::string& value, const std::string& magnitude) {
  return "<Attribute><Name>" + name + "</Name>" + kTime + magnitude +
         "</Magnitude></Dimension><Value>" + value + "</Value></Attribute>";
}
std::string rate(const std::string& value, const std::string& magnitude) {
  return "<Attribute><Name>Bandwidth</Name><Dimension><SIUnit><Seconds>-1</Seconds>"
         "<Bytes>1</Bytes></SIUnit><Magnitude>" +
         magnitude + "</Magnitude></Dimension><Value>" + value + "</Value></Attribute>";
}
std::string bytes(const std::string& value) {
  return "<Attribute><Name>MaxPayload</Name><Dimension><SIUnit><Bytes>1</Bytes></SIUnit>"
         "</Dimension><Value>" +
         value + "</Value></Attribute>";
}

std::string bus(const std::string& name, const std::string& provision,
                const std::string& bindings) {
  return "<Network name=\"" + name + "\"><Kind>can</Kind><Profile>famouso</Profile><Provision>" +
         provision + "</Provision>" + bindings + "</Network>\n";
}

}  // namespace

std::string robot(const std::string& lost) {
  const auto provision = plain("Omission", lost) + time("Period", "10", "-3") +
                         time("Latency", "5", "-3") + bytes("8");
  const std::string binding = "<Binding channel=\"emergency-switch\"><ETag>0x64</ETag></Binding>";
  return "<System name=\"robot\">\n"
         "<EventChannel name=\"emergency-switch\"><SubjectUID>0xa4efeccc3210b497</SubjectUID>"
         "<Description>heart-beats while it is not pressed</Description><Attributes>" +
         plain("Omission", "2") + time("Period", "50", "-3") + bytes("8") +
         "</Attributes></EventChannel>\n" + bus("robot-can", provision, binding) +
         bus("second-can", provision, binding) + "<Gateway name=\"bridge\"><Provision>" +
         plain("Omission", "0") + time("Latency", "2", "-3") +
         "</Provision><Port network=\"robot-can\"><Interface name=\"can0\"/></Port>"
         "<Port network=\"second-can\"><Interface name=\"can1\"/></Port></Gateway>\n"
         "<Component name=\"switch\" network=\"robot-can\" node=\"1\">"
         "<Publisher channel=\"emergency-switch\"/></Component>\n"
         "<Component name=\"motors\" network=\"robot-can\">"
         "<Subscriber channel=\"emergency-switch\"/></Component>\n"
         "<Subscriber channel=\"emergency-switch\" network=\"second-can\" name=\"lamp\"/>\n"
         "</System>\n";
}

std::string jittery(const std::string& sent, const std::string& added, const std::string& asked) {
  const auto own = [](const std::string& jitter) {
    return "<Attributes>" + time("Jitter", jitter, "-3") + "</Attributes>";
  };
  return "<System name=\"s\"><EventChannel name=\"c\"><SubjectUID>0x1</SubjectUID></EventChannel>"
         "<Network name=\"n\"><Kind>other</Kind><Provision>" +
         time("Jitter", added, "-3") +
         "</Provision></Network>"
         "<Publisher channel=\"c\" network=\"n\" name=\"from\">" +
         own(sent) + R"(</Publisher><Subscriber channel="c" network="n" name="to">)" + own(asked) +
         "</Subscriber></System>\n";
}

std::string on_a_bus(const std::string& bitrate, const std::string& more) {
  return "<System name=\"s\"><EventChannel name=\"stop\"><SubjectUID>0x1</SubjectUID><Attributes>" +
         time("Period", "50", "-3") + bytes("8") +
         "</Attributes></EventChannel><Network name=\"bus\"><Kind>can</Kind><Profile>famouso"
         "</Profile><Bus bitrate=\"" +
         bitrate + "\"/><Binding channel=\"stop\"><ETag>0x64</ETag></Binding>" +
         (more.contains("\"more\"") ? "<Binding channel=\"more\"><ETag>0x65</ETag></Binding>"
                                    : "") +
         "</Network>"
         "<Publisher name=\"switch\" channel=\"stop\" network=\"bus\" node=\"0x20\"/>"
         "<Subscriber name=\"lamp\" channel=\"stop\" network=\"bus\"/>" +
         more + "</System>\n";
}

std::string one_more(bool publisher, bool subscriber) {
  return "<EventChannel name=\"more\"><SubjectUID>0x2</SubjectUID><Attributes>" +
         time("Period", "1", "-3") + "</Attributes></EventChannel>" +
         (publisher ? R"(<Publisher name="p" channel="more" network="bus" node="0x21"/>)" : "") +
         (subscriber ? R"(<Subscriber name="q" channel="more" network="bus"/>)" : "");
}

std::string unknown_mesh() {
  return "<System name=\"s\"><EventChannel name=\"beat\"><SubjectUID>0x1</SubjectUID><Attributes>" +
         time("Period", "50", "-3") + bytes("8") +
         "</Attributes></EventChannel><Network name=\"mesh\"><Kind>mesh</Kind><Mesh>"
         "<Node name=\"robot\" address=\"02:00:00:00:00:01\"/>"
         "<Node name=\"base\" address=\"02:00:00:00:00:02\"/>"
         "<Source kind=\"file\" endpoint=\"/run/links\"/></Mesh></Network>"
         "<Publisher channel=\"beat\" network=\"mesh\" mesh-node=\"robot\"/>"
         "<Subscriber channel=\"beat\" network=\"mesh\" mesh-node=\"base\"/></System>\n";
}

std::string called(const std::string& name) {
  const auto is = " name=\"" + name + "\"";
  std::string own;  // letters and digits only
  for (const char c : name)
    if (c != '_') own += c;
  const auto ends = [&](const char* end) {
    return " network=\"" + name + "\"><" + end + " channel=\"" + name + "\"/></Component>";
  };
  return "<System" + is + "><UserAttribute name=\"" + own +
         "\"><Better>smaller</Better><Composition>sum</Composition></UserAttribute><EventChannel" +
         is + "><SubjectUID>0x1</SubjectUID><Attributes>" + plain(own, "3") +
         "</Attributes></EventChannel><Network" + is + "><Kind>other</Kind><Provision>" +
         plain(own, "3") + "</Provision></Network><Component" + is + ends("Publisher") +
         "<Component name=\"other\"" + ends("Subscriber") + "</System>\n";
}

std::string with_user_attributes(int count, bool of_network) {
  std::string declared;
  std::string stated;
  std::string most;  // as much as a list holds
  for (int i = 0; i < count; ++i) {
    const auto name = "Own" + std::to_string(i);
    declared += "<UserAttribute name=\"" + name +
                "\"><Better>smaller</Better><Composition>sum</Composition></UserAttribute>";
    stated += plain(name, "3");
    if (of_network || i < 16) most += plain(name, "3");
  }
  return "<System name=\"s\">" + declared +
         "<EventChannel name=\"c\"><SubjectUID>0x1</SubjectUID><Attributes>" +
         (of_network ? plain("Omission", "1") : stated) +
         "</Attributes></EventChannel><Network name=\"n\"><Kind>other</Kind><Provision>" +
         plain("Omission", "1") + most +
         "</Provision></Network><Publisher channel=\"c\" network=\"n\"/></System>\n";
}

std::string nasty() {
  const auto provision =
      plain("Omission", "0") + time("Period", "1", "-9") + time("Latency", "0", "0") +
      time("Jitter", "0", "0") + rate("18446744073709551614", "0") + bytes("18446744073709551614") +
      plain("PacketLoss", "0") + plain("Wear", "18446744073709551614") + plain("Int", "3");
  const std::string largest = "18446744073709551614";
  const auto small = "<Attributes>" + rate("1", "0") + "</Attributes>";
  return "<System name=\"class\">\n"
         "<UserAttribute name=\"Wear\"><Better>larger</Better><Composition>minimum</Composition>"
         "</UserAttribute>\n"
         "<UserAttribute name=\"Int\"><Better>smaller</Better><Composition>sum</Composition>"
         "</UserAttribute>\n"
         // What it says would end a comment, join the next line to it, and turn the text around.
         "<EventChannel name=\"int\"><SubjectUID>0x1</SubjectUID>"
         "<Description>*/ #error \" &#x202e; ?\?/ \\</Description><Attributes>" +
         plain("Omission", "4294967295") + time("Latency", largest, "-9") +
         time("Deadline", "1", "-9") + time("Period", "18446744073", "0") + rate("1", "0") +
         plain("PacketLoss", "1") + bytes("8") + plain("Int", "7") + plain("Wear", "0") +
         "</Attributes></EventChannel>\n"
         "<EventChannel name=\"NULL\"><SubjectUID>0x2</SubjectUID><Attributes priority=\"5\">" +
         plain("Omission", "0") + rate("1", "0") + time("Latency", "1500", "-9") +
         "</Attributes><Attributes priority=\"-5\">" + plain("Omission", "40000") + rate("1", "0") +
         "</Attributes></EventChannel>\n"
         "<EventChannel name=\"a.b\"><SubjectUID>0x3</SubjectUID>" +
         small +
         "</EventChannel>\n"
         "<EventChannel name=\"a-b\"><SubjectUID>0x4</SubjectUID>" +
         small +
         "</EventChannel>\n"
         "<EventChannel name=\"A-B\"><SubjectUID>0x5</SubjectUID>" +
         small +
         "</EventChannel>\n"
         "<EventChannel><SubjectUID>0xDEADbeef00000001</SubjectUID>" +
         small +
         "</EventChannel>\n"
         "<Network name=\"std\"><Kind>other</Kind><Provision>" +
         provision +
         "</Provision></Network>\n"
         "<Network name=\"Std\"><Kind>other</Kind><Provision>" +
         rate("1", "0") +
         "</Provision></Network>\n"
         "<Gateway name=\"auto\"><Port network=\"std\"><Interface name=\"a0\"/></Port>"
         "<Port network=\"Std\"><Interface name=\"a1\"/></Port></Gateway>\n"
         "<Component name=\"mlcca\" network=\"std\">"
         "<Publisher channel=\"int\"/><Publisher channel=\"NULL\"/><Publisher channel=\"a.b\"/>"
         "<Publisher channel=\"a-b\"/><Publisher channel=\"A-B\"/>"
         "<Publisher channel=\"0xdeadbeef00000001\"/></Component>\n"
         "<Component name=\"linux\" network=\"std\"><Subscriber channel=\"int\"/>"
         "<Subscriber channel=\"NULL\"/><Subscriber channel=\"a.b\" name=\"x\"/>"
         "<Subscriber channel=\"a.b\" name=\"X\"/></Component>\n"
         "<Component name=\"x\" network=\"Std\"><Subscriber channel=\"0xdeadbeef00000001\"/>"
         "</Component>\n"
         "<Component name=\"X\" network=\"std\"><Subscriber channel=\"a-b\"/></Component>\n"
         "</System>\n";
}

}  // namespace mlcca::test
