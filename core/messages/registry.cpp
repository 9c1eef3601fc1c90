// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>

#include "swiftlet/core/messages/chase_report.hpp"
#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/map_closures.hpp"
#include "swiftlet/core/messages/map_rays.hpp"
#include "swiftlet/core/messages/neighbor_position.hpp"
#include "swiftlet/core/messages/odometry_report.hpp"
#include "swiftlet/core/messages/shared_path.hpp"
#include "swiftlet/core/messages/submap_chunk.hpp"
#include "swiftlet/core/messages/submap_descriptor.hpp"
#include "swiftlet/core/messages/submap_places.hpp"
#include "swiftlet/core/messages/submap_request.hpp"
#include "swiftlet/core/messages/track_report.hpp"

namespace swiftlet {
namespace {

// Message kinds of vehicles: a new kind is one line here.
constexpr MessageKind kKinds[] = {
    message_kind<NeighborPosition>(), message_kind<OdometryReport>(), message_kind<GuidingPath>(),
    message_kind<MapRays>(),          message_kind<SharedPath>(),     message_kind<SubmapDescriptor>(),
    message_kind<SubmapPlaces>(),     message_kind<SubmapRequest>(),  message_kind<SubmapChunk>(),
    message_kind<MapClosures>(),      message_kind<TrackReport>(),    message_kind<ChaseReport>(),
};

/// Fields that recordings add to a message.
struct Reception {
  VehicleId from = kNoVehicle;
  TimeNs received = 0;

  static void visit(auto& r, auto& v) {
    v.vehicle("sender", r.from, "[-] sending vehicle");
    v.time("received_s", r.received, "[s] time of reception");
  }
};

}  // namespace

std::span<const MessageKind> message_kinds() { return kKinds; }

const MessageKind* find_message_kind(std::string_view topic) {
  const auto found = std::find_if(std::begin(kKinds), std::end(kKinds),
                                  [topic](const MessageKind& kind) { return topic == kind.topic; });
  return found == std::end(kKinds) ? nullptr : found;
}

std::vector<Column> message_columns(const MessageKind& kind) {
  std::vector<Column> columns = kind.columns();
  for (Column& column : columns_of<Reception>()) columns.push_back(std::move(column));
  return columns;
}

void put_message(const MessageKind& kind, const Message& message, ColumnSink& sink) {
  if (kind.read(message, &sink) == Reading::kDone) put_columns(Reception{message.from, message.received}, sink);
}

}  // namespace swiftlet
