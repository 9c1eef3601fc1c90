// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/global_slam.hpp"

#include <algorithm>
#include <utility>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/frame_change.hpp"

namespace swiftlet {

GlobalSlam::GlobalSlam(const GlobalSlamConfig& config, bool pose_known)
    : config_(config),
      latency_(config.latency_s),
      trajectory_(config, pose_known),
      closer_(config, pose_known),
      gnss_(config, !pose_known && trajectory_.num_given_poses() == 0) {
  if (config.loaded_map != nullptr) submap_poses_.num_given = config.loaded_map->submaps.size();
}

void GlobalSlam::add_scan(TimeNs t, const Pose& T_local_body, std::span<const Eigen::Vector3f> points_body_m,
                          const Pose& T_world_local) {
  if (trajectory_.nodes().empty()) {
    last_optimized_ = t;
  } else {
    const TrajectoryNode& last = trajectory_.nodes().back();
    const double step_m = (T_local_body.translation() - last.T_local_body.translation()).norm();
    if (t <= last.t) return;
    if (step_m < config_.node_every_m && !closer_.is_search_due(t, last.path_length_m + step_m, trajectory_)) return;
  }
  trajectory_.add_node(t, T_local_body, T_world_local);
  has_new_fixes_ = gnss_.place(trajectory_) || has_new_fixes_;
  const double path_length_m = trajectory_.nodes().back().path_length_m;
  const auto& submaps = trajectory_.submaps();
  if (submaps.empty() || path_length_m - submaps.back().begin_m > config_.submap_m) begin_next_submap();
  trajectory_.insert(T_local_body, points_body_m);
  gnss_.fit_start(trajectory_);
  closer_.relocalize(t, trajectory_);
  const bool placed = closer_.located() || trajectory_.num_given_poses() == 0;
  const bool due = placed && to_seconds(t - last_optimized_) >= config_.optimize_every_s;
  if (trajectory_.num_closures() > num_optimized_closures_ || (has_new_fixes_ && due)) optimize(t);
}

/// Finishes the newest submap: it is thinned to one point per voxel and compared with older submaps. Then the next
/// begins.
void GlobalSlam::begin_next_submap() {
  double hidden_m = 0.0;
  if (!trajectory_.submaps().empty()) {
    trajectory_.thin_newest();
    const std::vector<OlderSubmap> closed_with = closer_.close_loops(trajectory_);
    if (const auto heir = heir_of_newest(closed_with, config_, trajectory_)) {
      closer_.forget_refused(trajectory_.submaps().back().first_pose);
      record_dropped(*heir);
      trajectory_.drop_newest(closed_with);
      record_begun();
      return;
    }
    forget_covered_points(closed_with, config_, trajectory_);
    const FlightSubmap& finished = trajectory_.submaps().back();
    if (finished.closed != FlightSubmap::Closed::kFully) hidden_m = finished.hidden_m;
  }
  trajectory_.begin_submap(hidden_m);
  record_begun();
}

void GlobalSlam::record_begun() {
  submap_poses_.T_local_own.push_back(trajectory_.submaps().back().T_local_submap);
  ++submap_poses_.revision;
  const bool knows_given = submap_poses_.num_given > 0 && closer_.located();
  if (!knows_given || !submap_poses_.T_local_given.empty() || num_submaps() > 1) return;
  submap_poses_.T_local_given = trajectory_.given_poses_local();
  submap_poses_.given = pieces_of(*config_.loaded_map);
}

/// Moves cells that a mapper attached to the newest submap to an older one.
void GlobalSlam::record_dropped(const SubmapHeir& heir) {
  const int number = num_submaps() - 1;
  submap_poses_.dropped = {submap_poses_.dropped.count + 1, number, heir.submap, heir.T_heir_newest};
  submap_poses_.T_local_own.pop_back();
  for (Learned& learned : learned_) {
    if (static_cast<int>(learned.T_local_own.size()) > number) learned.T_local_own.pop_back();
  }
}

std::shared_ptr<const SavedMap> GlobalSlam::saved_map() const {
  if (trajectory_.num_given_poses() > 0 && !closer_.located()) return config_.loaded_map;
  auto map = std::make_shared<SavedMap>();
  if (config_.loaded_map != nullptr) {
    map->nodes = config_.loaded_map->nodes;
    map->submaps = config_.loaded_map->submaps;
    map->pieces = config_.loaded_map->pieces;
  }
  const std::vector<FlightSubmap>& submaps = trajectory_.submaps();
  map->voxel_m = config_.submap_voxel_m;
  map->graph = trajectory_.graph();
  map->nodes.reserve(map->nodes.size() + trajectory_.nodes().size());
  for (const TrajectoryNode& node : trajectory_.nodes()) map->nodes.push_back({node.t, node.pose});
  map->submaps.reserve(map->submaps.size() + submaps.size());
  for (const FlightSubmap& submap : submaps) map->submaps.push_back({submap.pose, submap.points_submap_m});
  if (!submaps.empty()) map->submaps.back().points_submap_m = trajectory_.thinned_m(submaps.back().points_submap_m);
  return map;
}

void GlobalSlam::optimize(TimeNs t) {
  trajectory_.optimize();
  num_optimized_closures_ = trajectory_.num_closures();
  has_new_fixes_ = false;
  last_optimized_ = t;
  const PoseGraph& graph = trajectory_.graph();
  const TrajectoryNode& last = trajectory_.nodes().back();
  // Both frames have z up: only local SLAM determines the tilt of the local frame.
  const Pose T_world_local = graph.pose(last.pose) * last.T_local_body.inverse();
  Learned learned;
  learned.begun = t;
  learned.T_world_local = level_alignment(yaw_of(T_world_local.linear()), graph.pose(last.pose).translation(),
                                          last.T_local_body.translation());
  const Pose T_local_from_world = trajectory_.T_local_world();
  for (const FlightSubmap& submap : trajectory_.submaps()) {
    learned.T_local_own.push_back(T_local_from_world * graph.pose(submap.pose));
  }
  learned.T_local_own.back() = trajectory_.submaps().back().T_local_submap;
  if (closer_.located()) learned.T_local_given = trajectory_.given_poses_local();
  learned_.push_back(std::move(learned));
}

std::optional<Pose> GlobalSlam::correction(TimeNs t) {
  std::optional<Pose> newest;
  while (!learned_.empty() && latency_.is_over(learned_.front().begun, t)) {
    Learned& learned = learned_.front();
    newest = learned.T_world_local;
    // Submaps begun since then keep their start pose.
    std::copy(learned.T_local_own.begin(), learned.T_local_own.end(), submap_poses_.T_local_own.begin());
    if (!learned.T_local_given.empty()) {
      if (submap_poses_.given.empty()) submap_poses_.given = pieces_of(*config_.loaded_map);
      submap_poses_.T_local_given = std::move(learned.T_local_given);
    }
    ++submap_poses_.revision;
    learned_.erase(learned_.begin());
  }
  return newest;
}

void GlobalSlam::append_overlays(std::vector<Overlay>& overlays) const {
  if (trajectory_.submaps().empty()) return;
  const PoseGraph& graph = trajectory_.graph();
  const Pose T_local_from_world = trajectory_.T_local_world();
  const auto make = [](const char* name, Overlay::Kind kind, float size_m, const Eigen::Vector4f& color,
                       const char* meaning) {
    return Overlay{name, kind, {}, {color}, size_m, {{meaning, color}}};
  };
  Overlay trajectory = make("slam.trajectory", Overlay::Kind::kPolyline, 3.0F, {0.10F, 0.55F, 0.85F, 1.0F},
                            "trajectory by the pose graph");
  Overlay starts =
      make("slam.submaps", Overlay::Kind::kSpheres, 0.3F, {0.95F, 0.80F, 0.15F, 1.0F}, "starts of submaps");
  Overlay closures =
      make("slam.closures", Overlay::Kind::kLines, 4.0F, {0.85F, 0.15F, 0.55F, 1.0F}, "closures between submaps");
  Overlay refused = make("slam.refused", Overlay::Kind::kLines, 2.0F, {0.55F, 0.55F, 0.55F, 1.0F}, "refused closures");
  const auto add = [&](int pose, Overlay& overlay) {
    overlay.positions.emplace_back((T_local_from_world * graph.pose(pose).translation()).cast<float>());
  };
  for (const TrajectoryNode& node : trajectory_.nodes()) add(node.pose, trajectory);
  for (const FlightSubmap& submap : trajectory_.submaps()) add(submap.pose, starts);
  for (const RelativeFactor& factor : graph.relative_factors()) {
    if (factor.huber == kNoHuber) continue;
    add(factor.from, closures);
    add(factor.to, closures);
  }
  for (const auto& [older, newer] : closer_.refused()) {
    add(older, refused);
    add(newer, refused);
  }
  for (Overlay* overlay : {&trajectory, &starts, &closures, &refused}) overlays.push_back(std::move(*overlay));
}

std::size_t GlobalSlam::num_points() const {
  std::size_t num = 0;
  for (int i = 0; i + 1 < num_submaps(); ++i) num += points_submap_m(i).size();
  return num;
}

void GlobalSlamConfig::visit(ConfigVisitor& v) {
  v.field("enabled", enabled, "[-] whether closures and GNSS fixes correct the pose of the local frame in the world");
  v.field("latency_s", latency_s, "[s] time from a scan to its correction, for search and optimization",
          Range::between(0.0, 60.0));
  v.field("covered_share", covered_share,
          "[-] share of a submap's points in older submaps joined with it above which those points are dropped; 1: "
          "none are",
          Range::probability());
  v.field("visits_kept", visits_kept,
          "[-] largest number of submaps that begin within 4 m of each other; a further one is dropped if those "
          "contain covered_share of its points; larger values take more memory",
          Range::between(1, 1000));
  v.field("searches", searches, "[-] largest number of searches for a finished submap", Range::between(0, 100));
  v.field("use_gnss", use_gnss, "[-] whether GNSS fixes constrain the trajectory");
  v.field("optimize_every_s", optimize_every_s,
          "[s] interval of optimizations for new fixes; a closure is optimized at once", Range::positive());
  v.file("map", map,
         "map of an earlier flight, as written by the recorder `slam_map`, in which the vehicle localizes itself");
  v.object("gnss", gnss, "weight of a fix");
  v.object("closures", closures,
           "search for closures and their verification, also in a saved map and between vehicles");
  v.object("blend", blend, "transition to a new correction");
  v.object("share", share, "joining the map with those of other vehicles");
}

}  // namespace swiftlet
