// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/map_sharing.hpp"

#include <algorithm>
#include <utility>

#include "core/slam/level_pose.hpp"
#include "core/slam/sharing/map_receiver.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

// [m] Largest distance to an own submap at which another vehicle's cloud is requested once closures agree. Larger
// values find more closures and take more of the data rate.
constexpr double kRequestNear_m = 12.0;
constexpr std::size_t kMaxWaiting = 2;  // received clouds not yet searched, beyond which no more are requested

}  // namespace

MapSharing::MapSharing(const MapSharingConfig& config, const ClosureConfig& closures, VehicleId self, int num_vehicles)
    : config_(config),
      closures_(closures),
      self_(self),
      peers_(static_cast<std::size_t>(num_vehicles)),
      worker_(config.latency_s),
      sender_(config, self) {
  ENSURE(self >= 0 && self < num_vehicles, self, num_vehicles);
  for (std::size_t i = static_cast<std::size_t>(self) + 1; i < peers_.size(); ++i) peers_[i].is_searched_here = true;
}

void MapSharing::step(TimeNs t, const SubmapProvider& own, std::span<const Message> messages, Outbox& outbox) {
  describe_own(own);
  update_places(own);
  for (const Message& message : messages) {
    if (!is_map_topic(message.topic)) continue;
    ++num_received_;
    const bool is_peer =
        message.from >= 0 && static_cast<std::size_t>(message.from) < peers_.size() && message.from != self_;
    if (!is_peer || !receive_map_message(t, message, own_, peers_[static_cast<std::size_t>(message.from)]))
      ++num_refused_;
  }
  take_result(t);
  search(t, own);
  join(t);
  for (PeerMap& peer : peers_) {
    if (peer.is_searched_here) choose_cloud(t, peer);
  }
  sender_.step(t, own_, peers_, outbox);
}

