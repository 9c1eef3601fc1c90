// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/global_slam.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/slam/graph/graph_ways.hpp"
#include "core/slam/graph/near_points.hpp"
#include "core/slam/matching/sweep.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// shortest path length for the odometry sigma: errors do not get smaller below it
constexpr double kLeastStep_m = 0.05;
constexpr double kSigmasOff = 3.0;
constexpr int kLooksFromOnePlace = 10;  // most searches of a given map from one place: further ones see nothing new
constexpr double kInSubmap_m = 0.005;   // position sigma of a node relative to its own submap
constexpr double kInSubmap_deg = 0.02;
constexpr double kStartSigma_m = 0.01, kStartSigma_deg = 0.1;  // sigma of a known start pose
constexpr double kGuessed_m = 10.0, kGuessed_deg = 10.0;       // sigma of an unknown start pose
constexpr double kTilt_rad = 0.5 * kRadPerDeg;                 // tilt sigma of an unknown start: gravity is known
// Longest delay between a scan and a GNSS fix that arrives before it [s]. Scans that are later may lose their fix.
constexpr double kScanLate_s = 2.0;
// Most pairs of position and GNSS fix kept to fit an unknown start. Larger values average more fixes.
constexpr std::size_t kMostMatched = 2000;

Matrix6 information_of(double position_m, double attitude_rad) {
  Matrix6 information = Matrix6::Zero();
  information.diagonal().head<3>().setConstant(1.0 / (position_m * position_m));
  information.diagonal().tail<3>().setConstant(1.0 / (attitude_rad * attitude_rad));
  return information;
}

/// Heading and position of a body, without tilt; z up as in the local frame.
Pose level(const Pose& T) { return make_pose(T.translation(), rotation_by({0.0, 0.0, yaw_of(T.linear())})); }

}  // namespace

GlobalSlam::GlobalSlam(const GlobalSlamConfig& config, bool pose_known)
    : config_(config), latency_(config.latency_s), pose_known_(pose_known), located_(pose_known) {
  if (config.loaded_map == nullptr) return;
  graph_ = config.loaded_map->graph;
  num_given_poses_ = graph_.num_poses();
  submap_poses_.num_given = config.loaded_map->submaps.size();
}

void GlobalSlam::add_scan(TimeNs t, const Pose& T_local_body, std::span<const Eigen::Vector3f> points_body_m,
                          const Pose& T_world_local) {
  double step_m = 0.0;
  if (!nodes_.empty()) {
    step_m = (T_local_body.translation() - nodes_.back().T_local_body.translation()).norm();
    if (t <= nodes_.back().t ||
        (step_m < config_.node_every_m && !is_search_due(t, nodes_.back().path_length_m + step_m)))
      return;
  } else {
    last_optimized_ = t;
  }
  Node node{t, 0, T_local_body, step_m};
  if (nodes_.empty()) {
    node.pose = graph_.add_pose(T_world_local * T_local_body);
    Matrix6 information = pose_known_ ? information_of(kStartSigma_m, kStartSigma_deg * kRadPerDeg)
                                      : information_of(kGuessed_m, kGuessed_deg * kRadPerDeg);
    if (!pose_known_) information.diagonal().segment<2>(3).setConstant(1.0 / (kTilt_rad * kTilt_rad));
    graph_.add(PriorFactor{node.pose, graph_.pose(node.pose), information});
  } else {
    const Node& last = nodes_.back();
    node.path_length_m = last.path_length_m + step_m;
    const Pose T_last_node = last.T_local_body.inverse() * T_local_body;
    node.pose = graph_.add_pose(graph_.pose(last.pose) * T_last_node);
    graph_.add(RelativeFactor{last.pose, node.pose, T_last_node, odometry_information(step_m), kNoHuber});
  }
  nodes_.push_back(node);
  add_gravity();
  place_fixes();
  if (submaps_.empty() || node.path_length_m - submaps_.back().begin_m > config_.submap_m) begin_next_submap();
  Submap& submap = submaps_.back();
  submap.end_m = node.path_length_m;
  const Pose T_submap_body = submap.T_local_submap.inverse() * T_local_body;
  submap.points_submap_m.reserve(submap.points_submap_m.size() + points_body_m.size());
  for (const Eigen::Vector3f& p : points_body_m) {
    submap.points_submap_m.push_back((T_submap_body * p.cast<double>()).cast<float>());
  }
  graph_.add(RelativeFactor{submap.pose, nodes_.back().pose, T_submap_body,
                            information_of(kInSubmap_m, kInSubmap_deg * kRadPerDeg), kNoHuber});
  fit_start();
  locate(t);
  const bool placed = located_ || num_given_poses_ == 0;
  const bool due = placed && to_seconds(t - last_optimized_) >= config_.optimize_every_s;
  if (news_ || (fixes_ && due)) optimize(t);
}

