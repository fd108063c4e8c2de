// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/identity.hpp"

#include <systemd/sd-device.h>

#include <map>
#include <memory>
#include <string_view>

#include "base/handle.hpp"
#include "base/number.hpp"

namespace mlcca::net {
namespace {

using Device = std::unique_ptr<sd_device, FreeWith<sd_device_unref>>;

std::optional<unsigned> number_of(sd_device* device, const char* attribute) {
  const char* text = nullptr;
  if (sd_device_get_sysattr_value(device, attribute, &text) < 0) return std::nullopt;
  std::string_view digits(text);
  const bool hex = digits.starts_with("0x");
  if (hex) digits.remove_prefix(2);
  return take_number<unsigned>(digits, hex ? kHexadecimalBase : kDecimalBase);
}

bool needs_udev(const core::InterfaceIdentity& id) {
  return !id.id_path.empty() || !id.serial.empty() || id.port;
}

bool matches(const core::InterfaceIdentity& id, const Link& link, const FactsOf& facts_of) {
  if (!id.name.empty() && id.name != link.name) return false;
  if (!id.alias.empty() && id.alias != link.alias) return false;
  if (!needs_udev(id)) return true;
  const UdevFacts facts = facts_of(link.ifindex);
  return (id.id_path.empty() || id.id_path == facts.id_path) &&
         (id.serial.empty() || id.serial == facts.serial) && (!id.port || id.port == facts.port);
}

}  // namespace

UdevFacts udev_facts(int ifindex) {
  sd_device* raw = nullptr;
  if (sd_device_new_from_ifindex(&raw, ifindex) < 0) return {};
  const Device device(raw);
  UdevFacts facts;
  const char* text = nullptr;
  if (sd_device_get_property_value(device.get(), "ID_PATH", &text) >= 0) facts.id_path = text;
  if (sd_device_get_property_value(device.get(), "ID_SERIAL_SHORT", &text) >= 0)
    facts.serial = text;
  facts.port = number_of(device.get(), "dev_port");
  if (const auto id = number_of(device.get(), "dev_id"); id && *id != 0) facts.port = id;
  return facts;
}

FactsOf read_once(const FactsOf& facts_of) {
  return [facts_of, known = std::make_shared<std::map<int, UdevFacts>>()](int ifindex) {
    const auto [it, fresh] = known->try_emplace(ifindex);
    if (fresh) it->second = facts_of(ifindex);
    return it->second;
  };
}

Result<std::optional<int>> find_interface(const core::InterfaceIdentity& identity,
                                          const InterfaceTable& links, const FactsOf& facts_of) {
  std::optional<int> found;
  for (const auto& [ifindex, link] : links) {
    if (!matches(identity, link, facts_of)) continue;
    if (found)
      return fail("both " + links.at(*found).name + " and " + link.name + " match " +
                  to_text(identity) + ": name the interface more closely");
    found = ifindex;
  }
  return found;
}

std::string to_text(const core::InterfaceIdentity& id) {
  std::string text;
  const auto add = [&text](std::string_view what, const std::string& value) {
    if (value.empty()) return;
    if (!text.empty()) text += ' ';
    text.append(what).append(" ").append(value);
  };
  add("name", id.name);
  add("id-path", id.id_path);
  add("serial", id.serial);
  add("alias", id.alias);
  if (id.port) add("port", std::to_string(*id.port));
  return text;
}

}  // namespace mlcca::net
