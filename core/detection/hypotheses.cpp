// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/hypotheses.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet {
namespace {

constexpr double kTarget = 0.5;           // existence probability from which a hypothesis counts as a target
constexpr double kLeastExistence = 1e-7;  // existence probability below which a hypothesis is dropped
constexpr double kGate = 16.0;            // gate of the squared Mahalanobis distance: 0.999 in three dimensions
constexpr double kGateMost_m = 8.0;       // largest Euclidean gate
// standard deviations of the attitude within which nearby background may have caused a return
constexpr double kReach_sigma = 2.5;
constexpr double kRateMemory = 0.95;      // factor of the weight of past returns in a target's return rate, per sweep
constexpr double kPriorShots = 20.0;      // weight of the expected share of returns, in beams
constexpr double kLeastDetection = 0.02;  // least probability of detection of an object that returned a beam
// correlated share of the variance of a single return: all returns come from the same side
constexpr double kSameSide = 0.1;
// least existence probability of a former target, which may be silent because it is hidden
constexpr double kSilentTarget = 0.1;
constexpr double kUnlikelyLost = 2.0;          // factor of sigma_lost_m for hypotheses that are no targets yet
constexpr double kSizeMemory = 0.998;          // factor by which the size of a body may shrink per sweep
constexpr double kSmallest_m = 0.04;           // size of a body whose returns all lie in one place
constexpr double kMostSize = 1.5;              // largest size of a body, as a multiple of body_m
constexpr std::size_t kMinReturnsToSplit = 6;  // fewest returns in a sweep that can split a body
constexpr double kNeverSmall = 1e-12;          // lower bound of the prior of a small object; keeps its log odds finite
constexpr std::size_t kMostCandidates = 4096;
constexpr std::size_t kMostPending = 16384;
constexpr double kMostVoxels = 1000.0;  // largest search radius in voxels; exceeds every map

Matrix7 Sigma_w_of(const ExpectedNoise& config) {
  MeasurementNoise noise;
  noise.sigma_range_m = config.sigma_range_m;
  noise.sigma_position_m.setConstant(config.sigma_position_m);
  noise.sigma_attitude_rad.setConstant(config.sigma_attitude_rad);
  return noise.Sigma_w();
}

// Constant velocity with white acceleration of spectral density q.
void predict_state(Hypothesis& h, double dt_s, double q) {
  h.mean.head<3>() += dt_s * h.mean.tail<3>();
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>() = dt_s * Matrix3::Identity();
  h.covariance = F * h.covariance * F.transpose();
  h.covariance.topLeftCorner<3, 3>() += q * dt_s * dt_s * dt_s / 3.0 * Matrix3::Identity();
  h.covariance.topRightCorner<3, 3>() += q * dt_s * dt_s / 2.0 * Matrix3::Identity();
  h.covariance.bottomLeftCorner<3, 3>() += q * dt_s * dt_s / 2.0 * Matrix3::Identity();
  h.covariance.bottomRightCorner<3, 3>() += q * dt_s * Matrix3::Identity();
}

Eigen::Matrix<double, 3, 6> position_at(double dt_s) {
  Eigen::Matrix<double, 3, 6> H;
  H << Matrix3::Identity(), dt_s * Matrix3::Identity();
  return H;
}

double normal_density(double distance_sq, const Matrix3& S) {
  const double two_pi = 2.0 * std::numbers::pi;
  return elementary::exp(-0.5 * distance_sq) / std::sqrt(two_pi * two_pi * two_pi * S.determinant());
}

}  // namespace

Hypotheses::Hypotheses(const TrackBeforeDetectConfig& config)
    : config_(config), Sigma_w_(Sigma_w_of(config.noise)), air_(config.air) {
  const double prior = std::max(config.target.small_prior, kNeverSmall);
  small_log_odds_ = elementary::log(prior / (1.0 - prior));
  const auto most = static_cast<std::size_t>(config.max_hypotheses);
  hypotheses_.reserve(2 * most);
  born_.reserve(most);
  hidden_.reserve(most);
  returns_of_.resize(most);
  candidates_.reserve(kMostCandidates);
  pending_.resize(kMostPending);
}