void GlobalSlam::add_gravity() {
  const Node& node = nodes_.back();
  graph_.add(GravityFactor{node.pose, node.T_local_body.linear().transpose() * Vector3::UnitZ(),
                           config_.gravity_sigma_deg * kRadPerDeg});
}

void GlobalSlam::begin_submap(const Tie& tie, int first_pose, double hidden_m) {
  const Node& node = nodes_.back();
  Submap submap;
  submap.T_local_submap = level(node.T_local_body);
  submap.begin_m = submap.end_m = node.path_length_m;
  submap.pose = graph_.add_pose(graph_.pose(node.pose) * node.T_local_body.inverse() * submap.T_local_submap);
  submap.first_pose = first_pose;
  submap.tie = tie;
  submap.hidden_m = hidden_m;
  submaps_.push_back(std::move(submap));
  submap_poses_.T_local_own.push_back(submaps_.back().T_local_submap);
  ++submap_poses_.revision;
  if (submap_poses_.num_given == 0 || !located_ || !submap_poses_.T_local_given.empty() || submaps_.size() > 1) return;
  submap_poses_.T_local_given = given_poses_local();
  submap_poses_.given = pieces_of(*config_.loaded_map);
}

/// Finishes the newest submap: it is thinned to one point per voxel and compared with older submaps. Then the next
/// begins.
void GlobalSlam::begin_next_submap() {
  double hidden_m = 0.0;
  if (!submaps_.empty()) {
    std::vector<Eigen::Vector3f>& points_m = submaps_.back().points_submap_m;
    points_m = thinned_m(points_m);
    const std::vector<Older> joined = seek_closures();
    if (drop_known(joined)) return;
    forget_known(joined);
    if (submaps_.back().closed != Closed::kFully) hidden_m = submaps_.back().hidden_m;
  }
  const Node& node = nodes_.back();
  Tie tie;
  if (nodes_.size() > 1) {
    const Node& before = nodes_[nodes_.size() - 2];
    tie = {before.pose, before.T_local_body.inverse(), node.path_length_m - before.path_length_m};
  }
  begin_submap(tie, node.pose, hidden_m);
}

std::vector<Eigen::Vector3f> GlobalSlam::thinned_m(std::span<const Eigen::Vector3f> points_submap_m) const {
  std::vector<std::uint32_t> kept;
  kept.reserve(points_submap_m.size());
  VoxelThinner().thin(points_submap_m, static_cast<float>(config_.submap_voxel_m), kept);
  std::vector<Eigen::Vector3f> thinned_m(kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) thinned_m[i] = points_submap_m[kept[i]];
  return thinned_m;
}

