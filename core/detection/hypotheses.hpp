// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/detection/air_map.hpp"
#include "core/detection/beam_index.hpp"
#include "core/detection/body_parts.hpp"
#include "core/detection/existence.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/detection.hpp"
#include "swiftlet/core/base/track.hpp"
#include "swiftlet/core/detection/euclidean_clusters.hpp"
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Hypothesis of a flying object: a Bernoulli component with a Gaussian state. Local frame.
struct Hypothesis {
  std::uint32_t id = 0;
  std::uint32_t identity = 0;         ///< reported id: the own id, or that of a reappeared target
  std::uint32_t former_identity = 0;  ///< identity of the hidden target that this one probably continues; 0: none
  TimeNs t = 0, begun = 0, seen = 0;  ///< times of the state, of the first and of the newest return
  double existence = 0.0;
  Vector6 mean = Vector6::Zero();  ///< position, velocity
  Matrix6 covariance = Matrix6::Identity();
  ReturnRate rate;
  Observability sight;
  Smallness small;
  int num_sweeps = 0;   ///< number of sweeps with returns of the target
  int num_returns = 0;  ///< returns in the newest sweep
  bool was_target = false;
  double size_m = 0.0;  ///< diameter of a body merged from parts; 0: not known to be large
  Vector3 extent_m = Vector3::Zero();
  Vector3 measured_local_m = Vector3::Zero();
  Matrix3 measured_covariance = Matrix3::Identity();
  double reflectivity = 0.0;

  /// Probability that a UAV is there: it exists, and is not too small.
  double confidence() const { return existence * (1.0 - small.probability()); }
  Vector3 p_local_m() const { return mean.head<3>(); }
  Vector3 v_local_mps() const { return mean.tail<3>(); }
  Matrix3 position_covariance() const { return covariance.topLeftCorner<3, 3>(); }
};

/// Track before detect: a bank of Bernoulli hypotheses, each tracked from its first return on. All sweeps together
/// decide about existence. Returns are weighed against the clutter expected there; beams that should have hit the
/// target and did not count as well. A target that is hidden, or out of the field of view, is dropped after a while. A
/// new hypothesis at a position within its reach continues its identity. Processes one sweep at a time, without
/// a clock. Time and memory are bounded.
class Hypotheses {
 public:
  explicit Hypotheses(const TrackBeforeDetectConfig& config);

  /// Processes one sweep: hypotheses, then background, then free air.
  void take(const LocalCloud& cloud);

  /// All hypotheses, the likeliest first.
  std::span<const Hypothesis> all() const { return hypotheses_; }
  /// Appends the hypotheses above the reporting threshold; detections and tracks in the same order.
  void append_reported(std::vector<Detection>& detections) const;
  void append_reported(std::vector<Track>& tracks) const;
  const AirMap& air() const { return air_; }
  void append_counters(std::vector<Counter>& counters) const;

 private:
  /// A return where the clutter share is low.
  struct Candidate {
    Eigen::Vector3f p_local_m;
    std::uint32_t point;  // index of the point in the cloud
    bool in_free_air;     // the voxels around are free air as well
    bool taken;
  };
  /// Returns assigned to one target.
  struct Measurement {
    Vector3 p_local_m = Vector3::Zero();
    Vector3 extent_m = Vector3::Zero();
    Matrix3 covariance = Matrix3::Identity();
    TimeNs t = 0;
    int num_returns = 0;
    double reflectivity = 0.0;
    bool in_free_air = false;
  };
  /// A candidate that becomes background after a delay, unless its hypothesis turns out to be a target.
  struct Pending {
    TimeNs t = 0;
    Eigen::Vector3f p_local_m;
    std::uint32_t hypothesis = 0;  // 0: none
  };

  void find_candidates(const LocalCloud& cloud);
  void predict();
  void take_returns_of_targets(const LocalCloud& cloud);
  void take_clusters(const LocalCloud& cloud);
  void correct(const LocalCloud& cloud);
  void weigh_size(Hypothesis& hypothesis, const BeamExposure& exposure, double hidden, int num_returns);
  bool correct_by(Hypothesis& hypothesis, const Measurement& measurement, const BeamExposure& exposure);
  void miss(Hypothesis& hypothesis, const BeamExposure& exposure);
  void join_parts(const LocalCloud& cloud);
  void places_of(std::size_t k, std::vector<Vector3>& places_local_m) const;
  bool are_neighbors(std::size_t i, std::size_t j) const;
  void split_body(std::size_t k);
  void join(const LocalCloud& cloud, std::size_t stays, std::size_t goes);
  void begin(const LocalCloud& cloud);
  double remember(Hypothesis& new_hypothesis, const Measurement& measurement) const;
  void inherit();
  void merge();
  void forget();
  void wait(const Candidate& candidate, std::uint32_t hypothesis);
  void learn(TimeNs t);
  void learn_oldest();
  /// All returns are added, weighted by the share of beams that clear air.
  void learn_hit(const Vector3& p_local_m, double weight) { air_.hit(p_local_m, weight / ray_stride_); }
  void clear_air(const LocalCloud& cloud);

  Measurement measurement_of(const LocalCloud& cloud, std::span<const std::uint32_t> candidates, double size_m) const;
  static void keep(Hypothesis& hypothesis, const Measurement& measurement);
  double sampling_sq(double size_m) const;
  Matrix3 pose_covariance(const Vector3& p_local_m) const;
  double clutter_density_per_m3(const Measurement& measurement, double beams_per_sr) const;
  BeamExposure exposure_of(const Hypothesis& hypothesis) const;
  bool is_reported(const Hypothesis& hypothesis) const { return hypothesis.confidence() >= config_.told_existence; }

  TrackBeforeDetectConfig config_;
  Eigen::Matrix<double, 7, 7> Sigma_w_;
  AirMap air_;
  BeamIndex beams_;
  BodyParts parts_;
  std::vector<Hypothesis> hypotheses_, born_;
  std::vector<Hypothesis> hidden_;  // dropped targets that may reappear
  double small_log_odds_ = 0.0;     // prior log odds of smallness of a new hypothesis
  std::uint32_t next_id_ = 1;
  std::vector<Pending> pending_;  // ring buffer
  std::size_t first_pending_ = 0, num_pending_ = 0;
  int ray_stride_ = 1, ray_offset_ = 0;  // every n-th beam of a sweep clears air
  std::uint64_t num_born_ = 0, num_dropped_ = 0;

  // Scratch memory of one sweep, reused.
  std::vector<Candidate> candidates_;
  std::vector<std::vector<std::uint32_t>> returns_of_;  // indices of candidates, by hypothesis
  std::vector<Vector3> part_a_m_, part_b_m_;
  std::vector<Eigen::Vector3f> loose_m_;
  std::vector<std::uint32_t> loose_, members_;
  std::vector<Matrix3> gate_information_;
  std::vector<double> spread_;  // log of the ratio of determinants: returns of a large body spread wider
  EuclideanClusters clusters_;
  std::vector<char> cluster_taken_;
  std::vector<BeamExposure> exposures_;
};

}  // namespace swiftlet
