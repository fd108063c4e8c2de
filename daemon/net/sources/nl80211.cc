// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/nl80211.hpp"

#include <linux/nl80211.h>
#include <netlink/attr.h>
#include <netlink/netlink.h>

#include <cerrno>
#include <string>
#include <utility>

#include "daemon/net/sources/kernel_source.hpp"
#include "daemon/net/sources/nl80211_view.hpp"

namespace mlcca::net {
namespace {

class Nl80211Source : public KernelSource {
 public:
  Nl80211Source(std::string interface, sd_event* loop, Report report)
      : KernelSource(loop, std::move(report)), interface_(std::move(interface)) {}

 private:
  void poll() override {
    seen_ = {};
    ask_family(NL80211_GENL_NAME, interface_,
               [this](Conversation& kernel, std::uint16_t family, unsigned index) {
                 index_ = index;
                 ask_interface(kernel, family);
               });
  }

  [[nodiscard]] Conversation::Request request(std::uint16_t family, std::uint8_t command,
                                              int flags) const {
    auto made = Conversation::generic_request(family, command, flags);
    if (made) nla_put_u32(made.get(), NL80211_ATTR_IFINDEX, index_);
    return made;
  }

  void ask_interface(Conversation& kernel, std::uint16_t family) {
    kernel.ask(
        request(family, NL80211_CMD_GET_INTERFACE, 0),
        [this](genl::Octets octets) {
          if (auto read = nl80211::read_interface(octets)) seen_.interface = std::move(*read);
        },
        [this, family](int error) {
          if (error != 0) {
            report_refusal(interface_ + " is no radio", error);
            return;
          }
          if (!seen_.interface.frequency) {
            report_problem(interface_ + " is on no channel (down, or has joined nothing)");
            return;
          }
          ask_links(*talk(NETLINK_GENERIC), family);
        });
  }

  void ask_links(Conversation& kernel, std::uint16_t family) {
    kernel.ask(
        request(family, NL80211_CMD_GET_STATION, NLM_F_DUMP),
        [this](genl::Octets octets) {
          if (auto read = nl80211::read_station(octets)) seen_.stations.push_back(std::move(*read));
        },
        [this](int error) {
          if (error != 0) report_refusal("stations of " + interface_, error);
        });
    if (seen_.interface.mesh) {
      kernel.ask(
          request(family, NL80211_CMD_GET_MPATH, NLM_F_DUMP),
          [this](genl::Octets octets) {
            if (auto read = nl80211::read_mesh_path(octets))
              seen_.paths.push_back(std::move(*read));
          },
          [this](int error) {
            if (error != 0) report_refusal("mesh paths of " + interface_, error);
          });
    }
    kernel.ask(
        request(family, NL80211_CMD_GET_SURVEY, NLM_F_DUMP),
        [this](genl::Octets octets) {
          if (auto read = nl80211::read_survey(octets)) seen_.surveys.push_back(*read);
        },
        [this](int error) {
          // Some drivers do not count how busy their channel is.
          if (error != 0 && error != EOPNOTSUPP) {
            report_refusal("survey of " + interface_, error);
            return;
          }
          auto snapshot = view_.update(seen_, now());
          if (view_.unconfirmed()) poll_again_soon();
          report(std::move(snapshot));
        });
  }

  std::string interface_;
  unsigned index_ = 0;
  nl80211::Seen seen_;
  nl80211::View view_;
};

}  // namespace

Result<std::unique_ptr<LinkSource>> open_nl80211(const core::mesh::Source& source, sd_event* loop,
                                                 LinkSource::Report report) {
  if (source.interface.empty()) return fail("a source nl80211 needs the name of an interface");
  auto made = std::make_unique<Nl80211Source>(source.interface, loop, std::move(report));
  if (auto started = made->start(); !started) return std::unexpected(started.error());
  return made;
}

}  // namespace mlcca::net
