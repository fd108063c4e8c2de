// SPDX-License-Identifier: BSD-2-Clause
#include "mlcca/client/client.hpp"

#include <utility>

#include "base/number.hpp"
#include "client/connection.hpp"
#include "client/part.hpp"
#include "control/attributes.hpp"

namespace mlcca::client {
const char* name_of(Cause cause) {
  switch (cause) {
    case Cause::granted:
      return "granted";
    case Cause::refused:
      return "refused";
    case Cause::withdrawn:
      return "withdrawn";
    case Cause::rejected:
      return "rejected";
    case Cause::degraded:
      return "degraded";
    case Cause::upgraded:
      return "upgraded";
    case Cause::policed:
      return "policed";
    case Cause::dropped:
      return "dropped";
    case Cause::missing:
      return "missing";
    case Cause::restored:
      return "restored";
    case Cause::missed:
      return "missed";
    case Cause::network_down:
      return "network-down";
    case Cause::late:
      return "late";
    case Cause::gates_closed:
      return "gates-closed";
    case Cause::mode:
      return "mode";
    case Cause::lagged:
      return "lagged";
    case Cause::daemon_gone:
      return "daemon-gone";
    case Cause::daemon_back:
      return "daemon-back";
    case Cause::other:
      break;
  }
  return "other";
}

const char* name_of(Published published) {
  switch (published) {
    case Published::sent:
      return "sent";
    case Published::partly:
      return "sent in part";
    case Published::lost:
      return "lost";
    case Published::not_granted:
      return "not granted";
    case Published::too_long:
      return "too long";
  }
  return "unknown";
}

const char* name_of(State state) {
  switch (state) {
    case State::unannounced:
      return "unannounced";
    case State::granted:
      return "granted";
    case State::partly:
      return "granted in part";
    case State::refused:
      return "refused";
    case State::rejected:
      return "rejected";
    case State::no_daemon:
      return "no daemon";
  }
  return "unknown";
}

Client::Client(Options options) : connection_(std::make_shared<Connection>(std::move(options))) {}
Client::~Client() = default;

int Client::fd() const { return connection_->fd(); }
bool Client::is_connected() const { return connection_->is_connected(); }
std::uint64_t Client::lost() const { return connection_->data().lost(); }

void Client::process() {
  const auto connection = connection_;  // keeps it alive: a handler may destroy this client
  connection->run(std::chrono::milliseconds(0));
}

void Client::wait(std::chrono::milliseconds time) {
  const auto connection = connection_;
  connection->run(time);
}

Channel::Channel(Client& client, Role role, std::string channel, const AttributeSet& stated,
                 std::string name)
    : part_(std::make_shared<Part>()) {
  part_->request = {
      .channel = std::move(channel),
      .role = role == Role::publisher ? control::Role::publisher : control::Role::subscriber,
      .name = std::move(name),
      .attributes = control::attributes_of(stated)};
  part_->subject = prefixed_number_in<std::uint64_t>(part_->request.channel).value_or(0);
  part_->connection = client.connection_;
}
Channel::~Channel() = default;

void Channel::on_exception(Handler handler) {
  part_->handler = handler ? std::make_shared<const Handler>(std::move(handler)) : nullptr;
}
std::shared_ptr<const Answer> Channel::answer() const { return part_->answer.get(); }

Published Channel::send(const void* data, std::size_t size) {
  const auto connection = part_->connection.lock();
  if (!connection) return Published::not_granted;
  return connection->data().publish(part_, {static_cast<const std::uint8_t*>(data), size});
}

void Channel::receive(std::function<void(const Event&)> handler) {
  using Handlers = std::function<void(const Event&)>;
  part_->on_event = handler ? std::make_shared<const Handlers>(std::move(handler)) : nullptr;
}

std::uint64_t Channel::losses() const {
  const auto connection = part_->connection.lock();
  return connection ? connection->data().lost(part_) : part_->lost_events;
}

std::shared_ptr<const Answer> Channel::take_up() {
  if (const auto connection = part_->connection.lock()) connection->take_up(part_);
  return part_->answer.get();
}

}  // namespace mlcca::client