/// Matches the newest submap with the nearest older ones that the vehicle left long ago, or that an earlier flight
/// made.
std::vector<GlobalSlam::Older> GlobalSlam::seek_closures() {
  std::vector<Older> joined;
  if (num_given_poses_ > 0 && !located_) return joined;
  const Submap& newer = submaps_.back();
  const Pose& T_world_newer = graph_.pose(newer.pose);
  const std::vector<double> path_length_m = shortest_path_lengths_m(graph_, newer.pose);
  struct Candidate {
    double distance_m = 0.0;
    int pose = 0;
    std::span<const Eigen::Vector3f> points_submap_m;
  };
  std::vector<Candidate> candidates;
  const auto consider = [&](int pose, std::span<const Eigen::Vector3f> points_submap_m) {
    const double distance_m = (graph_.pose(pose).translation() - T_world_newer.translation()).norm();
    if (distance_m <= config_.closure_distance_m) candidates.push_back({distance_m, pose, points_submap_m});
  };
  if (config_.loaded_map != nullptr) {
    for (const SavedMap::Submap& given : config_.loaded_map->submaps) consider(given.pose, given.points_submap_m);
  }
  for (std::size_t i = 0; i + 1 < submaps_.size(); ++i) {
    if (submaps_[i].thinned_out || newer.begin_m - submaps_[i].end_m < config_.closure_gap_m) continue;
    consider(submaps_[i].pose, submaps_[i].points_submap_m);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance_m < b.distance_m; });
  candidates.resize(std::min<std::size_t>(candidates.size(), config_.searches));
  for (const Candidate& candidate : candidates) {
    const double path_to_candidate_m = path_length_m[static_cast<std::size_t>(candidate.pose)] + newer.hidden_m;
    const ClosureResult result = find_closure(candidate.points_submap_m, newer.points_submap_m,
                                              level(graph_.pose(candidate.pose)).inverse() * level(T_world_newer),
                                              config_.closures, off_m(path_to_candidate_m));
    if (result.verdict != ClosureVerdict::kClosed) continue;
    join(candidate.pose, newer.pose, result);
    if (result.constrained.isIdentity()) {
      joined.push_back({candidate.pose, candidate.points_submap_m, result.T_older_newer});
    }
  }
  return joined;
}

/// Points of the newest submap that older ones do not cover.
std::vector<Eigen::Vector3f> GlobalSlam::unknown_m(std::span<const Older> older) const {
  std::vector<NearPoints> known;
  for (const Older& o : older) known.emplace_back(config_.submap_voxel_m, o.points_older_m);
  std::vector<Eigen::Vector3f> unknown_m;
  for (const Eigen::Vector3f& p_m : submaps_.back().points_submap_m) {
    bool is_known = false;
    for (std::size_t i = 0; i < older.size() && !is_known; ++i) {
      is_known = known[i].contain(older[i].T_older_newer * p_m.cast<double>());
    }
    if (!is_known) unknown_m.push_back(p_m);
  }
  return unknown_m;
}

/// Do older submaps contain enough of the newest one's points?
bool GlobalSlam::is_covered(std::size_t num_unknown) const {
  const auto num = static_cast<double>(submaps_.back().points_submap_m.size());
  return num - static_cast<double>(num_unknown) >= config_.covered_share * num;
}

/// Keeps only the points of the newest submap that the older ones joined with it lack.
void GlobalSlam::forget_known(std::span<const Older> joined) {
  if (joined.empty() || config_.covered_share >= 1.0) return;
  const std::vector<Eigen::Vector3f> fresh_m = unknown_m(joined);
  if (!is_covered(fresh_m.size())) return;
  submaps_.back().points_submap_m = std::vector<Eigen::Vector3f>(fresh_m);  // exact copy: releases the spare capacity
  submaps_.back().thinned_out = true;
}

/// Drops the newest submap if visits_kept others began there and cover its points. A submap with a better closure than
/// the one with its predecessor stays, because it closes a loop.
bool GlobalSlam::drop_known(std::span<const Older> joined) {
  const Submap& newest = submaps_.back();
  if (config_.covered_share >= 1.0 || submaps_.size() < 2) return false;
  if (newest.closed > submaps_[submaps_.size() - 2].closed) return false;
  const Pose T_world_newest =
      joined.empty() ? graph_.pose(newest.pose) : graph_.pose(joined.front().pose) * joined.front().T_older_newer;
  std::vector<Older> here;
  double nearest_m = std::numeric_limits<double>::infinity();
  int into = 0;
  Pose T_into_newest = Pose::Identity();
  for (std::size_t i = 0; i + 1 < submaps_.size(); ++i) {
    const Pose T_older_newest = graph_.pose(submaps_[i].pose).inverse() * T_world_newest;
    const double distance_m = T_older_newest.translation().norm();
    if (distance_m > 0.5 * config_.submap_m) continue;
    here.push_back({submaps_[i].pose, submaps_[i].points_submap_m, T_older_newest});
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    into = static_cast<int>(i);
    T_into_newest = T_older_newest;
  }
  if (static_cast<int>(here.size()) < config_.visits_kept || !is_covered(unknown_m(here).size())) return false;
  record_dropped(into, T_into_newest);
  drop_newest(joined);
  return true;
}