void Hypotheses::take(const LocalCloud& cloud) {
  beams_.assign(cloud);
  ray_stride_ = std::max(1, (cloud.scan->size() + config_.rays_per_sweep - 1) / config_.rays_per_sweep);
  air_.follow(beams_.p_local_lidar_m());
  predict();
  find_candidates(cloud);
  take_returns_of_targets(cloud);
  take_clusters(cloud);
  correct(cloud);
  join_parts(cloud);
  begin(cloud);
  inherit();
  merge();
  forget();
  learn(beams_.middle());
  clear_air(cloud);
}

void Hypotheses::predict() {
  for (Hypothesis& h : hypotheses_) {
    const double dt_s = to_seconds(beams_.middle() - h.t);
    predict_state(h, dt_s, config_.target.acceleration_density);
    h.t = beams_.middle();
    h.existence *= elementary::exp(-dt_s / config_.target.lifetime_s);
    h.sight.predict(dt_s, 1.0 / config_.target.seen_for_s, 1.0 / config_.target.hidden_for_s);
    h.num_returns = 0;
  }
  for (Hypothesis& h : hidden_) {
    const double dt_s = to_seconds(beams_.middle() - h.t);
    predict_state(h, dt_s, config_.target.acceleration_density);
    h.t = beams_.middle();
    h.existence *= elementary::exp(-dt_s / config_.target.lifetime_s);
  }
  exposures_.clear();
  for (const Hypothesis& h : hypotheses_) exposures_.push_back(exposure_of(h));
}

// Returns where background is expected become background at once; the others are candidates.
void Hypotheses::find_candidates(const LocalCloud& cloud) {
  candidates_.clear();
  const double limit = config_.background_share;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3 p_m = cloud.points_local_m[i].cast<double>();
    const double range_m = (p_m - beams_.p_local_lidar_m()).norm();
    if (air_.clutter_share(p_m) > limit || range_m > config_.max_range_m || candidates_.size() == kMostCandidates) {
      learn_hit(p_m, 1.0);
      continue;
    }
    const double blur_m = kReach_sigma * config_.noise.sigma_attitude_rad * range_m;
    const auto reach = [&](double reach_m) {
      return static_cast<int>(std::min(std::ceil(reach_m / air_.voxel_m()), kMostVoxels));
    };
    const int near = std::max(1, reach(blur_m)), far = reach(config_.free_reach_m + blur_m);
    const bool in_free_air = air_.is_free_around(p_m, near, config_.free_share) &&
                             !air_.is_hit_around(p_m, std::max(near, far), config_.hit_share);
    candidates_.push_back({cloud.points_local_m[i], static_cast<std::uint32_t>(i), in_free_air, false});
  }
}

// Each return goes to the nearest target, so that targets flying side by side stay apart.
void Hypotheses::take_returns_of_targets(const LocalCloud& cloud) {
  gate_information_.clear();
  spread_.clear();
  for (std::size_t k = 0; k < hypotheses_.size(); ++k) {
    returns_of_[k].clear();
    const Hypothesis& h = hypotheses_[k];
    const Matrix3 S =
        h.position_covariance() + pose_covariance(h.p_local_m()) + sampling_sq(h.size_m) * Matrix3::Identity();
    gate_information_.push_back(S.inverse());
    spread_.push_back(h.size_m > 0.0 ? 3.0 * elementary::log(sampling_sq(h.size_m) / sampling_sq(kSmallest_m)) : 0.0);
  }
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    double least = std::numeric_limits<double>::infinity();
    int nearest = -1;
    const Vector3 p_m = candidates_[c].p_local_m.cast<double>();
    const double dt_s = to_seconds(cloud.time_of(candidates_[c].point) - beams_.middle());
    for (std::size_t k = 0; k < hypotheses_.size(); ++k) {
      const Hypothesis& h = hypotheses_[k];
      if (h.existence < kTarget) break;  // the likeliest come first
      const Vector3 d_m = p_m - h.p_local_m() - dt_s * h.v_local_mps();
      if (d_m.squaredNorm() > kGateMost_m * kGateMost_m) continue;
      const double distance_sq = d_m.dot(gate_information_[k] * d_m);
      if (distance_sq >= kGate || distance_sq + spread_[k] >= least) continue;
      least = distance_sq + spread_[k];
      nearest = static_cast<int>(k);
    }
    if (nearest < 0) continue;
    returns_of_[static_cast<std::size_t>(nearest)].push_back(static_cast<std::uint32_t>(c));
    candidates_[c].taken = true;
  }
}

