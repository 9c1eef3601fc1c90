// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/map_sharing.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/slam/graph/closure.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/map_closures.hpp"
#include "swiftlet/core/messages/submap_chunk.hpp"
#include "swiftlet/core/messages/submap_descriptor.hpp"
#include "swiftlet/core/messages/submap_places.hpp"
#include "swiftlet/core/messages/submap_request.hpp"

namespace swiftlet {
namespace {

// Limits on received messages; messages beyond them are rejected.
constexpr std::uint32_t kMostSubmaps = 4096;
constexpr std::size_t kMostChunks = 256;
constexpr std::uint32_t kMostPoints = 50000;  // points of a compact cloud
constexpr std::size_t kMostPlaces = 32;       // places in a message
constexpr std::size_t kMostClosures = 32;     // closures with one vehicle
constexpr double kFarthest_m = 1e5;           // distance from the start of a flight
constexpr double kMaxPathLength_m = 1e6;
constexpr double kFarthestInSubmap_m = 200.0;
constexpr double kMostTiltCosine = 0.9;  // cosine of the tilt of a submap

constexpr std::size_t kMostWaiting = 2;           // received clouds not yet searched
constexpr int kMostSent = 8;                      // messages sent per step
constexpr double kLeastBetween_s = 1.0;           // shortest interval between reports of places, and between joins
constexpr double kLargestMessage_bytes = 1200.0;  // all messages but chunks
constexpr double kChunkHead_bytes = 100.0;
constexpr double kBurst_s = 0.1;

Pose level_pose(const Pose& T) { return make_pose(T.translation(), rotation_by({0.0, 0.0, yaw_of(T.linear())})); }

Eigen::Vector3f turn_of(const Pose& T) {
  return rotation_vector_rad(Eigen::Quaterniond(Matrix3(T.linear()))).cast<float>();
}

/// The received pose, or none if it is implausible.
std::optional<Pose> received_pose(const Eigen::Vector3f& p_m, const Eigen::Vector3f& turn_rad, double farthest_m) {
  if (!p_m.allFinite() || !turn_rad.allFinite()) return std::nullopt;
  if (p_m.cwiseAbs().maxCoeff() > farthest_m || turn_rad.norm() > kPi + 0.01) return std::nullopt;
  const Pose T = make_pose(p_m.cast<double>(), rotation_by(turn_rad.cast<double>()));
  if (T.linear()(2, 2) < kMostTiltCosine) return std::nullopt;
  return T;
}

std::vector<std::uint8_t> bits_of(std::span<const std::uint8_t> flags) {
  std::vector<std::uint8_t> bits((flags.size() + 7) / 8, 0);
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] != 0) bits[i / 8] = static_cast<std::uint8_t>(bits[i / 8] | 1U << (i % 8));
  }
  return bits;
}

bool bit_at(std::span<const std::uint8_t> bits, std::size_t i) { return (bits[i / 8] >> (i % 8) & 1U) != 0; }

bool is_same(const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); }

bool is_about_maps(const std::string& topic) {
  return topic == SubmapDescriptor::kTopic || topic == SubmapPlaces::kTopic || topic == SubmapRequest::kTopic ||
         topic == SubmapChunk::kTopic || topic == MapClosures::kTopic;
}

}  // namespace

MapSharing::MapSharing(const MapSharingConfig& config, VehicleId self, int num_vehicles)
    : config_(config), self_(self), peers_(static_cast<std::size_t>(num_vehicles)), worker_(config.latency_s) {
  ENSURE(self >= 0 && self < num_vehicles, self, num_vehicles);
}

void MapSharing::step(TimeNs t, const SubmapProvider& own, std::span<const Message> messages, Outbox& outbox) {
  look_at_own(own);
  update_places(own);
  for (const Message& message : messages) {
    if (!is_about_maps(message.topic)) continue;
    ++num_received_;
    if (!receive(t, message)) ++num_refused_;
  }
  settle_search(t);
  search(t, own);
  join(t);
  for (std::size_t i = 0; i < peers_.size(); ++i) {
    if (searches_in(static_cast<VehicleId>(i))) choose_cloud(t, peers_[i]);
  }
  send(t, outbox);
}