/// Moves cells that a mapper attached to the newest submap to an older one.
void GlobalSlam::record_dropped(int into, const Pose& T_into_newest) {
  const int number = num_submaps() - 1;
  submap_poses_.dropped = {submap_poses_.dropped.count + 1, number, into, T_into_newest};
  submap_poses_.T_local_own.pop_back();
  for (Learned& learned : learned_) {
    if (static_cast<int>(learned.T_local_own.size()) > number) learned.T_local_own.pop_back();
  }
}

/// Removes the nodes of the newest submap from the graph. Its pose and closures stay until the next submap is finished,
/// which begins at the present node.
void GlobalSlam::drop_newest(std::span<const Older> joined) {
  const Submap dropped = std::move(submaps_.back());
  submaps_.pop_back();
  Node node = nodes_.back();  // first node of the next submap
  const Pose T_world_dropped = graph_.pose(dropped.pose), T_world_node = graph_.pose(node.pose);
  std::vector<RelativeFactor> closures;
  for (const RelativeFactor& f : graph_.relative_factors()) {
    if (f.to == dropped.pose && f.from < dropped.first_pose) closures.push_back(f);
  }
  graph_.truncate(dropped.first_pose);
  std::erase_if(nodes_, [&](const Node& n) { return n.pose >= dropped.first_pose; });
  const int pose = graph_.add_pose(T_world_dropped);
  graph_.add(RelativeFactor{dropped.tie.pose, pose, dropped.tie.T_pose_local * dropped.T_local_submap,
                            odometry_information(dropped.tie.path_length_m), kNoHuber});
  for (RelativeFactor& closure : closures) {
    closure.to = pose;
    graph_.add(closure);
  }
  const double path_length_m = node.path_length_m - dropped.begin_m;
  node.pose = graph_.add_pose(T_world_node);
  graph_.add(RelativeFactor{pose, node.pose, dropped.T_local_submap.inverse() * node.T_local_body,
                            odometry_information(path_length_m), kNoHuber});
  nodes_.push_back(node);
  add_gravity();
  if (joined.empty()) {
    const Tie& tie = dropped.tie;
    begin_submap({tie.pose, tie.T_pose_local, tie.path_length_m + path_length_m}, pose,
                 dropped.hidden_m + path_length_m);
  } else {
    const Older& older = joined.front();
    begin_submap({older.pose, older.T_older_newer * dropped.T_local_submap.inverse(), path_length_m}, pose, 0.0);
  }
}

/// Adds a closure between the newest submap and an older one.
void GlobalSlam::join(int older_pose, int newer_pose, const ClosureResult& closure) {
  const Matrix6 information = information_of(config_.closure_position_m, config_.closure_attitude_deg * kRadPerDeg);
  graph_.add(RelativeFactor{older_pose, newer_pose, closure.T_older_newer,
                            closure.constrained.transpose() * information * closure.constrained,
                            config_.closure_huber});
  Submap& newest = submaps_.back();
  newest.closed = std::max(newest.closed, closure.constrained.isIdentity() ? Closed::kFully : Closed::kPartly);
  ++num_closures_;
  news_ = true;
}

/// Does a hovering vehicle search again? It turns meanwhile and sees more.
bool GlobalSlam::is_search_due(TimeNs t, double path_length_m) const {
  return num_given_poses_ > 0 && !located_ && !search_failed() && path_length_m - hovers_at_m_ < config_.node_every_m &&
         to_seconds(t - searched_at_) >= config_.locate_every_s;
}