// Clusters the remaining candidates. Each hypothesis takes its most likely cluster, the more likely hypotheses first.
void Hypotheses::take_clusters(const LocalCloud& cloud) {
  loose_m_.clear();
  loose_.clear();
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    if (candidates_[c].taken) continue;
    loose_m_.push_back(candidates_[c].p_local_m);
    loose_.push_back(static_cast<std::uint32_t>(c));
  }
  clusters_.compute(loose_m_, config_.cluster_distance_m);
  cluster_taken_.assign(static_cast<std::size_t>(clusters_.size()), 0);
  for (std::size_t k = 0; k < hypotheses_.size(); ++k) {
    const Hypothesis& h = hypotheses_[k];
    if (h.existence >= kTarget) continue;
    double least = kGate;
    int nearest = -1;
    for (int cluster = 0; cluster < clusters_.size(); ++cluster) {
      if (cluster_taken_[static_cast<std::size_t>(cluster)]) continue;
      const std::uint32_t first = clusters_.members(cluster).front();
      const double dt_s = to_seconds(cloud.time_of(candidates_[loose_[first]].point) - beams_.middle());
      const Vector3 d_m = loose_m_[first].cast<double>() - h.p_local_m() - dt_s * h.v_local_mps();
      const double distance_sq = d_m.dot(gate_information_[k] * d_m);
      if (d_m.squaredNorm() > kGateMost_m * kGateMost_m || distance_sq >= least) continue;
      least = distance_sq;
      nearest = cluster;
    }
    if (nearest < 0) continue;
    cluster_taken_[static_cast<std::size_t>(nearest)] = 1;
    for (const std::uint32_t member : clusters_.members(nearest)) returns_of_[k].push_back(loose_[member]);
  }
}

void Hypotheses::correct(const LocalCloud& cloud) {
  for (std::size_t k = 0; k < hypotheses_.size(); ++k) {
    Hypothesis& h = hypotheses_[k];
    bool corrected = false;
    const double hidden = h.sight.hidden;
    if (!returns_of_[k].empty()) {
      const Measurement measurement = measurement_of(cloud, returns_of_[k], h.size_m);
      if (measurement.extent_m.norm() <= std::max(config_.target.max_size_m, 2.0 * h.size_m)) {
        corrected = correct_by(h, measurement, exposures_[k]);
      }
    }
    if (!corrected) miss(h, exposures_[k]);
    weigh_size(h, exposures_[k], hidden, corrected ? h.num_returns : 0);
    for (const std::uint32_t c : returns_of_[k]) {
      candidates_[c].taken = true;
      if (h.existence >= kTarget) continue;
      wait(candidates_[c], h.id);
    }
  }
}

void Hypotheses::weigh_size(Hypothesis& h, const BeamExposure& exposure, double hidden, int num_returns) {
  const ExpectedTarget& target = config_.target;
  const double range_m = (h.p_local_m() - beams_.p_local_lidar_m()).norm();
  if (target.small_prior <= 0.0 || range_m > target.small_within_m) return;
  h.small.weigh(num_returns, exposure.shots, hidden, target.small_share, target.least_share, target.return_variation);
}

// Integrated probabilistic data association with one measurement.
bool Hypotheses::correct_by(Hypothesis& h, const Measurement& measurement, const BeamExposure& exposure) {
  const Eigen::Matrix<double, 3, 6> H = position_at(to_seconds(measurement.t - h.t));
  const Vector3 innovation_m = measurement.p_local_m - H * h.mean;
  const Matrix3 S = H * h.covariance * H.transpose() + measurement.covariance;
  const double distance_sq = innovation_m.dot(S.llt().solve(innovation_m));
  if (!(distance_sq < kGate)) return false;
  const double none = h.rate.none(exposure.shots), some = std::max(1.0 - none, kLeastDetection);
  const double clutter = clutter_density_per_m3(measurement, exposure.beams_per_sr);
  const double of_target = some * normal_density(distance_sq, S) / clutter;
  const double likelihood_ratio = h.sight.weigh(none + of_target);
  h.existence = existence_after(h.existence, likelihood_ratio);

  const double weight = (1.0 - h.sight.hidden) * of_target / (none + of_target);
  const Eigen::Matrix<double, 6, 3> K = h.covariance * H.transpose() * S.inverse();
  const Vector6 correction = K * innovation_m;
  h.mean += weight * correction;
  h.covariance -= weight * K * S * K.transpose();
  h.covariance += weight * (1.0 - weight) * correction * correction.transpose();
  h.covariance = 0.5 * (h.covariance + h.covariance.transpose()).eval();
  keep(h, measurement);
  h.seen = h.t;
  ++h.num_sweeps;
  if (h.size_m > 0.0)
    h.size_m = std::clamp(h.extent_m.maxCoeff(), kSizeMemory * h.size_m, kMostSize * config_.target.body_m);
  if (h.existence >= kTarget) h.rate.update(measurement.num_returns, exposure.shots, kRateMemory);
  return true;
}