void MapSharing::look_at_own(const SubmapProvider& own) {
  while (static_cast<int>(own_.size()) + 1 < own.num_submaps()) {
    const std::span<const Eigen::Vector3f> points_m = own.points_submap_m(static_cast<int>(own_.size()));
    const CompactCloudConfig& cloud = config_.cloud;
    OwnSubmap& finished = own_.emplace_back();
    finished.look = look_of(points_m, cloud.voxel_m, cloud.range_max_m);
    finished.chunks = pack_points(points_to_share_m(points_m, cloud), cloud.voxel_m, cloud.bits, cloud.chunk_bytes);
    if (finished.chunks.size() > kMostChunks) finished.chunks.resize(kMostChunks);
    for (const PackedPoints& chunk : finished.chunks) finished.num_points += chunk.num_points;
    for (Peer& other : peers_) {
      for (PeerSubmap& peer_submap : other.submaps) {
        if (peer_submap.look)
          peer_submap.similarity = std::max(peer_submap.similarity, likeness(finished.look, *peer_submap.look));
      }
    }
  }
}

void MapSharing::update_places(const SubmapProvider& own) {
  if (places_known_ && places_revision_ == own.places_revision()) return;
  if (own.num_submaps() == 0) return;
  places_known_ = true;
  places_revision_ = own.places_revision();
  own_places_.resize(static_cast<std::size_t>(own.num_submaps()));
  for (int i = 0; i < own.num_submaps(); ++i) {
    own_places_[static_cast<std::size_t>(i)] = {true, own.T_local_submap(i), own.path_length_m(i)};
  }
  places_due_ = true;
  for (Peer& other : peers_) other.has_new_closures = true;
}

// Received messages.

bool MapSharing::receive(TimeNs t, const Message& message) {
  if (message.from < 0 || static_cast<std::size_t>(message.from) >= peers_.size() || message.from == self_)
    return false;
  Peer& from = peers_[static_cast<std::size_t>(message.from)];
  const bool is_valid = message.topic == SubmapPlaces::kTopic       ? receive_places(t, from, message)
                        : message.topic == SubmapDescriptor::kTopic ? receive_descriptor(from, message)
                        : message.topic == SubmapRequest::kTopic    ? receive_request(from, message)
                        : message.topic == SubmapChunk::kTopic      ? receive_chunk(t, from, message)
                                                                    : receive_closures(from, message);
  if (!is_valid) return false;
  from.last_report = t;
  from.has_reported = true;
  return true;
}

bool MapSharing::receive_places(TimeNs t, Peer& from, const Message& message) {
  SubmapPlaces received;
  if (read_message(message, received) != Reading::kDone) return false;
  const std::size_t end = received.first + received.places.size();
  if (received.num_finished >= kMostSubmaps || received.first > kMostSubmaps || received.places.size() > kMostPlaces ||
      end > std::size_t{received.num_finished} + 1) {
    return false;
  }
  std::vector<SubmapPlace> places;
  for (const SubmapPlaces::Place& place : received.places) {
    const std::optional<Pose> T = received_pose(place.p_local_m, place.turn_local_rad, kFarthest_m);
    if (!T || !(place.path_length_m >= 0.0F && place.path_length_m <= static_cast<float>(kMaxPathLength_m)))
      return false;
    places.push_back({true, *T, static_cast<double>(place.path_length_m)});
  }
  if (from.places.size() < end) from.places.resize(end);
  for (std::size_t i = 0; i < places.size(); ++i) {
    SubmapPlace& known = from.places[received.first + i];
    from.has_new_closures =
        from.has_new_closures || !known.known || !is_same(known.T_local_submap, places[i].T_local_submap);
    known = places[i];
  }
  if (received.num_finished > from.num_finished) {
    from.num_finished = received.num_finished;
    from.descriptors_requested = t;  // the descriptors of new submaps are in transit
  }
  return true;
}

MapSharing::PeerSubmap& MapSharing::submap_of(Peer& from, std::uint32_t number) {
  if (from.submaps.size() <= number) from.submaps.resize(number + 1);
  return from.submaps[number];
}

