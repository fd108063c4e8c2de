// SPDX-License-Identifier: BSD-2-Clause
// A member of the store whose answers a test says.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cluster/channel.hpp"

namespace mlcca::test {

struct FakeCall {
  cluster::Request request;
  bool dropped = false;
  bool sent = true;

  void answer(std::string octets) const { request.on_answer(std::move(octets)); }
  void end(int status, std::string text = {}) const {
    // The request may be over with what it calls.
    const auto on_end = request.on_end;
    on_end({.status = status, .text = std::move(text), .sent = sent});
  }
};

class FakeChannel final : public cluster::Channel {
 public:
  using Calls = std::vector<std::shared_ptr<FakeCall>>;
  explicit FakeChannel(Calls& calls) : calls_(calls) {}

  std::unique_ptr<cluster::Call> start(cluster::Request request) override {
    calls_.push_back(std::make_shared<FakeCall>(FakeCall{.request = std::move(request)}));
    return std::make_unique<Handle>(calls_.back());
  }

 private:
  class Handle final : public cluster::Call {
   public:
    explicit Handle(std::shared_ptr<FakeCall> call) : call_(std::move(call)) {}
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    Handle(Handle&&) = delete;
    Handle& operator=(Handle&&) = delete;
    ~Handle() override { call_->dropped = true; }
    [[nodiscard]] bool sent() const override { return call_->sent; }

   private:
    std::shared_ptr<FakeCall> call_;
  };

  Calls& calls_;
};

}  // namespace mlcca::test
