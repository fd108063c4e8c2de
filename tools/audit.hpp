// SPDX-License-Identifier: BSD-2-Clause
// Output of audit mode: what the gates refused or would have refused, and the elements that a
// description would need to admit it.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "core/gates/frame_reason.hpp"
#include "tools/table.hpp"

namespace mlcca::tools {

/// For each finding of `audit`, in the same order: the XML elements that the description lacks,
/// with a comment that states what was seen and where each element belongs. Findings of one subject
/// share a channel, which is in the text of the first of them. A text is empty if no channel can
/// have such frames, as malformed ones, if the texts before it contain all that is needed, or if
/// the finding is about a described delivery.
std::vector<std::string> additions_of(const control::Audit& audit);
/// The texts of additions_of() that are not empty, separated by blank lines. A comment follows for
/// each finding with further frames, whose kinds are not known.
std::string additions(const control::Audit& audit);

/// The reason for all frames of a finding, or for the latest of them. Nullopt if the finding states
/// none that is known here.
std::optional<core::FrameReason> reason_of(const control::Finding& finding);
/// Whether it is about CAN frames of no delivery whose identifier is known.
bool is_can_frame(const control::Finding& finding);
/// What a finding is about: "123" (a CAN identifier), "0x4e6f626f64790000" (a subject),
/// "emergency-switch of switch" (a delivery), "others" (frames of kinds that are not known); empty
/// for frames of which neither identifier nor subject could be read.
std::string name_of(const control::Finding& finding);
/// For a finding about a described delivery or publisher: one line of advice for the case that its
/// frames are wanted; empty if there is none.
std::string advice(const control::Finding& finding);
/// The sender: "192.0.2.7 (02:00:5e:10:00:01)" or "node 23"; of what left, "user 1000", the
/// interface by which it came in, or "node 23 by can1"; "others" of a delivery that more others
/// send than are counted one by one; empty if it is not known.
std::string sender_of(const control::Finding& finding);

/// A table of the findings, and below it the additions of the first of them.
std::string render(const control::Audit& audit, Color color);

}  // namespace mlcca::tools