bool MapSharing::receive_descriptor(Peer& from, const Message& message) {
  SubmapDescriptor received;
  if (read_message(message, received) != Reading::kDone) return false;
  if (received.submap >= kMostSubmaps || received.num_chunks > kMostChunks || received.num_points > kMostPoints)
    return false;
  std::optional<SubmapLook> look = SubmapLook::from_quantized(received.directions, received.heights);
  if (!look) return false;
  PeerSubmap& peer_submap = submap_of(from, received.submap);
  if (peer_submap.look) return true;
  peer_submap.look = std::move(look);
  peer_submap.num_points = received.num_points;
  peer_submap.has_chunk.assign(received.num_chunks, 0);
  for (const OwnSubmap& own : own_)
    peer_submap.similarity = std::max(peer_submap.similarity, likeness(own.look, *peer_submap.look));
  return true;
}

bool MapSharing::receive_request(Peer& from, const Message& message) {
  SubmapRequest requested;
  if (read_message(message, requested) != Reading::kDone || requested.submap >= own_.size()) return false;
  if (requested.content == SubmapRequest::Content::kDescriptors) {
    if (requested.missing.size() > (kMostSubmaps + 7) / 8) return false;
    for (std::size_t i = 0; i < 8 * requested.missing.size() && requested.submap + i < own_.size(); ++i) {
      if (bit_at(requested.missing, i)) own_[requested.submap + i].is_due = true;
    }
    return true;
  }
  const std::size_t num_chunks = own_[requested.submap].chunks.size();
  if (num_chunks == 0 || requested.missing.size() != (num_chunks + 7) / 8) return false;
  from.requested_submap = static_cast<int>(requested.submap);
  from.requested_chunks.assign(num_chunks, 0);
  for (std::size_t i = 0; i < num_chunks; ++i) from.requested_chunks[i] = bit_at(requested.missing, i) ? 1 : 0;
  return true;
}

bool MapSharing::receive_chunk(TimeNs t, Peer& from, const Message& message) {
  SubmapChunk received;
  if (read_message(message, received) != Reading::kDone || received.submap >= from.submaps.size()) return false;
  PeerSubmap& peer_submap = from.submaps[received.submap];
  if (peer_submap.complete) return true;  // a repeated chunk
  if (static_cast<int>(received.submap) != from.fetching || received.chunk >= peer_submap.has_chunk.size())
    return false;
  if (!(received.voxel_m >= 0.01F && received.voxel_m <= 10.0F)) return false;
  if (peer_submap.has_chunk[received.chunk] != 0) return true;
  if (peer_submap.points_submap_m.size() + received.num_points > peer_submap.num_points) return false;
  if (!unpack_points(received.data, received.num_points, static_cast<double>(received.voxel_m), received.bits,
                     peer_submap.points_submap_m)) {
    return false;
  }
  peer_submap.has_chunk[received.chunk] = 1;
  from.requested = t;  // the transfer continues
  peer_submap.complete = std::all_of(peer_submap.has_chunk.begin(), peer_submap.has_chunk.end(),
                                     [](std::uint8_t has) { return has != 0; });
  if (peer_submap.complete) from.fetching = -1;
  if (received.chunk >= from.last_requested)
    from.is_requested = false;  // chunks arrive in order: chunks missing now were lost
  return true;
}

bool MapSharing::receive_closures(Peer& from, const Message& message) {
  if (searches_in(message.from)) return false;  // the own vehicle is the one that seeks closures
  MapClosures received;
  if (read_message(message, received) != Reading::kDone || received.closures.size() > kMostClosures) return false;
  std::vector<MapClosure> closures;
  for (const MapClosures::Closure& c : received.closures) {
    const std::optional<Pose> T = received_pose(c.p_own_m, c.turn_own_rad, kFarthestInSubmap_m);
    if (!T || c.own >= kMostSubmaps || c.other >= own_.size()) return false;
    closures.push_back({static_cast<int>(c.other), static_cast<int>(c.own), T->inverse()});
  }
  const auto same = [](const MapClosure& a, const MapClosure& b) {
    return a.own == b.own && a.other == b.other && is_same(a.T_own_other, b.T_own_other);
  };
  if (std::equal(closures.begin(), closures.end(), from.closures.begin(), from.closures.end(), same)) return true;
  from.closures = std::move(closures);
  from.has_new_closures = true;
  return true;
}