void Hypotheses::miss(Hypothesis& h, const BeamExposure& exposure) {
  h.existence = existence_after(h.existence, h.sight.weigh(h.rate.none(exposure.shots)));
}

// Each part of a large body begins its own hypothesis. Joins those whose returns show a single body.
void Hypotheses::join_parts(const LocalCloud& cloud) {
  parts_.begin_sweep();
  for (std::size_t k = 0; k < hypotheses_.size(); ++k) split_body(k);
  for (std::size_t i = 0; i < hypotheses_.size(); ++i) {
    for (std::size_t j = i + 1; j < hypotheses_.size(); ++j) {
      const Hypothesis &a = hypotheses_[i], &b = hypotheses_[j];
      if (a.existence < kTarget) break;
      if (!are_neighbors(i, j)) continue;
      places_of(i, part_a_m_);
      places_of(j, part_b_m_);
      const bool is_one = parts_.weigh(a.id, part_a_m_, b.id, part_b_m_);
      const bool is_inside = (a.p_local_m() - b.p_local_m()).norm() < 0.5 * std::max(a.size_m, b.size_m);
      if (!is_one && !is_inside) continue;
      const bool a_is_older = a.begun != b.begun ? a.begun < b.begun : a.id < b.id;
      join(cloud, a_is_older ? i : j, a_is_older ? j : i);
    }
  }
}

void Hypotheses::places_of(std::size_t k, std::vector<Vector3>& places_local_m) const {
  places_local_m.clear();
  for (const std::uint32_t c : returns_of_[k]) places_local_m.push_back(candidates_[c].p_local_m.cast<double>());
}

// True for two targets seen in this sweep that may be one body: no other target is nearer to both.
bool Hypotheses::are_neighbors(std::size_t i, std::size_t j) const {
  const auto apart_m = [&](std::size_t k, std::size_t l) {
    return (hypotheses_[k].p_local_m() - hypotheses_[l].p_local_m()).norm();
  };
  const auto is_seen = [&](std::size_t k) {
    return hypotheses_[k].existence >= kTarget && hypotheses_[k].num_returns > 0;
  };
  if (!is_seen(i) || !is_seen(j) || !(apart_m(i, j) < config_.target.body_m)) return false;
  for (std::size_t k = 0; k < hypotheses_.size(); ++k) {
    if (k == i || k == j || !is_seen(k)) continue;
    if (apart_m(k, i) < apart_m(i, j) && apart_m(k, j) < apart_m(i, j)) return false;
  }
  return true;
}

// Splits a large body when the air between its halves shows two: it returns to the usual size, and the other part
// begins a new hypothesis.
void Hypotheses::split_body(std::size_t k) {
  Hypothesis& h = hypotheses_[k];
  if (!(h.size_m > 0.0) || returns_of_[k].size() < kMinReturnsToSplit) return;
  places_of(k, part_a_m_);
  Vector3 mean_m = Vector3::Zero();
  for (const Vector3& p_m : part_a_m_) mean_m += p_m / static_cast<double>(part_a_m_.size());
  const auto farther = [&](const Vector3& a_m, const Vector3& b_m) {
    return (a_m - mean_m).squaredNorm() < (b_m - mean_m).squaredNorm();
  };
  const Vector3 axis_m = *std::max_element(part_a_m_.begin(), part_a_m_.end(), farther) - mean_m;
  part_b_m_.clear();
  for (const Vector3& p_m : part_a_m_) {
    if ((p_m - mean_m).dot(axis_m) > 0.0) part_b_m_.push_back(p_m);
  }
  std::erase_if(part_a_m_, [&](const Vector3& p_m) { return (p_m - mean_m).dot(axis_m) > 0.0; });
  if (part_a_m_.empty() || part_b_m_.empty()) return;
  parts_.weigh(h.id, part_a_m_, h.id, part_b_m_);
  if (parts_.log_odds(h.id, h.id) > -BodyParts::kSurest) return;
  h.size_m = 0.0;
  parts_.forget(h.id);
}

