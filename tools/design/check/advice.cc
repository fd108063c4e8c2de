// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/advice.hpp"

namespace mlcca::tools::design {

const char* advice_on(core::FindingId id) {
  using Id = core::FindingId;
  switch (id) {
    case Id::unreadable:
      return "The file is missing, is not a regular file, or must not be read. Correct the path or "
             "the permissions.";
    case Id::not_xml:
      return "The file breaks the syntax of XML or a limit of its size, is not in UTF-8, or has a "
             "DOCTYPE, which is refused. What follows the mistake is not checked.";
    case Id::not_in_schema:
      return "The text of the finding says what may stand there. system.xsd is the schema: an "
             "editor that knows it marks such mistakes while typing.";
    case Id::rule:
      return "A rule that a schema cannot say is broken. It stands in the schema's documentation "
             "of the element.";
    case Id::unknown_name:
      return "Mostly a typing error: names that are close are suggested. Otherwise the file that "
             "defines the name is not included.";
    case Id::name_twice:
      return "Rename one of the two; the other stands on the line that the finding names.";
    case Id::wrong_place:
      return "Something is stated where it has no meaning, such as a FAMOUSO node on a network "
             "that does not speak it. Remove it, or put it where it belongs.";
    case Id::too_many:
      return "The limits stand in the schema's documentation.";
    case Id::subject_twice:
      return "Gateways tell channels apart by their subject: give each channel its own.";
    case Id::no_publisher:
      return "Whoever subscribes would wait for ever. Add the publisher, or include the file that "
             "has it.";
    case Id::unused_publisher:
      return "The events would be sent for nothing and their capacity be reserved nowhere. Add the "
             "subscriber, or remove the publisher.";
    case Id::unused_channel:
      return "It does no harm; remove the channel if nobody will use it.";
    case Id::no_route:
      return "No chain of gateways joins the two networks. Add a Gateway with a Port on each, or "
             "move an end.";
    case Id::unreachable_network:
      return "Nothing can be exchanged with any other network. Add a Port to a Gateway, or remove "
             "the network.";
    case Id::identifier_clash:
      return "Frames of two channels would look alike on this network. Choose another identifier.";
    case Id::interface_twice:
      return "An interface is on one network. Give one of the ports another identity.";
    case Id::unbound:
      return "Frames on CAN name their channel by an identifier. Add a Binding to the network.";
    case Id::sender_twice:
      return "A gateway could not tell the two senders apart. Give each its own node or user, or "
             "keep one.";
    case Id::unplaced:
      return "State network or gateway of the component, or add one Placement for it.";
    case Id::traffic_mismatch:
      return "No network can repair this: the publisher has to send more often, in smaller events "
             "or with less jitter, or the subscriber has to ask for less.";
    case Id::hop_unfit:
      return "This network or gateway alone does not suffice (the check of Fig. 5 of the paper). "
             "Improve it, ask for less, or take another way. What a network does not state, it "
             "does not give.";
    case Id::route_unfit:
      return "Each hop suffices, all of them together do not: latencies and jitters add up, losses "
             "and omissions multiply. Take a shorter way or improve a hop.";
    case Id::overhearing_unfit:
      return "Events on a shared medium reach every subscriber there. One that is not fulfilled "
             "keeps the way closed for all behind it.";
    case Id::capacity:
      return "The channels described before it have reserved the rest. Send less, or move channels "
             "to another network.";
    case Id::too_long:
      return "An event does not fit a frame, or what FAMOUSO or Cyphal splits it into. Publish a "
             "smaller MaxPayload or use longer frames.";
    case Id::no_node:
      return "Frames of FAMOUSO, J1939 and Cyphal carry the node that sent them. Add attribute "
             "node.";
    case Id::no_traffic:
      return "Without its rate nothing can be reserved. State Period and MaxPayload, or Bandwidth.";
    case Id::run_time:
      return "A dynamic network stated a best case, which can refute and never grant. The gateway "
             "decides when it knows the real value.";
    case Id::lower_set:
      return "An alternative of lower priority is used for all ends of the channel. Improve the "
             "network if the preferred one is needed.";
    case Id::deadline_missed:
      return "Every message on a CAN bus delays others (docs/explanation/can-analysis.md). Send "
             "less often, choose "
             "another "
             "identifier (mlccactl analyse-bus --assign finds an order), allow more time, or let "
             "the "
             "gateway queue by priority (queue=\"priority\" of its Port).";
    case Id::queue_too_short:
      return "More frames may wait in the queue of a gateway than it holds, and one that finds it "
             "full is lost. Give its Port the queue-length that is named, or send less often.";
    case Id::relay_gated:
      return "A gate on a radio sees what its node relays for others, which nobody admitted there, "
             "and drops it: the mesh is cut. Give the Port the mesh's own device (awds0, bat0). "
             "Where nodes relay by routing, let a node that has no gate relay.";
    case Id::no_omission:
      return "A subscriber is told that heart-beats stay out after Omission + 1 Periods. Without "
             "an "
             "Omission it is never told. State how many in a row may be lost.";
    case Id::long_period:
      return "A failure is noticed after (Omission + 1) Periods at the earliest. Mostly the unit "
             "of "
             "the Period is wrong.";
    case Id::managed_in_vain:
      return "mlccad sets the bit rates of CAN interfaces. Of others it only brings the interface "
             "up; "
             "leave them to the network configuration of the machine.";
    case Id::unstarted_sender:
      return "Between CAN and other networks the kernel forwards nothing: a program of the user "
             "that "
             "sender names does. mlccad does not start it; a systemd unit with User= can.";
    case Id::medium_time:
      return "The links of a mesh share the time of their medium (docs/explanation/mesh.md). Send "
             "less, state "
             "a "
             "lower attribute set, or give more important channels an importance.";
    case Id::shared_limit:
      return "Frames of an Ethernet-like network name the subject and not the publisher. With the "
             "address of each stated, gates hold each to what it was admitted for.";
    case Id::not_decided:
      return "Only description/check.xsl says so. What a bus or a mesh gives follows from its bit "
             "rate, its links and everybody on it: mlccactl check computes it.";
    case Id::no_data_rate:
      return "How long an FD frame takes depends on the rate of its data phase. State data-bitrate "
             "of the Bus (equal to bitrate where the rate does not change), or send classic "
             "frames.";
    case Id::unsafe_drop:
      return "A gate drops what it does not know, after a crash too. Make silence the safe state "
             "(a heart-beat), or keep all ends on one network.";
  }
  return "";
}

}  // namespace mlcca::tools::design