// Use of received data.

bool MapSharing::is_about(TimeNs t, const Peer& other) const {
  return other.has_reported && to_seconds(t - other.last_report) <= 3.0 * config_.report_interval_s;
}

bool MapSharing::is_enough(const Peer& other) const {
  return other.closures.size() >= kMostClosures || static_cast<int>(other.agreeing.size()) >= config_.closures_enough;
}

/// Predicted pose of another vehicle's submap in the own local frame, by the present closures.
std::optional<Pose> MapSharing::prediction_of(const Peer& from, int submap) const {
  const auto number = static_cast<std::size_t>(submap);
  if (number >= from.places.size() || !from.places[number].known) return std::nullopt;
  if (number < from.T_local_other.size()) return from.T_local_other[number];
  for (const MapClosure& c : from.closures) {
    const auto other = static_cast<std::size_t>(c.other);
    if (other >= from.places.size() || !from.places[other].known) continue;
    return own_places_[static_cast<std::size_t>(c.own)].T_local_submap * c.T_own_other *
           from.places[other].T_local_submap.inverse() * from.places[number].T_local_submap;
  }
  return std::nullopt;
}

bool MapSharing::is_near_own(const Vector3& p_local_m) const {
  for (std::size_t i = 0; i < own_.size(); ++i) {
    if ((own_places_[i].T_local_submap.translation() - p_local_m).norm() <= config_.near_m) return true;
  }
  return false;
}

/// Requests the submap most similar to an own one. Submaps predicted near own ones by a closure come first; once
/// closures agree, only those are requested.
void MapSharing::choose_cloud(TimeNs t, Peer& from) {
  if (from.fetching >= 0 || own_.empty() || is_enough(from) || !is_about(t, from)) return;
  std::size_t waiting = 0;
  double best = 0.0;
  int chosen = -1;
  for (std::size_t i = 0; i < from.submaps.size(); ++i) {
    const PeerSubmap& peer_submap = from.submaps[i];
    waiting += peer_submap.complete && peer_submap.num_searched == 0;
    if (!peer_submap.look || peer_submap.complete || peer_submap.has_chunk.empty() ||
        peer_submap.similarity < config_.likeness_min)
      continue;
    const std::optional<Pose> T = prediction_of(from, static_cast<int>(i));
    const bool near = T && is_near_own(T->translation());
    if (!from.agreeing.empty() && !near) continue;
    const double value = peer_submap.similarity + (near ? 1.0 : 0.0);
    if (value <= best) continue;
    best = value;
    chosen = static_cast<int>(i);
  }
  if (chosen < 0 || waiting >= kMostWaiting) return;
  from.fetching = chosen;
  from.is_requested = false;
}