// Keeps the older hypothesis, with the mean of both states and the spread between them.
void Hypotheses::join(const LocalCloud& cloud, std::size_t stays, std::size_t goes) {
  Hypothesis &h = hypotheses_[stays], &other = hypotheses_[goes];
  const Vector6 difference = other.mean - h.mean;
  h.size_m = std::min(std::max({h.size_m, other.size_m, 2.0 * difference.head<3>().norm()}),
                      kMostSize * config_.target.body_m);
  h.mean += 0.5 * difference;
  h.covariance = 0.5 * (h.covariance + other.covariance) + 0.25 * difference * difference.transpose();
  h.existence = std::max(h.existence, other.existence);
  other.existence = 0.0;
  other.was_target = false;
  parts_.forget(other.id);
  parts_.forget(h.id);
  returns_of_[stays].insert(returns_of_[stays].end(), returns_of_[goes].begin(), returns_of_[goes].end());
  keep(h, measurement_of(cloud, returns_of_[stays], h.size_m));
}

// An unassigned cluster in free air may be a new target. All other candidates become background.
void Hypotheses::begin(const LocalCloud& cloud) {
  born_.clear();
  for (int cluster = 0; cluster < clusters_.size(); ++cluster) {
    if (cluster_taken_[static_cast<std::size_t>(cluster)]) continue;
    members_.clear();
    for (const std::uint32_t member : clusters_.members(cluster)) members_.push_back(loose_[member]);
    const Measurement m = measurement_of(cloud, members_, 0.0);
    const bool small = m.extent_m.norm() <= config_.target.max_size_m;
    if (!m.in_free_air || !small) {
      for (const std::uint32_t c : members_) wait(candidates_[c], 0);
      continue;
    }
    const bool beside_a_target = std::any_of(hypotheses_.begin(), hypotheses_.end(), [&](const Hypothesis& h) {
      return h.existence >= kTarget &&
             (h.p_local_m() - m.p_local_m).norm() < std::max(config_.cluster_distance_m, h.size_m);
    });
    if (beside_a_target || born_.size() == static_cast<std::size_t>(config_.max_hypotheses)) continue;

    Hypothesis h;
    h.id = h.identity = next_id_++;
    h.t = m.t;
    h.rate = {kPriorShots * config_.target.return_share, kPriorShots, config_.target.return_variation};
    h.small.log_odds = small_log_odds_;
    h.mean.head<3>() = m.p_local_m;
    h.covariance.setZero();
    h.covariance.topLeftCorner<3, 3>() = m.covariance;
    h.covariance.bottomRightCorner<3, 3>() =
        config_.target.sigma_velocity_mps * config_.target.sigma_velocity_mps * Matrix3::Identity();
    const BeamExposure exposure = exposure_of(h);
    const double come_back_per_m3 = remember(h, m);
    const double some = std::max(1.0 - h.rate.none(exposure.shots), kLeastDetection);
    const double of_target = (config_.target.birth_per_m3 + come_back_per_m3) * some;
    h.existence = of_target / (of_target + clutter_density_per_m3(m, exposure.beams_per_sr));
    keep(h, m);
    h.num_sweeps = 1;
    predict_state(h, to_seconds(beams_.middle() - h.t), config_.target.acceleration_density);
    h.t = h.begun = h.seen = beams_.middle();
    born_.push_back(h);
    for (const std::uint32_t c : members_) {
      wait(candidates_[c], h.id);
    }
  }
  num_born_ += born_.size();
  hypotheses_.insert(hypotheses_.end(), born_.begin(), born_.end());
}