bool GlobalSlam::search_failed() const {
  return num_given_poses_ > 0 && !located_ && num_searches_here_ >= kLooksFromOnePlace;
}

/// Relocalizes a vehicle of unknown start in the map of an earlier flight by its present submap: at intervals along its
/// path and while it hovers.
void GlobalSlam::locate(TimeNs t) {
  if (located_ || num_given_poses_ == 0) return;
  const double path_length_m = nodes_.back().path_length_m;
  const bool moved_on = nodes_.size() == 1 || path_length_m - searched_at_m_ >= config_.locate_every_m;
  if (!moved_on && !is_search_due(t, path_length_m)) return;
  num_searches_here_ = moved_on ? 1 : num_searches_here_ + 1;
  searched_at_ = t;
  hovers_at_m_ = path_length_m;
  if (moved_on) searched_at_m_ = path_length_m;
  const SavedMap& given = *config_.loaded_map;
  std::vector<MapPart> parts;
  parts.reserve(given.submaps.size());
  for (const SavedMap::Submap& submap : given.submaps) {
    parts.push_back({level(graph_.pose(submap.pose)), submap.points_submap_m});
  }
  const Submap& own = submaps_.back();
  const MapMatch match = find_in_map(parts, thinned_m(own.points_submap_m), config_.locate);
  if (match.result.verdict != ClosureVerdict::kClosed) return;
  located_ = true;
  const int older_pose = given.submaps[match.part].pose;
  const Pose T_older_own = match.result.T_older_newer;
  const Pose by = level(graph_.pose(older_pose) * T_older_own) * level(graph_.pose(own.pose)).inverse();
  for (int i = num_given_poses_; i < graph_.num_poses(); ++i) graph_.set_pose(i, by * graph_.pose(i));
  graph_.clear_priors(num_given_poses_);  // removes the guess of the start
  join(older_pose, own.pose, match.result);
}

std::shared_ptr<const SavedMap> GlobalSlam::saved_map() const {
  if (num_given_poses_ > 0 && !located_) return config_.loaded_map;
  auto map = std::make_shared<SavedMap>();
  if (config_.loaded_map != nullptr) {
    map->nodes = config_.loaded_map->nodes;
    map->submaps = config_.loaded_map->submaps;
    map->pieces = config_.loaded_map->pieces;
  }
  map->voxel_m = config_.submap_voxel_m;
  map->graph = graph_;
  map->nodes.reserve(map->nodes.size() + nodes_.size());
  for (const Node& node : nodes_) map->nodes.push_back({node.t, node.pose});
  map->submaps.reserve(map->submaps.size() + submaps_.size());
  for (const Submap& submap : submaps_) map->submaps.push_back({submap.pose, submap.points_submap_m});
  if (!submaps_.empty()) map->submaps.back().points_submap_m = thinned_m(submaps_.back().points_submap_m);
  return map;
}

void GlobalSlam::add_gnss(const GnssSample& sample) {
  if (!config_.use_gnss || !sample.p_world_m.allFinite() || !sample.sigma_p_m.allFinite()) return;
  if (nodes_.empty() || sample.t < nodes_.back().t) return;
  waiting_.push_back(sample);
  // The next node uses the newest fix that is not newer than the node.
  while (waiting_.size() > 1 && to_seconds(sample.t - waiting_[1].t) > kScanLate_s) waiting_.erase(waiting_.begin());
}

/// Adds the last fix before the newest node; it stands for all fixes since the node before. Fixes may be newer than the
/// nodes, whose scans arrive later.
void GlobalSlam::place_fixes() {
  if (waiting_.empty() || nodes_.size() < 2) return;
  const Node &before = nodes_[nodes_.size() - 2], &after = nodes_.back();
  const auto newer =
      std::find_if(waiting_.begin(), waiting_.end(), [&](const GnssSample& fix) { return fix.t > after.t; });
  if (newer == waiting_.begin()) return;
  const GnssSample fix = *std::prev(newer);
  waiting_.erase(waiting_.begin(), newer);
  const double beta = std::max(0.0, to_seconds(fix.t - before.t) / to_seconds(after.t - before.t));
  graph_.add(PositionFactor{before.pose, after.pose, beta, fix.p_world_m, gnss_weight_1_m(config_.gnss, fix.sigma_p_m),
                            config_.gnss.huber});
  const Vector3 p_local_m = (1.0 - beta) * before.T_local_body.translation() + beta * after.T_local_body.translation();
  if (!pose_known_ && !fitted_) matched_.push_back({p_local_m, fix.p_world_m, 1.0});
  if (matched_.size() > kMostMatched) matched_.erase(matched_.begin());
  fixes_ = true;
}