/// Searches one cloud of one vehicle in all own submaps similar to it.
void MapSharing::search(TimeNs t, const SubmapProvider& own) {
  if (!worker_.idle()) return;
  PeerSubmap* chosen = nullptr;
  std::size_t of = 0, number = 0;
  for (std::size_t p = 0; p < peers_.size(); ++p) {
    if (!searches_in(static_cast<VehicleId>(p)) || is_enough(peers_[p])) continue;
    for (std::size_t i = 0; i < peers_[p].submaps.size(); ++i) {
      PeerSubmap& peer_submap = peers_[p].submaps[i];
      if (!peer_submap.complete || peer_submap.closed || peer_submap.num_searched >= static_cast<int>(own_.size()))
        continue;
      if (chosen != nullptr && peer_submap.similarity <= chosen->similarity) continue;
      chosen = &peer_submap;
      of = p;
      number = i;
    }
  }
  if (chosen == nullptr) return;
  struct Alike {
    double likeness = 0.0;
    std::size_t submap = 0;
  };
  std::vector<Alike> similarity;
  bool fresh = false;
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const double how = likeness(own_[i].look, *chosen->look);
    if (how < config_.likeness_min) continue;
    similarity.push_back({how, i});
    fresh = fresh || static_cast<int>(i) >= chosen->num_searched;
  }
  chosen->num_searched = static_cast<int>(own_.size());
  if (!fresh) return;
  std::stable_sort(similarity.begin(), similarity.end(),
                   [](const Alike& a, const Alike& b) { return a.likeness > b.likeness; });
  similarity.resize(std::min(similarity.size(), static_cast<std::size_t>(config_.search_submaps)));
  std::vector<MapPart> parts;
  for (const Alike& a : similarity) {
    const auto submap = static_cast<int>(a.submap);
    parts.push_back(
        {level_pose(own.T_local_submap(submap)), own.points_submap_m(submap), &own_[a.submap].look.directions});
  }
  const MapMatch match = find_in_map(parts, chosen->points_submap_m, config_.search, &chosen->look->directions);
  ++num_searches_;
  found_.other = static_cast<VehicleId>(of);
  found_.closure.reset();
  if (match.result.verdict == ClosureVerdict::kClosed) {
    found_.closure = MapClosure{static_cast<int>(similarity[match.part].submap), static_cast<int>(number),
                                match.result.T_older_newer};
  }
  worker_.start(t);
}

void MapSharing::settle_search(TimeNs t) {
  if (!worker_.due(t)) return;
  worker_.stop();
  if (!found_.closure) return;
  Peer& other = peers_[static_cast<std::size_t>(found_.other)];
  other.submaps[static_cast<std::size_t>(found_.closure->other)].closed = true;
  other.closures.push_back(*found_.closure);
  other.closures_due = other.has_new_closures = true;
  found_.closure.reset();
}

void MapSharing::join(TimeNs t) {
  for (std::size_t i = 0; i < peers_.size(); ++i) {
    Peer& other = peers_[i];
    const auto id = static_cast<VehicleId>(i);
    if (!other.has_new_closures || other.closures.empty() || to_seconds(t - other.tested) < kLeastBetween_s) continue;
    other.has_new_closures = false;
    other.tested = t;
    other.agreeing = agreeing_closures(other.closures, own_places_, other.places, config_.join);
    const auto place = std::find_if(joined_.begin(), joined_.end(), [id](const JoinedMap& j) { return j.other >= id; });
    const bool was_joined = place != joined_.end() && place->other == id;
    if (other.agreeing.empty()) {
      if (was_joined) joined_.erase(place);
      other.T_local_other.clear();
      continue;
    }
    MapJoin found = join_maps(other.closures, other.agreeing, own_places_, other.places, config_.join);
    JoinedMap& joined = was_joined ? *place : *joined_.insert(place, JoinedMap{.other = id, .joined = t});
    joined.T_local_otherlocal = found.T_local_otherlocal;
    joined.covariance = found.covariance;
    joined.num_closures = static_cast<int>(other.agreeing.size());
    other.T_local_other = std::move(found.T_local_other);
  }
}

// Sent messages.

/// Sends within the budget and a short burst, in order of priority; the rest waits.
void MapSharing::send(TimeNs t, Outbox& outbox) {
  const double rate_bytes_s = 1e3 / 8.0 * config_.budget_kbps;
  const double largest_bytes = std::max(kLargestMessage_bytes, config_.cloud.chunk_bytes + kChunkHead_bytes);
  if (started_) allowance_bytes_ += rate_bytes_s * to_seconds(t - last_step_);
  allowance_bytes_ = std::min(allowance_bytes_, largest_bytes + kBurst_s * rate_bytes_s);
  started_ = true;
  last_step_ = t;
  for (int i = 0; i < kMostSent && allowance_bytes_ >= largest_bytes; ++i) {
    if (!send_next(t, outbox)) return;
    allowance_bytes_ -= static_cast<double>(outbox.messages().back().size_bytes());
  }
}

