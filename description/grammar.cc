// SPDX-License-Identifier: BSD-2-Clause
// The table of elements, from the leaves to System.
#include "description/grammar.hpp"

#include <array>

namespace mlcca::description {
namespace {

constexpr ElementType plain(const ValueType& type) {
  return {.name = {}, .value = &type, .steps = {}, .keys = {}};
}

constexpr auto kText = plain(type::kText);
constexpr auto kSubject = plain(type::kSubject);
constexpr auto kShortHex = plain(type::kShortHex);
constexpr auto kDecimal = plain(type::kDecimal);
constexpr auto kExponent = plain(type::kExponent);
constexpr auto kMagnitude = plain(type::kMagnitude);
constexpr auto kBitrate = plain(type::kBitrate);
constexpr auto kDataBitrate = plain(type::kDataBitrate);
constexpr auto kAttributeName = plain(type::kAttributeName);
constexpr auto kBetter = plain(type::kBetter);
constexpr auto kComposition = plain(type::kComposition);
constexpr auto kNetworkKind = plain(type::kNetworkKind);
constexpr auto kProfile = plain(type::kProfile);

template <std::size_t N>
using Children = std::array<Child, N>;

// --- quantities
// -----------------------------------------------------------------------------------

constexpr Children<1> kSeconds{{{"Seconds", &kExponent}}};
constexpr Children<1> kBytes{{{"Bytes", &kExponent}}};
constexpr Children<1> kMetres{{{"Metres", &kExponent}}};
constexpr Children<1> kKilograms{{{"Kilograms", &kExponent}}};
constexpr Children<1> kAmperes{{{"Amperes", &kExponent}}};
constexpr Children<1> kKelvins{{{"Kelvins", &kExponent}}};
constexpr Children<1> kMoles{{{"Moles", &kExponent}}};
constexpr Children<1> kCandelas{{{"Candelas", &kExponent}}};
constexpr auto kSiUnitSteps = std::to_array<Step>({{.children = kSeconds, .least = 0},
                                                   {.children = kBytes, .least = 0},
                                                   {.children = kMetres, .least = 0},
                                                   {.children = kKilograms, .least = 0},
                                                   {.children = kAmperes, .least = 0},
                                                   {.children = kKelvins, .least = 0},
                                                   {.children = kMoles, .least = 0},
                                                   {.children = kCandelas, .least = 0}});
constexpr ElementType kSiUnit{
    .name = "SIUnit", .steps = kSiUnitSteps, .any_order = true, .keys = {}};

constexpr Children<1> kSiUnitChild{{{"SIUnit", &kSiUnit}}};
constexpr Children<1> kMagnitudeChild{{{"Magnitude", &kMagnitude}}};
constexpr auto kDimensionSteps = std::to_array<Step>(
    {{.children = kSiUnitChild, .least = 0}, {.children = kMagnitudeChild, .least = 0}});
constexpr ElementType kDimension{.name = "Dimension", .steps = kDimensionSteps, .keys = {}};

constexpr Children<1> kNameChild{{{"Name", &kAttributeName}}};
constexpr Children<1> kDimensionChild{{{"Dimension", &kDimension}}};
constexpr Children<1> kValueChild{{{"Value", &kDecimal}}};
constexpr auto kQuantity = std::to_array<Step>({{.children = kNameChild},
                                                {.children = kDimensionChild, .least = 0},
                                                {.children = kValueChild}});
constexpr auto kDynamic = std::to_array<Key>({{"dynamic", &type::kBoolean}});
constexpr ElementType kAttribute{.name = "Attribute", .steps = kQuantity, .keys = {}};
constexpr ElementType kProvidedAttribute{
    .name = "ProvidedAttribute", .steps = kQuantity, .keys = kDynamic};

constexpr Children<1> kRequired{{{"Attribute", &kAttribute}}};
constexpr auto kAttributesSteps =
    std::to_array<Step>({{.children = kRequired, .least = 0, .most = kUnlimited}});
constexpr auto kAttributesKeys = std::to_array<Key>({{"priority", &type::kSetPriority}});
constexpr ElementType kAttributes{
    .name = "Attributes", .steps = kAttributesSteps, .keys = kAttributesKeys};

constexpr Children<1> kProvided{{{"Attribute", &kProvidedAttribute}}};
constexpr auto kProvisionSteps =
    std::to_array<Step>({{.children = kProvided, .least = 0, .most = kUnlimited}});
constexpr ElementType kProvision{.name = "Provision", .steps = kProvisionSteps, .keys = kDynamic};

constexpr Children<1> kDescription{{{"Description", &kText}}};
constexpr Children<1> kBetterChild{{{"Better", &kBetter}}};
constexpr Children<1> kCompositionChild{{{"Composition", &kComposition}}};
constexpr auto kUserAttributeSteps = std::to_array<Step>({{.children = kDescription, .least = 0},
                                                          {.children = kDimensionChild, .least = 0},
                                                          {.children = kBetterChild},
                                                          {.children = kCompositionChild}});
constexpr auto kUserAttributeKeys = std::to_array<Key>({{"name", &type::kAttributeName, true}});
constexpr ElementType kUserAttribute{
    .name = "UserAttribute", .steps = kUserAttributeSteps, .keys = kUserAttributeKeys};

// --- channels and their ends
// ----------------------------------------------------------------------

constexpr Children<1> kSubjectChild{{{"SubjectUID", &kSubject}}};
constexpr Children<1> kAttributesChild{{{"Attributes", &kAttributes}}};
constexpr auto kChannelSteps =
    std::to_array<Step>({{.children = kSubjectChild},
                         {.children = kDescription, .least = 0},
                         {.children = kAttributesChild, .least = 0, .most = 16}});
constexpr auto kChannelKeys = std::to_array<Key>(
    {{"name", &type::kName}, {"safe-side", &type::kSafeSide}, {"importance", &type::kImportance}});
constexpr ElementType kEventChannel{
    .name = "EventChannel", .steps = kChannelSteps, .keys = kChannelKeys};

constexpr auto kEndSteps =
    std::to_array<Step>({{.children = kAttributesChild, .least = 0, .most = 17}});
constexpr auto kPublisherKeys = std::to_array<Key>({{"channel", &type::kChannelName, true},
                                                    {"network", &type::kName},
                                                    {"gateway", &type::kName},
                                                    {"mesh-node", &type::kName},
                                                    {"name", &type::kName},
                                                    {"node", &type::kSmallNumber},
                                                    {"priority", &type::kSmallNumber},
                                                    {"address", &type::kSenderAddress},
                                                    {"user", &type::kUserName}});
constexpr ElementType kPublisher{.name = "Publisher", .steps = kEndSteps, .keys = kPublisherKeys};

constexpr auto kSubscriberKeys = std::to_array<Key>({{"channel", &type::kChannelName, true},
                                                     {"network", &type::kName},
                                                     {"gateway", &type::kName},
                                                     {"mesh-node", &type::kName},
                                                     {"name", &type::kName}});
constexpr ElementType kSubscriber{
    .name = "Subscriber", .steps = kEndSteps, .keys = kSubscriberKeys};

constexpr Children<3> kComponentParts{
    {{"EventChannel", &kEventChannel}, {"Publisher", &kPublisher}, {"Subscriber", &kSubscriber}}};
constexpr auto kComponentSteps = std::to_array<Step>(
    {{.children = kDescription, .least = 0},
     {.children = kComponentParts, .least = 0, .most = kUnlimited, .includes = true}});
constexpr auto kComponentKeys = std::to_array<Key>({{"name", &type::kName, true},
                                                    {"network", &type::kName},
                                                    {"gateway", &type::kName},
                                                    {"mesh-node", &type::kName},
                                                    {"node", &type::kSmallNumber},
                                                    {"priority", &type::kSmallNumber},
                                                    {"address", &type::kSenderAddress},
                                                    {"user", &type::kUserName}});
constexpr ElementType kComponent{
    .name = "Component", .steps = kComponentSteps, .keys = kComponentKeys};

constexpr auto kPlacementKeys = std::to_array<Key>({{"component", &type::kName, true},
                                                    {"network", &type::kName},
                                                    {"gateway", &type::kName},
                                                    {"mesh-node", &type::kName},
                                                    {"node", &type::kSmallNumber},
                                                    {"priority", &type::kSmallNumber},
                                                    {"address", &type::kSenderAddress},
                                                    {"user", &type::kUserName}});
constexpr ElementType kPlacement{.name = "Placement", .steps = {}, .keys = kPlacementKeys};

// --- networks, gateways, routes
// -------------------------------------------------------------------

constexpr auto kIdentifierKeys =
    std::to_array<Key>({{"form", &type::kIdentifierForm, true}, {"mask", &type::kShortHex}});
constexpr ElementType kIdentifier{
    .name = "Identifier", .value = &type::kShortHex, .steps = {}, .keys = kIdentifierKeys};

constexpr auto kPgnKeys = std::to_array<Key>(
    {{"priority", &type::kMessagePriority}, {"destination", &type::kSmallNumber}});
constexpr ElementType kPgn{.name = "PGN", .value = &type::kNumber, .steps = {}, .keys = kPgnKeys};

constexpr auto kSubjectIdKeys = std::to_array<Key>({{"priority", &type::kMessagePriority}});
constexpr ElementType kSubjectId{
    .name = "SubjectID", .value = &type::kNumber, .steps = {}, .keys = kSubjectIdKeys};

constexpr Children<5> kBindingForms{{{"ETag", &kShortHex},
                                     {"Identifier", &kIdentifier},
                                     {"PGN", &kPgn},
                                     {"SubjectID", &kSubjectId},
                                     {"COBID", &kShortHex}}};
constexpr auto kBindingSteps = std::to_array<Step>({{.children = kBindingForms, .least = 0}});
constexpr auto kBindingKeys = std::to_array<Key>({{"channel", &type::kChannelName, true},
                                                  {"format", &type::kFrameFormat},
                                                  {"remote-frames", &type::kBoolean},
                                                  {"dynamic", &type::kBoolean}});
constexpr ElementType kBinding{.name = "Binding", .steps = kBindingSteps, .keys = kBindingKeys};

constexpr auto kBusKeys = std::to_array<Key>({{"bitrate", &type::kBitrate, true},
                                              {"data-bitrate", &type::kDataBitrate},
                                              {"measured", &type::kBoolean},
                                              {"unknown-senders", &type::kBoolean},
                                              {"background-load", &type::kDecimal},
                                              {"errors", &type::kErrorCount},
                                              {"error-interval", &type::kDecimal}});
constexpr ElementType kBus{.name = "Bus", .steps = {}, .keys = kBusKeys};

constexpr ElementType kPerHop{.name = "PerHop", .steps = kAttributesSteps, .keys = {}};

constexpr auto kMeshNodeKeys = std::to_array<Key>({{"name", &type::kName, true},
                                                   {"address", &type::kNodeAddress, true},
                                                   {"gateway", &type::kName}});
constexpr ElementType kMeshNode{.name = "MeshNode", .steps = {}, .keys = kMeshNodeKeys};

constexpr auto kMeshLinkKeys = std::to_array<Key>({{"from", &type::kName, true},
                                                   {"to", &type::kName, true},
                                                   {"rate", &type::kLinkRate, true},
                                                   {"loss", &type::kDecimal},
                                                   {"channel", &type::kMediumNumber},
                                                   {"kind", &type::kRateKind},
                                                   {"both-ways", &type::kBoolean}});
constexpr ElementType kMeshLink{.name = "MeshLink", .steps = {}, .keys = kMeshLinkKeys};

constexpr auto kFromTo =
    std::to_array<Key>({{"from", &type::kName, true}, {"to", &type::kName, true}});
constexpr ElementType kMeshMember{.name = "MeshMember", .steps = {}, .keys = kFromTo};

constexpr auto kNamed = std::to_array<Key>({{"name", &type::kName, true}});
constexpr Children<1> kMemberChild{{{"Member", &kMeshMember}}};
constexpr auto kMeshDomainSteps =
    std::to_array<Step>({{.children = kMemberChild, .least = 0, .most = kUnlimited}});
constexpr ElementType kMeshDomain{.name = "MeshDomain", .steps = kMeshDomainSteps, .keys = kNamed};

constexpr auto kMeshSourceKeys = std::to_array<Key>({{"kind", &type::kSourceKind, true},
                                                     {"interface", &type::kInterfaceName},
                                                     {"endpoint", &type::kDeviceText},
                                                     {"metric", &type::kLinkMetric}});
constexpr ElementType kMeshSource{.name = "MeshSource", .steps = {}, .keys = kMeshSourceKeys};

constexpr Children<1> kPerHopChild{{{"PerHop", &kPerHop}}};
constexpr Children<1> kNodeChild{{{"Node", &kMeshNode}}};
constexpr Children<1> kLinkChild{{{"Link", &kMeshLink}}};
constexpr Children<1> kDomainChild{{{"Domain", &kMeshDomain}}};
constexpr Children<1> kSourceChild{{{"Source", &kMeshSource}}};
constexpr auto kMeshSteps =
    std::to_array<Step>({{.children = kPerHopChild, .least = 0},
                         {.children = kNodeChild, .least = 0, .most = kUnlimited},
                         {.children = kLinkChild, .least = 0, .most = kUnlimited},
                         {.children = kDomainChild, .least = 0, .most = kUnlimited},
                         {.children = kSourceChild, .least = 0, .most = kUnlimited}});
constexpr auto kMeshKeys = std::to_array<Key>({{"interference", &type::kInterference},
                                               {"hops", &type::kHopCount},
                                               {"limit", &type::kDecimal},
                                               {"packet-bytes", &type::kPacketBytes},
                                               {"header-bytes", &type::kHeaderBytes},
                                               {"packet-time", &type::kDecimal},
                                               {"stale-after", &type::kDecimal},
                                               {"hold-up", &type::kDecimal},
                                               {"tolerance", &type::kDecimal}});
constexpr ElementType kMesh{.name = "Mesh", .steps = kMeshSteps, .keys = kMeshKeys};

constexpr Children<1> kKindChild{{{"Kind", &kNetworkKind}}};
constexpr Children<1> kProfileChild{{{"Profile", &kProfile}}};
constexpr Children<1> kBusChild{{{"Bus", &kBus}}};
constexpr Children<1> kMeshChild{{{"Mesh", &kMesh}}};
constexpr Children<1> kProvisionChild{{{"Provision", &kProvision}}};
constexpr Children<1> kBindingChild{{{"Binding", &kBinding}}};
constexpr auto kUnlistedKeys =
    std::to_array<Key>({{"allow", &type::kSubjectRange}, {"most", &type::kUnlistedCount}});
constexpr ElementType kUnlisted{.name = "Unlisted", .steps = {}, .keys = kUnlistedKeys};

constexpr Children<1> kUnlistedChild{{{"Unlisted", &kUnlisted}}};
constexpr auto kNetworkSteps =
    std::to_array<Step>({{.children = kKindChild},
                         {.children = kProfileChild, .least = 0},
                         {.children = kBusChild, .least = 0},
                         {.children = kMeshChild, .least = 0},
                         {.children = kProvisionChild, .least = 0},
                         {.children = kBindingChild, .least = 0, .most = kUnlimited},
                         {.children = kUnlistedChild, .least = 0}});
constexpr auto kNetworkKeys = std::to_array<Key>({{"name", &type::kName, true},
                                                  {"control", &type::kControlKinds},
                                                  {"control-rate", &type::kControlRate},
                                                  {"subscribe-etag", &type::kShortHex}});
constexpr ElementType kNetwork{.name = "Network", .steps = kNetworkSteps, .keys = kNetworkKeys};

constexpr auto kInterfaceKeys = std::to_array<Key>({{"name", &type::kInterfaceName},
                                                    {"id-path", &type::kDeviceText},
                                                    {"serial", &type::kDeviceText},
                                                    {"alias", &type::kDeviceText},
                                                    {"port", &type::kPortNumber}});
constexpr ElementType kInterface{.name = "Interface", .steps = {}, .keys = kInterfaceKeys};

constexpr Children<1> kInterfaceChild{{{"Interface", &kInterface}}};
constexpr Children<1> kBitrateChild{{{"Bitrate", &kBitrate}}};
constexpr Children<1> kDataBitrateChild{{{"DataBitrate", &kDataBitrate}}};
constexpr auto kPortSteps =
    std::to_array<Step>({{.children = kInterfaceChild},
                         {.children = kBitrateChild, .least = 0},
                         {.children = kDataBitrateChild, .least = 0, .needs_previous = true}});
constexpr auto kPortKeys = std::to_array<Key>({{"network", &type::kName, true},
                                               {"managed", &type::kBoolean},
                                               {"queue", &type::kQueueing},
                                               {"fifo-depth", &type::kFifoDepth},
                                               {"queue-length", &type::kQueueLength},
                                               {"excess", &type::kExcess},
                                               {"refused", &type::kRefused},
                                               {"control", &type::kControlKinds},
                                               {"control-rate", &type::kControlRate},
                                               {"control-user", &type::kUserName},
                                               {"node", &type::kSmallNumber},
                                               {"sender", &type::kUserName}});
constexpr ElementType kPort{.name = "Port", .steps = kPortSteps, .keys = kPortKeys};

constexpr Children<1> kPortChild{{{"Port", &kPort}}};
constexpr auto kGatewaySteps = std::to_array<Step>(
    {{.children = kProvisionChild, .least = 0}, {.children = kPortChild, .most = kUnlimited}});
constexpr auto kGatewayKeys = std::to_array<Key>(
    {{"name", &type::kName, true}, {"host", &type::kHostName}, {"forward", &type::kForwarder}});
constexpr ElementType kGateway{.name = "Gateway", .steps = kGatewaySteps, .keys = kGatewayKeys};

constexpr auto kHopKeys = std::to_array<Key>({{"place", &type::kName, true}});
constexpr ElementType kHop{.name = "Hop", .steps = {}, .keys = kHopKeys};

constexpr Children<1> kHopChild{{{"Hop", &kHop}}};
constexpr auto kRouteSteps = std::to_array<Step>({{.children = kHopChild, .least = 0, .most = 14}});
constexpr ElementType kRoute{.name = "Route", .steps = kRouteSteps, .keys = kFromTo};

// --- the system
// -----------------------------------------------------------------------------------

constexpr Children<9> kSystemParts{{{"EventChannel", &kEventChannel},
                                    {"UserAttribute", &kUserAttribute},
                                    {"Network", &kNetwork},
                                    {"Gateway", &kGateway},
                                    {"Component", &kComponent},
                                    {"Placement", &kPlacement},
                                    {"Route", &kRoute},
                                    {"Publisher", &kPublisher},
                                    {"Subscriber", &kSubscriber}}};
constexpr auto kSystemSteps = std::to_array<Step>(
    {{.children = kSystemParts, .least = 0, .most = kUnlimited, .includes = true}});
constexpr ElementType kSystem{.name = "System", .steps = kSystemSteps, .keys = kNamed};
constexpr Child kRoot{"System", &kSystem};

constexpr auto kTypes = std::to_array<const ElementType*>({&kSystem,       &kUserAttribute,
                                                           &kEventChannel, &kNetwork,
                                                           &kGateway,      &kComponent,
                                                           &kPlacement,    &kRoute,
                                                           &kPublisher,    &kSubscriber,
                                                           &kHop,          &kPort,
                                                           &kInterface,    &kBinding,
                                                           &kIdentifier,   &kPgn,
                                                           &kSubjectId,    &kProvision,
                                                           &kAttributes,   &kAttribute,
                                                           &kDimension,    &kProvidedAttribute,
                                                           &kSiUnit,       &kBus,
                                                           &kMesh,         &kPerHop,
                                                           &kMeshNode,     &kMeshLink,
                                                           &kMeshDomain,   &kMeshMember,
                                                           &kMeshSource,   &kUnlisted});

}  // namespace

const Child& system_root() { return kRoot; }
std::span<const Child> system_parts() { return kSystemParts; }
std::span<const ElementType* const> element_types() { return kTypes; }

}  // namespace mlcca::description