/// Fits an unknown start to east, north and up once the path is long enough to determine a heading.
void GlobalSlam::fit_start() {
  if (pose_known_ || fitted_ || num_given_poses_ > 0 || matched_.size() < 5) return;
  const Node& first = nodes_.front();
  const Pose T_world_local = level(graph_.pose(first.pose) * first.T_local_body.inverse());
  const double yaw_rad = yaw_of(T_world_local.linear());
  const Pose fitted = fit_to_world(matched_, yaw_rad, config_.fit_spread_m);
  if (yaw_of(fitted.linear()) == yaw_of(level_alignment(yaw_rad, Vector3::Zero(), Vector3::Zero()).linear()))
    return;  // fixes too near to each other
  fitted_ = true;
  matched_ = {};
  const Pose by = fitted * T_world_local.inverse();
  for (int i = 0; i < graph_.num_poses(); ++i) graph_.set_pose(i, by * graph_.pose(i));
  graph_.clear_priors();
  Matrix6 information = information_of(kGuessed_m, kGuessed_deg * kRadPerDeg);
  information.diagonal().segment<2>(3).setConstant(1.0 / (kTilt_rad * kTilt_rad));
  graph_.add(PriorFactor{first.pose, graph_.pose(first.pose), information});
}

void GlobalSlam::optimize(TimeNs t) {
  graph_.optimize(config_.graph, graph_workspace_);
  news_ = fixes_ = false;
  last_optimized_ = t;
  const Node& last = nodes_.back();
  // Both frames have z up: only local SLAM determines the tilt of the local frame.
  const Pose T_world_local = graph_.pose(last.pose) * last.T_local_body.inverse();
  Learned learned;
  learned.begun = t;
  learned.T_world_local = level_alignment(yaw_of(T_world_local.linear()), graph_.pose(last.pose).translation(),
                                          last.T_local_body.translation());
  learned.T_local_own.reserve(submaps_.size());
  const Pose T_local_from_world = this->T_local_world();
  for (const Submap& submap : submaps_) learned.T_local_own.push_back(T_local_from_world * graph_.pose(submap.pose));
  learned.T_local_own.back() = submaps_.back().T_local_submap;
  if (located_) learned.T_local_given = given_poses_local();
  learned_.push_back(std::move(learned));
}

/// The newest submap links the frames: what the vehicle sees now stands still in the local frame.
Pose GlobalSlam::T_local_world() const {
  return submaps_.back().T_local_submap * graph_.pose(submaps_.back().pose).inverse();
}