void MapSharing::describe_own(const SubmapProvider& own) {
  while (static_cast<int>(own_.submaps.size()) + 1 < own.num_submaps()) {
    const std::span<const Eigen::Vector3f> points_m = own.points_submap_m(static_cast<int>(own_.submaps.size()));
    const CompactCloudConfig& cloud = config_.cloud;
    OwnSubmap& finished = own_.submaps.emplace_back();
    finished.look = look_of(points_m, cloud.voxel_m, closures_.range_max_m);
    finished.chunks = pack_points(points_to_share_m(points_m, cloud, closures_.range_max_m), cloud.voxel_m,
                                  CompactCloudConfig::kBits, cloud.chunk_bytes);
    if (finished.chunks.size() > MapMessageLimits::kChunks) finished.chunks.resize(MapMessageLimits::kChunks);
    for (const PackedPoints& chunk : finished.chunks) finished.num_points += chunk.num_points;
    for (PeerMap& other : peers_) {
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
  own_.places.resize(static_cast<std::size_t>(own.num_submaps()));
  for (int i = 0; i < own.num_submaps(); ++i) {
    own_.places[static_cast<std::size_t>(i)] = {true, own.T_local_submap(i), own.path_length_m(i)};
  }
  own_.places_due = true;
  for (PeerMap& other : peers_) other.needs_consistency_test = true;
}

bool MapSharing::is_enough(const PeerMap& other) const {
  return other.closures.size() >= MapMessageLimits::kListed ||
         static_cast<int>(other.agreeing.size()) >= config_.closures_enough;
}

/// Predicted pose of another vehicle's submap in the own local frame, by the present closures.
std::optional<Pose> MapSharing::prediction_of(const PeerMap& from, int submap) const {
  const auto number = static_cast<std::size_t>(submap);
  if (number >= from.places.size() || !from.places[number].known) return std::nullopt;
  if (number < from.T_local_other.size()) return from.T_local_other[number];
  for (const MapClosure& c : from.closures) {
    const auto other = static_cast<std::size_t>(c.other);
    if (other >= from.places.size() || !from.places[other].known) continue;
    return own_.places[static_cast<std::size_t>(c.own)].T_local_submap * c.T_own_other *
           from.places[other].T_local_submap.inverse() * from.places[number].T_local_submap;
  }
  return std::nullopt;
}

bool MapSharing::is_near_own(const Vector3& p_local_m) const {
  for (std::size_t i = 0; i < own_.submaps.size(); ++i) {
    if ((own_.places[i].T_local_submap.translation() - p_local_m).norm() <= kRequestNear_m) return true;
  }
  return false;
}

/// Requests the submap most similar to an own one. Submaps that a closure predicts near own submaps come first;
/// once closures agree, no other submaps are requested.
void MapSharing::choose_cloud(TimeNs t, PeerMap& from) {
  if (from.fetching >= 0 || own_.submaps.empty() || is_enough(from) ||
      !from.is_in_contact(t, kSilentReports * config_.report_interval_s))
    return;
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
  if (chosen < 0 || waiting >= kMaxWaiting) return;
  from.fetching = chosen;
  from.is_requested = false;
}

/// The received cloud that is most similar to an own submap and was not yet searched in all own submaps.
std::optional<MapSharing::Search> MapSharing::next_search() const {
  std::optional<Search> next;
  double best = 0.0;
  for (std::size_t p = 0; p < peers_.size(); ++p) {
    if (!peers_[p].is_searched_here || is_enough(peers_[p])) continue;
    for (std::size_t i = 0; i < peers_[p].submaps.size(); ++i) {
      const PeerSubmap& submap = peers_[p].submaps[i];
      const bool is_searched = submap.num_searched >= static_cast<int>(own_.submaps.size());
      if (!submap.complete || submap.closed || is_searched || (next && submap.similarity <= best)) continue;
      next = {static_cast<VehicleId>(p), static_cast<int>(i)};
      best = submap.similarity;
    }
  }
  return next;
}

/// Own submaps similar to another vehicle's, the most similar first. Empty when all were searched before.
std::vector<int> MapSharing::similar_submaps(const PeerSubmap& sought) const {
  struct Alike {
    double likeness = 0.0;
    int submap = 0;
  };
  std::vector<Alike> alike;
  bool fresh = false;
  for (std::size_t i = 0; i < own_.submaps.size(); ++i) {
    const double how = likeness(own_.submaps[i].look, *sought.look);
    if (how < config_.likeness_min) continue;
    alike.push_back({how, static_cast<int>(i)});
    fresh = fresh || static_cast<int>(i) >= sought.num_searched;
  }
  std::vector<int> submaps;
  if (!fresh) return submaps;
  std::stable_sort(alike.begin(), alike.end(), [](const Alike& a, const Alike& b) { return a.likeness > b.likeness; });
  alike.resize(std::min(alike.size(), static_cast<std::size_t>(config_.search_submaps)));
  for (const Alike& a : alike) submaps.push_back(a.submap);
  return submaps;
}

/// Searches one cloud of one vehicle in the own submaps similar to it.
void MapSharing::search(TimeNs t, const SubmapProvider& own) {
  if (!worker_.idle()) return;
  const std::optional<Search> next = next_search();
  if (!next) return;
  PeerSubmap& sought = peers_[static_cast<std::size_t>(next->other)].submaps[static_cast<std::size_t>(next->submap)];
  const std::vector<int> similar = similar_submaps(sought);
  sought.num_searched = static_cast<int>(own_.submaps.size());
  if (similar.empty()) return;
  std::vector<ClosureCandidate> candidates;
  for (const int submap : similar) {
    candidates.push_back({level_pose(own.T_local_submap(submap)), own.points_submap_m(submap),
                          &own_.submaps[static_cast<std::size_t>(submap)].look.directions});
  }
  const ClosureResult result = find_closure(candidates, sought.points_submap_m, closures_, &sought.look->directions);
  counts_.count(result.verdict);
  ++num_searches_;
  found_ = {next->other, std::nullopt};
  if (result.closed()) found_.closure = MapClosure{similar[result.candidate], next->submap, result.T_older_newer};
  worker_.start(t);
}

void MapSharing::take_result(TimeNs t) {
  if (!worker_.due(t)) return;
  worker_.stop();
  if (!found_.closure) return;
  PeerMap& other = peers_[static_cast<std::size_t>(found_.other)];
  other.submaps[static_cast<std::size_t>(found_.closure->other)].closed = true;
  other.closures.push_back(*found_.closure);
  other.closures_due = other.needs_consistency_test = true;
  found_.closure.reset();
}

void MapSharing::join(TimeNs t) {
  for (std::size_t i = 0; i < peers_.size(); ++i) {
    PeerMap& other = peers_[i];
    const auto id = static_cast<VehicleId>(i);
    if (!other.needs_consistency_test || other.closures.empty() || to_seconds(t - other.tested) < kMinUpdateInterval_s)
      continue;
    other.needs_consistency_test = false;
    other.tested = t;
    other.agreeing = agreeing_closures(other.closures, own_.places, other.places, config_.join);
    const auto place = std::find_if(joined_.begin(), joined_.end(), [id](const JoinedMap& j) { return j.other >= id; });
    const bool was_joined = place != joined_.end() && place->other == id;
    if (other.agreeing.empty()) {
      if (was_joined) joined_.erase(place);
      other.T_local_other.clear();
      continue;
    }
    MapJoin found = join_maps(other.closures, other.agreeing, own_.places, other.places, config_.join);
    JoinedMap& joined = was_joined ? *place : *joined_.insert(place, JoinedMap{.other = id, .joined = t});
    joined.T_local_otherlocal = found.T_local_otherlocal;
    joined.covariance = found.covariance;
    joined.num_closures = static_cast<int>(other.agreeing.size());
    other.T_local_other = std::move(found.T_local_other);
  }
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
  for (const PeerMap& other : peers_) {
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
  counts_.append_counters("searches for another vehicle's submap", counters);
}

void MapSharingConfig::visit(ConfigVisitor& v) {
  v.field("enabled", enabled, "[-] whether the map is joined with those of other vehicles by radio");
  v.field("latency_s", latency_s, "[s] duration of a search for one submap", Range::between(0.0, 60.0));
  v.field("budget_kbps", budget_kbps, "[kbit/s] data rate of all messages about maps, headers included",
          Range::positive());
  v.object("join", join, "tests of closures and estimation of the transform between the maps");
}

}  // namespace swiftlet
