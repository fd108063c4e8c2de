// SPDX-License-Identifier: BSD-2-Clause
// What a channel of a program is to its connection.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "mlcca/client/client.hpp"

namespace mlcca::client {

struct Channel::Part {
  control::AnnounceRequest request;
  Answer answer;
  Handler handler;
  std::uint64_t subject = 0;  ///< 0: not known yet
  std::uint64_t asked = 0;    ///< the request that waits for an answer, 0: none
  bool lost = false;          ///< the daemon went after it was announced
  /// What has happened and is handled once the answer to it is there.
  std::vector<control::Event> waiting;
  std::weak_ptr<Client::Connection> connection;
};

}  // namespace mlcca::client