// Associates a new hypothesis with a former target. Each former target without returns in this sweep may be here, by
// its existence and predicted position. The most likely one is weighed against all others and against new targets.
// Within the gate, the new hypothesis continues its state.
double Hypotheses::remember(Hypothesis& new_hypothesis, const Measurement& m) const {
  /// Match of one former target with the measurement.
  struct Meeting {
    const Hypothesis* of = nullptr;
    Vector3 off_m;
    Matrix3 S;
    double squared = 0.0, here_per_m3 = 0.0;
  };
  double sum_per_m3 = 0.0;
  Meeting likeliest;
  const auto weigh = [&](const Hypothesis& h) {
    if (!h.was_target || h.num_returns > 0) return;
    const Eigen::Matrix<double, 3, 6> H = position_at(to_seconds(m.t - h.t));
    Meeting meeting{&h, m.p_local_m - H * h.mean, H * h.covariance * H.transpose() + m.covariance};
    meeting.squared = meeting.off_m.dot(meeting.S.llt().solve(meeting.off_m));
    meeting.here_per_m3 = std::max(h.existence, kSilentTarget) * normal_density(meeting.squared, meeting.S);
    sum_per_m3 += meeting.here_per_m3;
    if (meeting.here_per_m3 > likeliest.here_per_m3) likeliest = meeting;
  };
  for (const Hypothesis& h : hypotheses_) weigh(h);
  for (const Hypothesis& h : hidden_) weigh(h);
  if (!(likeliest.here_per_m3 >= 0.5 * (sum_per_m3 + config_.target.strangers_per_m3))) return sum_per_m3;
  if (likeliest.of == nullptr) return sum_per_m3;
  const Hypothesis& h = *likeliest.of;
  new_hypothesis.former_identity = h.identity;
  new_hypothesis.rate = h.rate;
  new_hypothesis.small = h.small;
  new_hypothesis.size_m = h.size_m;
  if (!(likeliest.squared < kGate)) return sum_per_m3;
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>() = to_seconds(m.t - h.t) * Matrix3::Identity();
  const Matrix6 P = F * h.covariance * F.transpose();
  const Eigen::Matrix<double, 6, 3> K = P.leftCols<3>() * likeliest.S.inverse();
  new_hypothesis.mean = F * h.mean + K * likeliest.off_m;
  new_hypothesis.covariance = P - K * likeliest.S * K.transpose();
  return sum_per_m3;
}

// A new hypothesis that has become a target takes the identity of its former target, unless that was seen meanwhile.
void Hypotheses::inherit() {
  for (Hypothesis& successor : hypotheses_) {
    if (successor.existence < kTarget) continue;
    successor.was_target = true;
    if (successor.former_identity == 0) continue;
    const auto is_former = [&](const Hypothesis& h) { return h.identity == successor.former_identity; };
    const auto hidden = std::find_if(hidden_.begin(), hidden_.end(), is_former);
    const auto missed = std::find_if(hypotheses_.begin(), hypotheses_.end(), is_former);
    const bool is_missed = missed != hypotheses_.end() && missed->seen < successor.begun;
    const std::uint32_t identity =
        hidden != hidden_.end() || is_missed ? successor.former_identity : successor.identity;
    if (hidden != hidden_.end()) hidden_.erase(hidden);
    if (is_missed) {
      missed->existence = 0.0;
      missed->was_target = false;
    }
    for (Hypothesis& h : hypotheses_) {
      if (&h == &successor || h.former_identity == identity) h.former_identity = 0;
    }
    successor.identity = identity;
  }
}

// Removes duplicates: of two hypotheses at one place, the more likely one stays.
void Hypotheses::merge() {
  std::sort(hypotheses_.begin(), hypotheses_.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.existence != b.existence ? a.existence > b.existence : a.id < b.id;
  });
  for (std::size_t i = 0; i < hypotheses_.size(); ++i) {
    for (std::size_t j = i + 1; j < hypotheses_.size(); ++j) {
      Hypothesis& other = hypotheses_[j];
      const double same_m = (other.existence >= kTarget ? 0.25 : 0.75) * config_.cluster_distance_m;
      const Vector3 apart_m = other.p_local_m() - hypotheses_[i].p_local_m();
      if (apart_m.squaredNorm() >= same_m * same_m) continue;
      other.existence = 0.0;
      other.was_target = false;
    }
  }
}

