// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/detection/enclosure.hpp"
#include "core/detection/flying_cluster.hpp"
#include "core/detection/moved_things.hpp"
#include "core/detection/ray_caster.hpp"
#include "core/detection/samples.hpp"
#include "core/detection/separate_removal.hpp"
#include "core/detection/vicinity.hpp"
#include "swiftlet/core/base/detection.hpp"
#include "swiftlet/core/detection/clusterer.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"

namespace swiftlet {

/// Result of rules A to C. kTooLarge: not a flying object because of its size; seed of the background.
enum class ClusterClass : std::uint8_t { kBackground, kUnknown, kFlying, kTooLarge };

/// Stages of the VoFOD detector on one map, without a clock [Vrba 2025, sec. III-B to III-D]. Each processes a scan or
/// the map. A copy is expensive: it includes the map.
class VofodStages {
 public:
  explicit VofodStages(const VofodConfig& config);

  /// Clusters and classifies a scan, updates the map by its points, and appends its detections.
  void classify(const LocalCloud& cloud, std::vector<Detection>& detections);
  /// Casts the rays of a scan: lengths by voxel, stored for apply_rays().
  void cast_rays(const LocalCloud& cloud);
  /// Applies the rays to the map [Vrba 2025, eq. 22].
  /// @param num_classifications  N_cls: classifications since the cast
  void apply_rays(int num_classifications);
  /// Computes V_sep, stored for remove_separate(). Voxels are stored as cells: the map may scroll meanwhile.
  void find_separate();
  /// Removes V_sep [Vrba 2025, eq. 25].
  /// @param num_classifications  N_cls: classifications since the last removal
  void remove_separate(int num_classifications);
  /// Moves the voxel of a ground point measured by an altimeter half-way to occupied.
  void seed_ground(const Vector3& p_local_m);

  VoxelMap& map() { return map_; }
  const VoxelMap& map() const { return map_; }

  // Number of returns of all classified scans, and of those outside the map.
  std::uint64_t num_points() const { return num_points_; }
  std::uint64_t num_points_outside() const { return num_points_outside_; }

  // Number of clusters of the last classified scan, without those surrounded by background, which are not clustered.
  int num_clusters() const { return clusters_.size(); }
  void append_cluster_points(ClusterClass of_class, std::vector<Eigen::Vector3f>& points_local_m) const;

 private:
  using Members = std::span<const std::uint32_t>;

  void take_samples(const LocalCloud& cloud);

  // Rule A.
  void set_background_aside();
  bool is_near_background(const Eigen::Vector3f& at_local_m) const;
  bool is_background(Members members) const;
  bool is_in_free_air(Members members) const;
  void find_background();

  // Rules B and C.
  void find_flying(const LocalCloud& cloud, std::vector<Detection>& detections);
  bool rises_into_view(const LocalCloud& cloud, Members members, const MovedThings::Motion& motion) const;
  bool is_flying(const LocalCloud& cloud, Members members, const ClusterShape& shape, bool has_moved);
  SearchShape search_shape(const ClusterShape& shape) const;

  // Map update by points: the interpretations of the paper and of the released code.
  void classify_then_update(const LocalCloud& cloud, std::vector<Detection>& detections);
  void update_then_classify(const LocalCloud& cloud, std::vector<Detection>& detections);
  void put_aside();
  void put(Members members, double g);
  void set(Members members, double g);
  void set_large();
  template <class Visit>
  void for_each_cluster(ClusterClass of_class, Visit&& visit) const;

  VofodConfig config_;
  VoxelMap map_;
  bool large_is_background_;

  Samples samples_;                            // samples to cluster
  Samples aside_;                              // background samples that are not clustered
  std::vector<std::uint8_t> near_background_;  // flag of each sample
  Vicinity vicinity_;                          // vicinity of the samples that are not near background
  std::unique_ptr<Clusterer> clusterer_;
  Clusterer& clusters_ = *clusterer_;
  std::vector<ClusterClass> classes_;
  std::vector<std::uint8_t> in_free_air_;  // most points in voxels that were free before this scan, by cluster
  MovedThings things_;
  float lowest_z_ = 1.0F;  // sine of the elevation of the lowest beam
  EnclosureSearch search_;
  std::vector<std::ptrdiff_t> starts_index_;
  std::vector<Cell> starts_;

  RayCaster rays_;
  SeparateRemoval separate_;
  std::uint64_t num_points_ = 0, num_points_outside_ = 0;
};

}  // namespace swiftlet
