// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/vofod_stages.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Margin in voxels around a cluster's box in which the released code computes the confidence.
constexpr int kConfidenceMargin = 2;

MeasurementNoise noise_of(const VofodConfig& config) {
  MeasurementNoise noise;
  noise.sigma_range_m = config.sigma_range_m;
  noise.sigma_position_m.setConstant(config.sigma_position_m);
  noise.sigma_attitude_rad.setConstant(config.sigma_attitude_rad);
  return noise;
}

}  // namespace

VofodStages::VofodStages(const VofodConfig& config)
    : config_(config),
      map_(config.map),
      large_is_background_(config.seed == VofodSeed::kLarge || config.seed == VofodSeed::kLargeAndAltimeter),
      g_just_free_(std::nextafter(static_cast<float>(config.map.G_uncertain), -std::numeric_limits<float>::max())),
      clusterer_(make_clusterer(config.clusterer)) {}

void VofodStages::classify(const LocalCloud& cloud, std::vector<Detection>& detections) {
  take_samples(cloud);
  find_background();
  to_clear_.clear();
  switch (config_.choices.map_update) {
    case VofodChoices::MapUpdate::kAfter:
      classify_then_update(cloud, detections);
      break;
    case VofodChoices::MapUpdate::kBefore:
      update_then_classify(cloud, detections);
      break;
  }
  set_large();
  for (const std::ptrdiff_t index : to_clear_) {
    if (map_.state(index) == VoxelState::kUncertain) map_.set(index, g_just_free_);
  }
  if (config_.choices.hit_voxels == VofodChoices::HitVoxels::kKeep) {
    for (const Samples* samples : {&aside_, &samples_}) {
      for (const std::ptrdiff_t voxel : samples->voxel) hits_.push_back(map_.grid().cell(voxel));
    }
  }
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
  for (int i = 0; i < clusters_.size(); ++i) {
    classes_[i] = is_background(clusters_.members(i)) ? ClusterClass::kBackground : ClusterClass::kUnknown;
  }
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
  const VoxelState at_least =
      config_.choices.close_to == VofodChoices::CloseTo::kConfident ? VoxelState::kConfident : VoxelState::kTentative;
  return map_.any_within(at_local_m.cast<double>(), config_.close_distance_m, at_least);
}

bool VofodStages::is_background(Members members) const {
  return std::any_of(members.begin(), members.end(), [&](std::uint32_t i) { return near_background_[i] != 0; });
}

void VofodStages::find_flying(const LocalCloud& cloud, std::vector<Detection>& detections) {
  const bool sufficient = is_sufficient();
  for (int i = 0; i < clusters_.size(); ++i) {
    if (classes_[i] == ClusterClass::kBackground) continue;
    const Members members = clusters_.members(i);
    const ClusterShape shape = shape_of(samples_, members);
    if (sufficient && is_flying(cloud, members, shape)) {
      classes_[i] = ClusterClass::kFlying;
      detections.push_back(make_detection(cloud, members, shape));
      if (config_.choices.failed_search == VofodChoices::FailedSearch::kClear) {
        to_clear_.insert(to_clear_.end(), search_.explored().begin(), search_.explored().end());
      }
    } else if (large_is_background_ && shape.diagonal_m() > config_.max_size_m) {
      classes_[i] = ClusterClass::kTooLarge;
    }
  }
}

bool VofodStages::is_flying(const LocalCloud& cloud, Members members, const ClusterShape& shape) {
  if (static_cast<int>(members.size()) < config_.min_points || shape.diagonal_m() > config_.max_size_m) return false;
  const Vector3 sensor_m = cloud.T_local_lidar_of_beam(cloud.beam[samples_.point[members.front()]]).translation();
  if (config_.max_range_m > 0.0 && (shape.centroid_local_m - sensor_m).norm() > config_.max_range_m) return false;

  starts_index_.clear();
  for (const std::uint32_t i : members) starts_index_.push_back(samples_.voxel[i]);
  std::sort(starts_index_.begin(), starts_index_.end());
  starts_index_.erase(std::unique(starts_index_.begin(), starts_index_.end()), starts_index_.end());
  starts_.clear();
  for (const std::ptrdiff_t index : starts_index_) starts_.push_back(map_.grid().cell(index));

  return search_.enclosed(map_, starts_, search_shape(shape));
}