bool MapSharing::send_next(TimeNs t, Outbox& outbox) {
  const auto num = static_cast<VehicleId>(peers_.size());
  for (VehicleId i = 0; i < num; ++i) {
    if (i != self_ && (send_request(t, i, outbox) || send_closures(t, i, outbox))) return true;
  }
  if (send_places(t, outbox) || send_descriptor(outbox)) return true;
  for (VehicleId i = 0; i < num; ++i) {  // round robin over vehicles
    const VehicleId to = (next_served_ + i) % num;
    if (!send_chunk(to, outbox)) continue;
    next_served_ = (to + 1) % num;
    return true;
  }
  return false;
}

bool MapSharing::send_request(TimeNs t, VehicleId to, Outbox& outbox) {
  Peer& other = peers_[static_cast<std::size_t>(to)];
  if (!searches_in(to) || !is_about(t, other)) return false;
  SubmapRequest request;
  if (other.fetching >= 0 && (!other.is_requested || to_seconds(t - other.requested) >= config_.retry_after_s)) {
    std::vector<std::uint8_t> missing = other.submaps[static_cast<std::size_t>(other.fetching)].has_chunk;
    for (std::uint8_t& flag : missing) flag = flag == 0 ? 1 : 0;
    request.submap = static_cast<std::uint32_t>(other.fetching);
    request.missing = bits_of(missing);
    for (std::size_t i = 0; i < missing.size(); ++i) other.last_requested = missing[i] != 0 ? i : other.last_requested;
    other.is_requested = true;
    other.requested = t;
    write_message(request, outbox.add(to));
    return true;
  }
  if (to_seconds(t - other.descriptors_requested) < config_.retry_after_s) return false;
  std::vector<std::uint8_t> missing;
  for (std::uint32_t i = 0; i < other.num_finished; ++i) {
    const bool is_missing = i >= other.submaps.size() || !other.submaps[i].look;
    if (!is_missing && missing.empty()) continue;
    if (missing.empty()) request.submap = i;
    missing.push_back(is_missing ? 1 : 0);
  }
  other.descriptors_requested = t;
  if (missing.empty()) return false;
  request.content = SubmapRequest::Content::kDescriptors;
  request.missing = bits_of(missing);
  write_message(request, outbox.add(to));
  return true;
}

bool MapSharing::send_closures(TimeNs t, VehicleId to, Outbox& outbox) {
  Peer& other = peers_[static_cast<std::size_t>(to)];
  if (!searches_in(to) || other.closures.empty() || !is_about(t, other)) return false;
  if (!other.closures_due && to_seconds(t - other.closures_sent) < config_.report_interval_s) return false;
  other.closures_due = false;
  other.closures_sent = t;
  MapClosures sent;
  for (const MapClosure& c : other.closures) {
    sent.closures.push_back({static_cast<std::uint32_t>(c.own), static_cast<std::uint32_t>(c.other),
                             c.T_own_other.translation().cast<float>(), turn_of(c.T_own_other)});
  }
  write_message(sent, outbox.add(to));
  return true;
}

bool MapSharing::send_places(TimeNs t, Outbox& outbox) {
  const double since_s = to_seconds(t - places_sent_);
  if (own_places_.empty() || since_s < (places_due_ ? kLeastBetween_s : config_.report_interval_s)) return false;
  SubmapPlaces sent;
  sent.num_finished = static_cast<std::uint32_t>(own_.size());
  if (next_place_ >= own_places_.size()) next_place_ = 0;
  sent.first = static_cast<std::uint32_t>(next_place_);
  for (; next_place_ < own_places_.size() && sent.places.size() < kMostPlaces; ++next_place_) {
    const SubmapPlace& place = own_places_[next_place_];
    sent.places.push_back({place.T_local_submap.translation().cast<float>(), turn_of(place.T_local_submap),
                           static_cast<float>(place.path_length_m)});
  }
  if (next_place_ >= own_places_.size()) places_due_ = false;
  places_sent_ = t;
  write_message(sent, outbox.add());
  return true;
}