std::vector<Pose> GlobalSlam::given_poses_local() const {
  std::vector<Pose> T_local_given;
  if (config_.loaded_map == nullptr) return T_local_given;
  const Pose T_local_from_world = T_local_world();
  for (const SavedMap::Submap& submap : config_.loaded_map->submaps) {
    T_local_given.push_back(T_local_from_world * graph_.pose(submap.pose));
  }
  return T_local_given;
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
  if (submaps_.empty()) return;
  const Pose T_local_from_world = T_local_world();
  const auto place_local_m = [&](int pose) {
    return Eigen::Vector3f((T_local_from_world * graph_.pose(pose).translation()).cast<float>());
  };
  Overlay trajectory, submaps, closures;
  trajectory.name = "slam.trajectory";
  trajectory.kind = Overlay::Kind::kPolyline;
  trajectory.size_m = 3.0F;
  trajectory.colors = {{0.10F, 0.55F, 0.85F, 1.0F}};
  trajectory.legend = {{"trajectory by the pose graph", trajectory.colors.front()}};
  for (const Node& node : nodes_) trajectory.positions.push_back(place_local_m(node.pose));
  submaps.name = "slam.submaps";
  submaps.kind = Overlay::Kind::kSpheres;
  submaps.size_m = 0.3F;
  submaps.colors = {{0.95F, 0.80F, 0.15F, 1.0F}};
  submaps.legend = {{"starts of submaps", submaps.colors.front()}};
  for (const Submap& submap : submaps_) submaps.positions.push_back(place_local_m(submap.pose));
  closures.name = "slam.closures";
  closures.kind = Overlay::Kind::kLines;
  closures.size_m = 4.0F;
  closures.colors = {{0.85F, 0.15F, 0.55F, 1.0F}};
  closures.legend = {{"closures between submaps", closures.colors.front()}};
  for (const RelativeFactor& factor : graph_.relative_factors()) {
    if (factor.huber == kNoHuber) continue;
    closures.positions.push_back(place_local_m(factor.from));
    closures.positions.push_back(place_local_m(factor.to));
  }
  overlays.push_back(std::move(trajectory));
  overlays.push_back(std::move(submaps));
  overlays.push_back(std::move(closures));
}

std::size_t GlobalSlam::num_points() const {
  std::size_t num = 0;
  for (std::size_t i = 0; i + 1 < submaps_.size(); ++i) num += submaps_[i].points_submap_m.size();
  return num;
}

/// Bound of the drift of local SLAM over a path, by the odometry sigmas of the graph.
double GlobalSlam::off_m(double path_length_m) const {
  const double turn_rad_sqrt_m = config_.odometry_attitude_deg_sqrt_m * kRadPerDeg;
  return kSigmasOff * std::sqrt(path_length_m) *
         (config_.odometry_position_m_sqrt_m + turn_rad_sqrt_m * config_.closure_distance_m);
}

Matrix6 GlobalSlam::odometry_information(double path_length_m) const {
  const double root = std::sqrt(std::max(path_length_m, kLeastStep_m));
  return information_of(config_.odometry_position_m_sqrt_m * root,
                        config_.odometry_attitude_deg_sqrt_m * kRadPerDeg * root);
}

void GlobalSlamConfig::visit(ConfigVisitor& v) {
  const Range positive = Range::positive();
  v.field("enabled", enabled, "[-] are loops closed and GNSS fixes used?");
  v.field("latency_s", latency_s, "[s] time from a scan to its correction: search and optimization",
          Range::between(0.0, 60.0));
  v.field("covered_share", covered_share,
          "[-] share of a submap's points in older joined ones from which on it keeps only the others; 1: keeps all",
          Range::probability());
  v.field("visits_kept", visits_kept,
          "[-] submaps that begin within half of submap_m of each other, at most: another one is dropped if these know "
          "covered_share of its points; more take more memory",
          Range::between(1, 1000));
  v.field("searches", searches, "[-] most searches for a finished submap", Range::between(0, 100));
  v.field("use_gnss", use_gnss, "[-] do GNSS fixes constrain the trajectory?");
  v.field("optimize_every_s", optimize_every_s, "[s] interval of optimizations with new fixes; a closure does not wait",
          positive);
  v.field("fit_spread_m", fit_spread_m, "[m] extent of the path from which an unknown start is fitted to GNSS",
          positive);
  v.file("map", map,
         "map of an earlier flight, as the recorder `slam_map` writes it: the vehicle localizes itself in it");
  v.field("locate_every_m", locate_every_m,
          "[m] flown distance between searches of a vehicle of unknown start in that map", positive);
  v.field("locate_every_s", locate_every_s, "[s] interval of such searches while it hovers; at most ten from one place",
          positive);
  v.object("locate", locate, "search for the own pose in that map, around each submap's center");
  v.object("gnss", gnss, "weight of a fix");
  v.object("closures", closures, "search for closures and their checks");
  v.object("graph", graph, "optimization of the pose graph");
  v.object("blend", blend, "transition to a new correction");
  v.object("share", share, "joining the map with those of other vehicles");
}

}  // namespace swiftlet