SearchShape VofodStages::search_shape(const ClusterShape& shape) const {
  SearchShape reach{.octahedron = config_.choices.search == VofodChoices::Search::kOctahedron,
                    .radius_m = config_.search_distance_m};
  reach.radius_steps = static_cast<int>((shape.diagonal_m() + config_.search_distance_m) / config_.map.voxel_m);
  return reach;
}

// The released code's two conditions; the first stays true once met.
bool VofodStages::is_sufficient() {
  if (config_.choices.sufficiency == VofodChoices::Sufficiency::kNone) return true;
  const Cell size = map_.grid().size;
  const double needed = config_.choices.sufficient_ratio * size.x() * size.y();
  was_sufficient_ = was_sufficient_ || static_cast<double>(map_.num_occupied()) > needed;
  return was_sufficient_ && separator_.num_kept() > 0;
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
  for (const std::uint32_t i : members) map_.update(samples_.voxel[i], kInfinity, g);
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

Detection VofodStages::make_detection(const LocalCloud& cloud, Members members, const ClusterShape& shape) const {
  Detection d;
  std::int64_t offset_sum = 0;
  for (const std::uint32_t i : members) {
    offset_sum += cloud.time_of(samples_.point[i]) - cloud.stamp();
    d.num_points += samples_.weight_of(i);
  }
  d.t = cloud.stamp() + offset_sum / static_cast<std::int64_t>(members.size());
  d.position_m =
      config_.choices.position == VofodChoices::Position::kCentroid ? shape.centroid_local_m : shape.box_center_local_m;
  d.extent_m = shape.extent_m;
  d.covariance = covariance(cloud, samples_.point[members.front()], d.position_m);
  d.confidence = confidence();
  d.reflectivity = reflectivity(cloud, members);
  return d;
}

// A voxel represents all of its points.
double VofodStages::reflectivity(const LocalCloud& cloud, Members members) const {
  float greatest = 0.0F;
  if (config_.choices.clustering == VofodChoices::Clustering::kPoints) {
    for (const std::uint32_t i : members) greatest = std::max(greatest, cloud.reflectivity_of(samples_.point[i]));
    return greatest;
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::ptrdiff_t voxel = map_.grid().index_of(cloud.points_local_m[i].cast<double>());
    if (!std::binary_search(starts_index_.begin(), starts_index_.end(), voxel)) continue;
    greatest = std::max(greatest, cloud.reflectivity_of(i));
  }
  return greatest;
}

// Free share of the surroundings of the cluster last searched by rule B: exp(-sum(1 - G / g_free) / voxels) over its
// box and a margin, with its own voxels as free. Unspecified in the paper; the released code counts voxels, so that a
// near object with many points per voxel is not more certain than a far one.
double VofodStages::confidence() const {
  const VoxelGrid& grid = map_.grid();
  Cell first = starts_.front(), last = starts_.front();
  for (const Cell& cell : starts_) {
    first = first.cwiseMin(cell);
    last = last.cwiseMax(cell);
  }
  first = (first.array() - kConfidenceMargin).matrix().cwiseMax(grid.min_cell);
  last = (last.array() + kConfidenceMargin).matrix().cwiseMin(grid.min_cell + grid.size - Cell::Ones());
  double sum = 0.0;
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        const std::ptrdiff_t index = grid.index({x, y, z});
        if (std::binary_search(starts_index_.begin(), starts_index_.end(), index)) continue;
        sum += 1.0 - std::clamp(map_.value(index) / config_.map.g_free, 0.0, 1.0);
      }
    }
  }
  return elementary::exp(-sum / static_cast<double>(starts_.size()));
}

Matrix3 VofodStages::covariance(const LocalCloud& cloud, std::uint32_t point, const Vector3& position_local_m) const {
  const Matrix3 constant = config_.sigma_m * config_.sigma_m * Matrix3::Identity();
  if (config_.covariance == DetectionCovariance::kConstant) return constant;
  const Pose& T_local_lidar = cloud.T_local_lidar_of_beam(cloud.beam[point]);
  const Vector3 p_lidar = T_local_lidar.inverse() * position_local_m;
  const double range_m = p_lidar.norm();
  if (range_m <= 0.0) return constant;
  return constant + point_covariance(p_lidar / range_m, range_m, T_local_lidar.linear(), noise_of(config_).Sigma_w());
}