bool MapSharing::send_descriptor(Outbox& outbox) {
  const auto next = std::find_if(own_.begin(), own_.end(), [](const OwnSubmap& own) { return own.is_due; });
  if (next == own_.end()) return false;
  next->is_due = false;
  SubmapDescriptor sent;
  sent.submap = static_cast<std::uint32_t>(next - own_.begin());
  sent.num_points = next->num_points;
  sent.num_chunks = static_cast<std::uint16_t>(next->chunks.size());
  sent.directions = next->look.directions.quantized();
  sent.heights.assign(next->look.heights.begin(), next->look.heights.end());
  write_message(sent, outbox.add());
  return true;
}

bool MapSharing::send_chunk(VehicleId to, Outbox& outbox) {
  Peer& other = peers_[static_cast<std::size_t>(to)];
  if (other.requested_submap < 0) return false;
  const auto next = std::find(other.requested_chunks.begin(), other.requested_chunks.end(), 1);
  if (next == other.requested_chunks.end()) {
    other.requested_submap = -1;
    return false;
  }
  *next = 0;
  const auto number = static_cast<std::size_t>(next - other.requested_chunks.begin());
  const PackedPoints& chunk = own_[static_cast<std::size_t>(other.requested_submap)].chunks[number];
  SubmapChunk sent;
  sent.submap = static_cast<std::uint32_t>(other.requested_submap);
  sent.chunk = static_cast<std::uint16_t>(number);
  sent.num_points = chunk.num_points;
  sent.bits = static_cast<std::uint16_t>(config_.cloud.bits);
  sent.voxel_m = static_cast<float>(config_.cloud.voxel_m);
  sent.data = chunk.data;
  write_message(sent, outbox.add(to));
  return true;
}

void MapSharing::append_overlays(const SubmapProvider& own, std::vector<Overlay>& overlays) const {
  Overlay joined;
  joined.name = "slam.joined";
  joined.kind = Overlay::Kind::kLines;
  joined.size_m = 3.0F;
  const Eigen::Vector4f path_color(0.25F, 0.75F, 0.35F, 1.0F), closure(0.95F, 0.45F, 0.10F, 1.0F);
  joined.legend = {{"submaps of another vehicle", path_color}, {"closures with it", closure}};
  const auto add = [&](const Vector3& a_m, const Vector3& b_m, const Eigen::Vector4f& color) {
    for (const Vector3& p_m : {a_m, b_m}) {
      joined.positions.push_back(p_m.cast<float>());
      joined.colors.push_back(color);
    }
  };
  for (const Peer& other : peers_) {
    const std::vector<Pose>& T = other.T_local_other;
    for (std::size_t i = 0; i + 1 < T.size(); ++i) {
      if (other.places[i].known && other.places[i + 1].known)
        add(T[i].translation(), T[i + 1].translation(), path_color);
    }
    for (const int i : other.agreeing) {
      const MapClosure& c = other.closures[static_cast<std::size_t>(i)];
      add(own.T_local_submap(c.own).translation(), T[static_cast<std::size_t>(c.other)].translation(), closure);
    }
  }
  overlays.push_back(std::move(joined));
}

void MapSharing::append_counters(std::vector<Counter>& counters) const {
  counters.push_back({"rejected messages about maps", num_refused_, num_received_, "global.share.enabled"});
}

void CompactCloudConfig::visit(ConfigVisitor& v) {
  v.field("range_max_m", range_max_m, "[m] points farther from the submap's center are left out",
          Range::between(2.0, 200.0));
  v.field("bits", bits, "[-] bits of each coordinate within its voxel", Range::between(1, 10));
}

void MapSharingConfig::visit(ConfigVisitor& v) {
  const Range positive = Range::positive();
  v.field("enabled", enabled, "[-] is the map joined with those of other vehicles by radio?");
  v.field("latency_s", latency_s, "[s] duration of a search for one submap", Range::between(0.0, 60.0));
  v.field("budget_kbps", budget_kbps, "[kbit/s] data rate of all messages about maps, headers included", positive);
  v.field(
      "near_m", near_m,
      "[m] largest distance to an own submap at which another vehicle's cloud is requested once the maps are joined",
      positive);
  v.object("cloud", cloud, "part of a submap that is transmitted");
  v.object("search", search, "search for another vehicle's submap in the own ones, around each one's center");
  v.object("join", join, "tests of closures and estimation of the transform between the maps");
}

}  // namespace swiftlet
