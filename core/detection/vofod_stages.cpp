// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/vofod_stages.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/detection/direction_bins.hpp"

namespace swiftlet {
namespace {

// Height above the lowest beam, as a sine of the elevation, below which a return is at the lower edge of the field of
// view: 1.7 deg, a little less than the spacing of the beams of a Puck. Larger values take more hovering targets for
// objects on the ground.
constexpr float kEdge = 0.03F;
/// [-] Fewest points of a detection; fewest voxels if voxels are clustered. Larger values miss far objects; smaller
/// ones report single stray returns.
constexpr std::size_t kMinPoints = 2;

// Sine of the elevation of the lowest beam; of the lowest return if shots without return have no direction.
float lowest_z(const Scan& scan) {
  const BeamTable& beams = *scan.beams;
  float lowest = 1.0F;
  for (int i = 0; i < scan.size(); ++i) {
    if ((beams.masked.empty() || beams.masked[i] == 0) && has_direction(beams, i))
      lowest = std::min(lowest, beams.directions_lidar[i].z());
  }
  return lowest;
}

}  // namespace

VofodStages::VofodStages(const VofodConfig& config)
    : config_(config),
      map_(config.map),
      large_is_background_(config.seed == VofodSeed::kLarge || config.seed == VofodSeed::kLargeAndAltimeter),
      clusterer_(make_clusterer(config.clusterer)),
      rays_(config),
      separate_(config) {}

void VofodStages::classify(const LocalCloud& cloud, std::vector<Detection>& detections) {
  take_samples(cloud);
  find_background();
  switch (config_.choices.map_update) {
    case VofodChoices::MapUpdate::kAfter:
      classify_then_update(cloud, detections);
      break;
    case VofodChoices::MapUpdate::kBefore:
      update_then_classify(cloud, detections);
      break;
  }
  set_large();
}

// The paper: rules first, then eqs. (16) to (18), in this order where a voxel has points of several classes.
void VofodStages::classify_then_update(const LocalCloud& cloud, std::vector<Detection>& detections) {
  find_flying(cloud, detections);
  put_aside();
  for_each_cluster(ClusterClass::kBackground, [&](Members members) { put(members, config_.map.g_occupied); });
  for (int i = 0; i < clusters_.size(); ++i) {
    if (classes_[i] == ClusterClass::kFlying) set(clusters_.members(i), config_.map.g_unknown);
    if (classes_[i] == ClusterClass::kUnknown) put(clusters_.members(i), config_.map.g_unknown);
  }
}

// The released code: updates by points first, with detections like other unknown ones, then rules B and C.
void VofodStages::update_then_classify(const LocalCloud& cloud, std::vector<Detection>& detections) {
  put_aside();
  for (int i = 0; i < clusters_.size(); ++i) {
    const bool background = classes_[i] == ClusterClass::kBackground;
    put(clusters_.members(i), background ? config_.map.g_occupied : config_.map.g_unknown);
  }
  find_flying(cloud, detections);
}

void VofodStages::take_samples(const LocalCloud& cloud) {
  lowest_z_ = lowest_z(*cloud.scan);
  samples_.take_points(cloud, map_.grid());
  num_points_ += cloud.size();
  num_points_outside_ += cloud.size() - samples_.size();
  if (config_.choices.clustering == VofodChoices::Clustering::kVoxels) samples_.thin_to_voxels(map_.grid());
}

// Applies rule A to every cluster before any cluster changes the map.
void VofodStages::find_background() {
  set_background_aside();
  clusters_.compute(samples_.at_local_m, config_.cluster_distance_m);
  classes_.resize(clusters_.size());
  in_free_air_.resize(clusters_.size());
  for (int i = 0; i < clusters_.size(); ++i) {
    classes_[i] = is_background(clusters_.members(i)) ? ClusterClass::kBackground : ClusterClass::kUnknown;
    in_free_air_[i] = is_in_free_air(clusters_.members(i));
  }
}

bool VofodStages::is_in_free_air(Members members) const {
  const auto num_free = std::count_if(members.begin(), members.end(), [&](std::uint32_t i) {
    return map_.state(samples_.voxel[i]) == VoxelState::kFree;
  });
  return 2 * num_free > static_cast<std::ptrdiff_t>(members.size());
}

// Most points are near background themselves; rule A makes any cluster with them background, so they need no
// clustering. Only those close to a point that is not near background are clustered with it.
void VofodStages::set_background_aside() {
  const std::size_t count = samples_.at_local_m.size();
  near_background_.resize(count);
  vicinity_.begin(map_.grid(), config_.cluster_distance_m);
  for (std::size_t i = 0; i < count; ++i) {
    near_background_[i] = is_near_background(samples_.at_local_m[i]);
    if (!near_background_[i]) vicinity_.add(samples_.at_local_m[i]);
  }
  aside_.clear();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (near_background_[i] && !vicinity_.contains(samples_.at_local_m[i])) {
      aside_.add(samples_, i);
      continue;
    }
    near_background_[kept] = near_background_[i];
    samples_.move(i, kept++);
  }
  samples_.resize(kept);
}

bool VofodStages::is_near_background(const Eigen::Vector3f& at_local_m) const {
  return map_.occupied_within(at_local_m.cast<double>(), config_.close_distance_m);
}