void VofodStages::cast_rays(const LocalCloud& cloud) {
  const Scan& scan = *cloud.scan;
  const BeamTable& beams = *scan.beams;
  double beam_offset_m = 0.0;  // offset of the beams from the sensor's origin
  for (const Eigen::Vector3f& origin : beams.origins_lidar) {
    if (origin.allFinite()) beam_offset_m = std::max(beam_offset_m, static_cast<double>(origin.norm()));
  }
  Eigen::AlignedBox3d origins;
  for (const Pose& pose : cloud.T_local_lidar) {
    if (pose.matrix().allFinite()) origins.extend(Vector3(pose.translation()));
  }
  if (origins.isEmpty() || !map_.grid().contains(Vector3(origins.center()))) {
    rays_.begin({}, config_.ray_max_m, config_.map.voxel_m);
    return;
  }
  origins.min().array() -= beam_offset_m + 1e-6;
  origins.max().array() += beam_offset_m + 1e-6;
  // The map may scroll until the rays take effect.
  VoxelGrid within = map_.grid();
  if (config_.map.extent == VoxelMapConfig::Extent::kScrolling) {
    within.min_cell.array() -= kRayScroll_voxels;
    within.size.array() += 2 * kRayScroll_voxels;
  }
  rays_.begin(origins, config_.ray_max_m, config_.map.voxel_m, &within);

  const double shorten_m = config_.choices.ray_end == VofodChoices::RayEnd::kVoxelBefore ? config_.map.voxel_m : 0.0;
  const bool masks = !beams.masked.empty();
  for (int row = 0; row < scan.rows(); ++row) {
    for (int column = 0; column < scan.cols(); ++column) {
      const int i = row * scan.cols() + column;
      if (masks && beams.masked[i]) continue;
      double length_m = config_.ray_max_m;
      if (scan.hit(i))
        length_m = std::min(length_m, static_cast<double>(scan.range_m[i]) - shorten_m);
      else if (!config_.empty_returns || !(scan.range_m[i] == 0.0F))
        continue;
      const Pose& T = cloud.T_local_lidar[column];
      rays_.add(T * beams.origins_lidar[i].cast<double>(), T.linear() * beams.directions_lidar[i].cast<double>(),
                length_m);
    }
  }
}

void VofodStages::apply_rays(int num_classifications) {
  rays_.leave_out(hits_);
  hits_.clear();
  rays_.apply(num_classifications * config_.ray_weight / std::sqrt(3.0), map_);
}

void VofodStages::find_separate() {
  const auto& found = separator_.find(map_, config_.separate_distance_m, config_.separate_min_confident);
  separate_.clear();
  switch (config_.choices.separate_reach) {
    case VofodChoices::SeparateReach::kCluster:
      for (const std::ptrdiff_t index : found) separate_.push_back(map_.grid().cell(index));
      break;
    case VofodChoices::SeparateReach::kSphere:
      append_spheres(found, separate_);
      break;
  }
}

// Appends every voxel within d_sep of a center, once.
void VofodStages::append_spheres(std::span<const std::ptrdiff_t> centers, std::vector<Cell>& cells) {
  const int reach = static_cast<int>(config_.separate_distance_m / config_.map.voxel_m);
  const double reach_sq = elementary::pow(config_.separate_distance_m / config_.map.voxel_m, 2);
  separate_index_.clear();
  for (const std::ptrdiff_t index : centers) {
    const Cell center = map_.grid().cell(index);
    for (int z = -reach; z <= reach; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          const Cell cell = center + Cell(x, y, z);
          if (x * x + y * y + z * z <= reach_sq && map_.grid().contains(cell)) {
            separate_index_.push_back(map_.grid().index(cell));
          }
        }
      }
    }
  }
  std::sort(separate_index_.begin(), separate_index_.end());
  separate_index_.erase(std::unique(separate_index_.begin(), separate_index_.end()), separate_index_.end());
  for (const std::ptrdiff_t index : separate_index_) cells.push_back(map_.grid().cell(index));
}

void VofodStages::remove_separate(int num_classifications) {
  const double g = config_.choices.separate_becomes == VofodChoices::SeparateBecomes::kFree ? config_.map.g_free
                                                                                            : config_.map.g_unknown;
  for (const Cell& cell : separate_) {
    if (map_.grid().contains(cell)) map_.update(map_.grid().index(cell), num_classifications, g);
  }
  separate_.clear();
}

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