void Hypotheses::forget() {
  std::erase_if(hypotheses_, [&](const Hypothesis& h) {
    const double lost_m = (h.existence >= kTarget ? 1.0 : kUnlikelyLost) * config_.sigma_lost_m;
    if (!h.mean.allFinite()) return true;
    if (h.existence >= kLeastExistence && h.position_covariance().diagonal().maxCoeff() <= lost_m * lost_m)
      return false;
    if (h.was_target && hidden_.size() < static_cast<std::size_t>(config_.max_hypotheses)) {
      hidden_.push_back(h);
      hidden_.back().num_returns = 0;
    }
    return true;
  });
  std::erase_if(hidden_, [&](const Hypothesis& h) {
    return !(h.position_covariance().diagonal().maxCoeff() <= config_.sigma_hidden_m * config_.sigma_hidden_m);
  });
  const auto most = static_cast<std::size_t>(config_.max_hypotheses);
  if (hypotheses_.size() <= most) return;
  num_dropped_ += hypotheses_.size() - most;
  hypotheses_.erase(hypotheses_.begin() + static_cast<std::ptrdiff_t>(most), hypotheses_.end());
}

// Delays learning, so that a target is not taken for background because of its own returns of earlier sweeps.
void Hypotheses::wait(const Candidate& candidate, std::uint32_t hypothesis) {
  if (num_pending_ == kMostPending) learn_oldest();
  pending_[(first_pending_ + num_pending_++) % kMostPending] = {beams_.middle(), candidate.p_local_m, hypothesis};
}

void Hypotheses::learn(TimeNs t) {
  const TimeNs before = t - from_seconds(config_.learning_delay_s);
  while (num_pending_ > 0 && pending_[first_pending_].t <= before) learn_oldest();
}

// Adds a return to the background by the probability that its hypothesis is no target.
void Hypotheses::learn_oldest() {
  const Pending& p = pending_[first_pending_];
  const auto h = std::find_if(hypotheses_.begin(), hypotheses_.end(),
                              [&](const Hypothesis& other) { return other.id == p.hypothesis; });
  learn_hit(p.p_local_m.cast<double>(), h == hypotheses_.end() ? 1.0 : 1.0 - h->existence);
  first_pending_ = (first_pending_ + 1) % kMostPending;
  --num_pending_;
}

// Clears the air along every n-th beam, alternating between sweeps. A ray ends one voxel before its return, for the
// noise of the pose; a ray without return ends before the nearest return around it.
void Hypotheses::clear_air(const LocalCloud& cloud) {
  const Scan& scan = *cloud.scan;
  const BeamTable& table = *scan.beams;
  ray_offset_ = (ray_offset_ + 1) % ray_stride_;
  for (int i = ray_offset_; i < scan.size(); i += ray_stride_) {
    if (!table.masked.empty() && table.masked[static_cast<std::size_t>(i)]) continue;
    const auto at = static_cast<std::size_t>(i);
    const Pose& T = cloud.T_local_lidar_of_beam(i);
    const Vector3 from_m = T * table.origins_lidar[at].cast<double>();
    const Vector3 direction = T.linear() * table.directions_lidar[at].cast<double>();
    const double range_m = scan.range_m[at], edge_m = air_.voxel_m();
    const double length_m = range_m > 0.0 ? std::min(range_m - edge_m, config_.ray_max_m)
                                          : std::min(beams_.nearest_return_m(direction) - edge_m, config_.empty_ray_m);
    if (length_m > 0.0) air_.pass(from_m, from_m + length_m * direction);
  }
}

Hypotheses::Measurement Hypotheses::measurement_of(const LocalCloud& cloud, std::span<const std::uint32_t> candidates,
                                                   double size_m) const {
  Measurement m;
  Vector3 sum_m = Vector3::Zero();
  Eigen::AlignedBox3d box;
  std::int64_t sum_ns = 0;
  m.in_free_air = true;
  for (const std::uint32_t c : candidates) {
    const Vector3 p_m = candidates_[c].p_local_m.cast<double>();
    sum_m += p_m;
    box.extend(p_m);
    m.in_free_air = m.in_free_air && candidates_[c].in_free_air;
    sum_ns += cloud.time_of(candidates_[c].point) - cloud.stamp();
    m.reflectivity = std::max(m.reflectivity, static_cast<double>(cloud.reflectivity_of(candidates_[c].point)));
  }
  const auto count = static_cast<double>(candidates.size());
  m.num_returns = static_cast<int>(candidates.size());
  m.t = cloud.stamp() + sum_ns / static_cast<std::int64_t>(candidates.size());
  m.extent_m = box.sizes();
  const Vector3 centroid_m = sum_m / count;
  const Vector3 from_lidar_m = centroid_m - beams_.p_local_lidar_m();
  m.p_local_m = centroid_m + config_.target.seen_side_m / std::max(from_lidar_m.norm(), 1e-3) * from_lidar_m;
  m.covariance = pose_covariance(centroid_m) + sampling_sq(size_m) * (1.0 / count + kSameSide) * Matrix3::Identity();
  return m;
}

