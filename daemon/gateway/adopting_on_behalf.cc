// SPDX-License-Identifier: BSD-2-Clause
// Admissions that this gateway makes for another one, because it has admitted the publisher.
#include <utility>
#include <variant>

#include "control/protobuf.hpp"
#include "daemon/gateway/adopting.hpp"
#include "daemon/gateway/requests/asked.hpp"

namespace mlcca {

Adopting::Adopted* Adopting::find(const Ref& ref) {
  const auto it = adopted_.find({ref.origin.gateway, ref.origin.id});
  return it == adopted_.end() || it->second.number != ref.number ? nullptr : &it->second;
}

/// The other gateway asks again after a refusal, unless the publisher is gone.
void Adopting::answer(Adopted& adopted, const std::string& why) {
  adopted.answer = vote_of(why);
  adopted.answer.final =
      !why.empty() && !adopted.ours.empty() && hands_.is_publisher_gone(adopted.ours.front());
  set_due(adopted, Due::answer);
}

/// Asks the store for what the subscriber of another gateway needs. The vote is the result.
void Adopting::begin_on_behalf(Adopted& adopted) {
  const auto& requests = adopted.asked->requests;
  if (requests.size() != 1 || describes_publisher(std::get<control::Admit>(requests.front().body)))
    return answer(adopted, "what is asked for is not understood here");
  const WhichRequest& which = adopted.asks.back();
  if (const std::string why = end_former(adopted, which); !why.empty()) return answer(adopted, why);
  if (requests_.held(which) != nullptr) return answer(adopted, kAskedBefore);
  hold(adopted, which, with_own_number(requests.front()));
  const Ref ref{.origin = adopted.origin, .number = adopted.number};
  const auto asked = hands_.ask({.decide = [this, ref] { return wish_on_behalf(ref); },
                                 .granted = [this, ref] { return open_on_behalf(ref); },
                                 .refused =
                                     [this, ref](const std::string& why) {
                                       if (auto* const there = find(ref)) answer(*there, why);
                                     },
                                 .gateway = ref.origin.gateway,
                                 .adopted = ref.number});
  if (!asked) answer(adopted, asked.error().text);
}

/// An earlier process of this gateway may have admitted it, and it is reserved.
void Adopting::resume(Adopted& adopted) {
  const auto& requests = adopted.asked->requests;
  const auto found = found_.find({hands_.name_of(adopted.origin.gateway), adopted.origin.id});
  if (found == found_.end() || requests.size() != 1 ||
      found->second.body != requests.front().body || requests_.held(adopted.asks.back()) != nullptr)
    return;
  hold(adopted, adopted.asks.back(), found->second);
  adopted.open = true;
  set_due(adopted, Due::resume);
  found_.erase(found);
}

std::optional<Reserving::Wish> Adopting::wish_on_behalf(const Ref& ref) {
  auto* const adopted = find(ref);
  if (adopted == nullptr) return std::nullopt;
  auto wish = hands_.wish(adopted->ours.front(), ref.origin.gateway);
  if (!wish) {
    answer(*adopted, wish.error().text);
    return std::nullopt;
  }
  wish->asked.for_gateway = hands_.name_of(ref.origin.gateway);
  wish->asked.for_number = ref.origin.id;
  return std::move(*wish);
}

bool Adopting::open_on_behalf(const Ref& ref) {
  auto* const adopted = find(ref);
  if (adopted == nullptr) return false;
  const auto done = hands_.admit(adopted->ours.front());
  adopted->open = done.has_value();
  answer(*adopted, done ? std::string() : done.error().text);
  return adopted->open;
}

bool Adopting::keep_found(const cluster::Asked& asked) {
  if (asked.for_gateway.empty() || asked.requests.size() != 1) return false;
  found_.insert_or_assign(For(asked.for_gateway, asked.for_number), asked.requests.front());
  return true;
}

void Adopting::publishers_gone() { to_check_.insert(on_behalf_.begin(), on_behalf_.end()); }

bool Adopting::ends_with_publisher(Adopted& adopted) {
  if (!adopted.open || !hands_.is_without_publisher(adopted.ours.front())) return false;
  close(adopted);
  answer(adopted, "the publisher that it is for is not admitted any more");
  return true;
}

void Adopting::withdrawn(core::AdmissionId id, const std::string& why) {
  const auto holder = holders_.find(id);
  if (holder == holders_.end()) return;
  Adopted& adopted = adopted_.at(holder->second);
  if (!adopted.is_on_behalf() || !adopted.open) return;
  close(adopted);
  answer(adopted, why);
}

}  // namespace mlcca
