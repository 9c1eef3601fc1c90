// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/detection.hpp"
#include "swiftlet/core/detection/clusterer.hpp"
#include "swiftlet/core/detection/enclosure.hpp"
#include "swiftlet/core/detection/samples.hpp"
#include "swiftlet/core/detection/separate_background.hpp"
#include "swiftlet/core/detection/vicinity.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/ray_lengths.hpp"

namespace swiftlet {

/// Result of rules A to C. Too large: no flying object by its size, the seed of the background.
enum class ClusterClass : std::uint8_t { kBackground, kUnknown, kFlying, kTooLarge };

/// The stages of the VoFOD detector on one map, without a clock [Vrba 2025, sec. III-B to III-D]. Each does its work on
/// a scan or on the map. A copy is expensive: it holds the map.
class VofodStages {
 public:
  explicit VofodStages(const VofodConfig& config);

  /// Clustering and classification of a scan, its points into the map, and its detections.
  void classify(const LocalCloud& cloud, std::vector<Detection>& detections);
  /// Rays of a scan: lengths by voxel, kept for apply_rays().
  void cast_rays(const LocalCloud& cloud);
  /// Their effect on the map, eq. (22). @param num_classifications  N_cls, since the rays were cast
  void apply_rays(int num_classifications);
  /// V_sep as of now, kept for remove_separate(). Voxels are remembered by their cells: the map may scroll meanwhile.
  void find_separate();
  /// Eq. (25). @param num_classifications  N_cls, since the last removal
  void remove_separate(int num_classifications);
  /// The ground below an altimeter moves half-way to occupied.
  void seed_ground(const Vector3& p_local_m);

  VoxelMap& map() { return map_; }
  const VoxelMap& map() const { return map_; }
  const RayLengths& rays() const { return rays_; }

  // Returns of all classified scans, and those of them that lay outside the map.
  std::uint64_t num_points() const { return num_points_; }
  std::uint64_t num_points_outside() const { return num_points_outside_; }

  // Of the last classified scan.
  /// Without what is background all around, whose clusters nobody asks for.
  int num_clusters() const { return clusters_.size(); }
  void append_cluster_points(ClusterClass of_class, std::vector<Eigen::Vector3f>& points_local_m) const;

 private:
  using Members = std::span<const std::uint32_t>;

  void take_samples(const LocalCloud& cloud);

  // Rule A.
  void set_background_aside();
  bool is_near_background(const Eigen::Vector3f& at_local_m) const;
  bool is_background(Members members) const;
  void find_background();

  // Rules B and C.
  void find_flying(const LocalCloud& cloud, std::vector<Detection>& detections);
  bool is_flying(const LocalCloud& cloud, Members members, const ClusterShape& shape);
  SearchShape search_shape(const ClusterShape& shape) const;
  bool is_sufficient();

  // Points into the map: the interpretations of the paper and of the released code.
  void classify_then_update(const LocalCloud& cloud, std::vector<Detection>& detections);
  void update_then_classify(const LocalCloud& cloud, std::vector<Detection>& detections);
  void put_aside();
  void put(Members members, double g);
  void set(Members members, double g);
  void set_large();
  template <class Visit>
  void for_each_cluster(ClusterClass of_class, Visit&& visit) const;

  Detection make_detection(const LocalCloud& cloud, Members members, const ClusterShape& shape) const;
  double confidence() const;
  double reflectivity(const LocalCloud& cloud, Members members) const;
  Matrix3 covariance(const LocalCloud& cloud, std::uint32_t point, const Vector3& position_local_m) const;
  void append_spheres(std::span<const std::ptrdiff_t> centers, std::vector<Cell>& cells);

  VofodConfig config_;
  VoxelMap map_;
  bool large_is_background_;
  bool was_sufficient_ = false;
  float g_just_free_;  // the greatest value that is free

  Samples samples_;                            // what is clustered
  Samples aside_;                              // background without asking for its clusters
  std::vector<std::uint8_t> near_background_;  // by sample
  Vicinity vicinity_;                          // of the samples that are not
  std::unique_ptr<Clusterer> clusterer_;
  Clusterer& clusters_ = *clusterer_;
  std::vector<ClusterClass> classes_;
  EnclosureSearch search_;
  std::vector<std::ptrdiff_t> starts_index_, to_clear_;
  std::vector<Cell> starts_;

  RayLengths rays_;
  std::vector<Cell> hits_;  // voxels with a point since the last ray casting
  SeparateBackground separator_;
  std::vector<Cell> separate_;
  std::vector<std::ptrdiff_t> separate_index_;
  std::uint64_t num_points_ = 0, num_points_outside_ = 0;
};

}  // namespace swiftlet