void Hypotheses::keep(Hypothesis& h, const Measurement& m) {
  h.num_returns = m.num_returns;
  h.extent_m = m.extent_m;
  h.measured_local_m = m.p_local_m;
  h.measured_covariance = m.covariance;
  h.reflectivity = m.reflectivity;
}

/// Variance of single returns per axis. On a bar, returns spread with 0.29 of its length.
double Hypotheses::sampling_sq(double size_m) const {
  const double sigma_m = std::max(config_.target.sigma_sampling_m, 0.25 * size_m);
  return sigma_m * sigma_m;
}

/// J Sigma_w J^T [Vrba 2025, eq. 44].
Matrix3 Hypotheses::pose_covariance(const Vector3& p_local_m) const {
  const Vector3 p_lidar_m = beams_.R_local_lidar().transpose() * (p_local_m - beams_.p_local_lidar_m());
  const double range_m = std::max(p_lidar_m.norm(), 1e-3);
  return point_covariance(p_lidar_m / range_m, range_m, beams_.R_local_lidar(), Sigma_w_);
}

/// Density of voxels in which something other than a target returns a beam. Free air has little background.
double Hypotheses::clutter_density_per_m3(const Measurement& m, double beams_per_sr) const {
  const double edge_m = air_.voxel_m();
  const double range_sq = std::max((m.p_local_m - beams_.p_local_lidar_m()).squaredNorm(), edge_m * edge_m);
  const double beams = std::max(beams_per_sr * edge_m * edge_m / range_sq, 0.01);
  const double of_voxel = air_.clutter_share(m.p_local_m);
  const double share = m.in_free_air ? std::min(of_voxel, config_.free_air_share) : of_voxel;
  return (1.0 - elementary::exp(-share * beams)) / (edge_m * edge_m * edge_m);
}

BeamExposure Hypotheses::exposure_of(const Hypothesis& h) const {
  const double sigma_m = std::sqrt((h.position_covariance() + pose_covariance(h.p_local_m())).trace() / 3.0);
  return beams_.exposure({h.t, h.p_local_m(), h.v_local_mps(), sigma_m, config_.target.radius_m});
}

void Hypotheses::append_reported(std::vector<Detection>& detections) const {
  for (const Hypothesis& h : hypotheses_) {
    if (!is_reported(h)) continue;
    Detection d;
    d.t = h.t;
    d.position_m = h.p_local_m();
    d.covariance = h.position_covariance();
    d.extent_m = h.extent_m;
    d.num_points = h.num_returns;
    d.confidence = h.confidence();
    d.reflectivity = h.reflectivity;
    detections.push_back(d);
  }
}

void Hypotheses::append_reported(std::vector<Track>& tracks) const {
  for (const Hypothesis& h : hypotheses_) {
    if (!is_reported(h)) continue;
    Track track;
    track.id = h.identity;
    track.t = h.t;
    track.position_m = h.p_local_m();
    track.velocity_mps = h.v_local_mps();
    track.covariance.topLeftCorner<6, 6>() = h.covariance;
    track.num_detections = h.num_sweeps;
    track.corrected = h.num_returns > 0;
    track.measured_m = h.measured_local_m;
    track.measured_covariance = h.measured_covariance;
    track.reflectivity = h.reflectivity;
    tracks.push_back(track);
  }
}

void Hypotheses::append_counters(std::vector<Counter>& counters) const {
  counters.push_back({"hypotheses dropped because there were too many", num_dropped_, num_born_, "max_hypotheses"});
}

}  // namespace swiftlet
