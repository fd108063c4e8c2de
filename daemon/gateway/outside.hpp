// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <systemd/sd-event.h>

#include <memory>

#include "base/clock.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/described.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/rollout.hpp"
#include "daemon/outside/background.hpp"
#include "daemon/outside/can_sender.hpp"
#include "daemon/outside/cluster_link.hpp"
#include "daemon/outside/description_texts.hpp"
#include "daemon/outside/gate_control.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/outside/link_monitor.hpp"
#include "daemon/store/disk.hpp"

namespace mlcca {

/// The interfaces of the daemon to everything outside it. All references must outlive the
/// Controller.
struct Outside {
  GateDriver& gates;
  GateControl& control;
  LinkMonitor& links;
  CanSender& can;
  const Clock& clock;
  store::Disk& disk;
  Background& reading;  ///< thread that reads descriptions
  EventLog& log;
  ReadDescription read;
  ReadText read_text;                 ///< null unless the gateway is in a cluster
  DescriptionTexts* texts = nullptr;  ///< null unless the gateway is in a cluster
  std::unique_ptr<net::CanRules> can_rules;
  sd_event* loop;  ///< loop of the link sources, and of reports that are made aside
  /// Operations that may hang (disk, description) run on a thread while heart-beats continue.
  bool threads = true;
  ClusterLink* cluster = nullptr;  ///< null unless the gateway reserves shared networks in a store
};

}  // namespace mlcca
