// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/detection/air_map.hpp"
#include "core/detection/beam_index.hpp"
#include "core/detection/hypothesis.hpp"
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

/// Free air and background learned from the sweeps: voxels that beams pass, and voxels in which returns that are not of
/// a target lie.
class LearnedAir {
 public:
  explicit LearnedAir(const TrackBeforeDetectConfig& config);

  /// Begins a sweep: centers the map on the sensor, and limits the number of beams that clear air.
  void begin_sweep(const LocalCloud& cloud, std::span<const Eigen::Vector3f> empty_lidar, const BeamIndex& beams);
  /// True where the background may have returned a beam.
  bool is_background(const Vector3& p_local_m) const { return map_.clutter_share(p_local_m) > background_share_; }
  /// True if enough beams passed the voxels around, and hardly any ended nearby. @param blur_m  error of the position
  bool is_free(const Vector3& p_local_m, double blur_m) const;
  /// Adds a return of the background. @param weight  probability that the return is background
  void hit(const Vector3& p_local_m, double weight) { map_.hit(p_local_m, weight / ray_stride_); }
  /// Queues a return. After learning_delay_s it counts as background by the probability that its hypothesis is then no
  /// target, so that a new target does not become background by its own returns. @param hypothesis  id; 0: none
  void queue_for_background(TimeNs t, const Eigen::Vector3f& p_local_m, std::uint32_t hypothesis,
                            std::span<const Hypothesis> all);
  /// Adds the returns whose delay is over.
  void learn(TimeNs t, std::span<const Hypothesis> all);
  /// Clears the air along every n-th beam, alternating between sweeps.
  void clear(const LocalCloud& cloud, std::span<const Eigen::Vector3f> empty_lidar, const BeamIndex& beams);

  const AirMap& map() const { return map_; }

 private:
  struct Pending {
    TimeNs t = 0;
    Eigen::Vector3f p_local_m;
    std::uint32_t hypothesis = 0;
  };

  void learn_oldest(std::span<const Hypothesis> all);
  void clear_beam(const Vector3& from_local_m, const Vector3& direction_local, double range_m, const BeamIndex& beams);

  double background_share_, free_share_, hit_share_;
  TimeNs learning_delay_;
  int rays_per_sweep_;
  AirMap map_;
  std::vector<Pending> pending_;  // ring buffer
  std::size_t first_pending_ = 0, num_pending_ = 0;
  int ray_stride_ = 1, ray_offset_ = 0;  // every n-th beam of a sweep clears air
};

}  // namespace swiftlet