bool VofodStages::is_background(Members members) const {
  return std::any_of(members.begin(), members.end(), [&](std::uint32_t i) { return near_background_[i] != 0; });
}

void VofodStages::find_flying(const LocalCloud& cloud, std::vector<Detection>& detections) {
  for (int i = 0; i < clusters_.size(); ++i) {
    if (classes_[i] == ClusterClass::kBackground) continue;
    const Members members = clusters_.members(i);
    const ClusterShape shape = shape_of(samples_, members);
    const MovedThings::Motion motion = things_.see(cloud.stamp(), shape.centroid_local_m, in_free_air_[i] != 0);
    if (!rises_into_view(cloud, members, motion) && is_flying(cloud, members, shape, motion.has_moved)) {
      classes_[i] = ClusterClass::kFlying;
      detections.push_back(detection_of({cloud, samples_, members, shape, map_, starts_, starts_index_}, config_));
    } else if (large_is_background_ && shape.diagonal_m() > config_.max_size_m) {
      classes_[i] = ClusterClass::kTooLarge;
    }
  }
}

// True for an object at the lower edge of the field of view that has not moved: it may stand on the ground, which is
// not in view. Rays along the edge clear the voxel below, although they pass only little of that voxel.
bool VofodStages::rises_into_view(const LocalCloud& cloud, Members members, const MovedThings::Motion& motion) const {
  if (config_.still_s <= 0.0 || motion.has_moved || motion.seen_for < from_seconds(config_.still_s)) return false;
  return std::any_of(members.begin(), members.end(), [&](std::uint32_t i) {
    return cloud.scan->beams->directions_lidar[cloud.beam[samples_.point[i]]].z() < lowest_z_ + kEdge;
  });
}

bool VofodStages::is_flying(const LocalCloud& cloud, Members members, const ClusterShape& shape, bool has_moved) {
  if (members.size() < kMinPoints || shape.diagonal_m() > config_.max_size_m) return false;
  starts_index_.clear();
  for (const std::uint32_t i : members) starts_index_.push_back(samples_.voxel[i]);
  std::sort(starts_index_.begin(), starts_index_.end());
  starts_index_.erase(std::unique(starts_index_.begin(), starts_index_.end()), starts_index_.end());
  starts_.clear();
  for (const std::ptrdiff_t index : starts_index_) starts_.push_back(map_.grid().cell(index));

  SearchShape reach = search_shape(shape);
  reach.sensor_m = cloud.T_local_lidar_of_beam(cloud.beam[samples_.point[members.front()]]).translation();
  if (has_moved) reach.top_z = rays_.top_z();
  return search_.enclosed(map_, starts_, reach);
}

SearchShape VofodStages::search_shape(const ClusterShape& shape) const {
  SearchShape reach{.octahedron = config_.choices.search == VofodChoices::Search::kOctahedron,
                    .radius_m = config_.search_distance_m};
  reach.radius_steps = static_cast<int>((shape.diagonal_m() + config_.search_distance_m) / config_.map.voxel_m);
  return reach;
}

void VofodStages::put_aside() {
  for (std::size_t i = 0; i < aside_.size(); ++i) {
    map_.update(aside_.voxel[i], aside_.weight_of(i), config_.map.g_occupied);
  }
}

void VofodStages::put(Members members, double g) {
  for (const std::uint32_t i : members) map_.update(samples_.voxel[i], samples_.weight_of(i), g);
}

// Sets voxels exactly to g, as eq. (17) does for detections.
void VofodStages::set(Members members, double g) {
  for (const std::uint32_t i : members) map_.update(samples_.voxel[i], std::numeric_limits<double>::infinity(), g);
}

// Clusters too large to fly begin or extend the background.
void VofodStages::set_large() {
  for_each_cluster(ClusterClass::kTooLarge, [&](Members members) { set(members, config_.map.g_occupied); });
}

template <class Visit>
void VofodStages::for_each_cluster(ClusterClass of_class, Visit&& visit) const {
  for (int i = 0; i < clusters_.size(); ++i) {
    if (classes_[i] == of_class) visit(clusters_.members(i));
  }
}

void VofodStages::cast_rays(const LocalCloud& cloud) { rays_.cast(cloud, map_.grid()); }

void VofodStages::apply_rays(int num_classifications) { rays_.apply(num_classifications, map_); }

void VofodStages::find_separate() { separate_.find(map_); }

void VofodStages::remove_separate(int num_classifications) { separate_.remove(num_classifications, map_); }

void VofodStages::seed_ground(const Vector3& p_local_m) {
  if (map_.grid().contains(p_local_m)) {
    map_.update(map_.grid().index(map_.grid().cell_of(p_local_m)), 1.0, config_.map.g_occupied);
  }
}

void VofodStages::append_cluster_points(ClusterClass of_class, std::vector<Eigen::Vector3f>& points_local_m) const {
  if (of_class == ClusterClass::kBackground)
    points_local_m.insert(points_local_m.end(), aside_.at_local_m.begin(), aside_.at_local_m.end());
  for (int i = 0; i < static_cast<int>(classes_.size()); ++i) {
    if (classes_[i] != of_class) continue;
    for (const std::uint32_t member : clusters_.members(i)) points_local_m.push_back(samples_.at_local_m[member]);
  }
}

}  // namespace swiftlet
