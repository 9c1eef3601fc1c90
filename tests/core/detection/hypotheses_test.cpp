// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/hypotheses.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"
#include "tests/core/detection/detection_support.hpp"

namespace swiftlet {
namespace {

using namespace testing;
constexpr TimeNs kSweep = 100'000'000;

/// The same written out plainly, as docs/detection.md tells it. The map of the air and the beams by direction have
/// tests of their own.
class PlainHypotheses {
 public:
  explicit PlainHypotheses(const TrackBeforeDetectConfig& config) : config_(config), air(config.air) {}

  struct Guess {
    std::uint32_t id = 0, identity = 0, heir_of = 0;
    TimeNs begun = 0, seen = 0;
    bool was_target = false;
    double existence = 0.0, hidden = 0.0;  // the latter if it exists
    double small = 0.05;                   // probability that it is too small
    Vector6 mean = Vector6::Zero();
    Matrix6 covariance = Matrix6::Zero();
    ReturnRate rate;
    double size_m = 0.0;
    int num_sweeps = 1, num_returns = 0;
    Vector3 extent_m = Vector3::Zero(), measured_m = Vector3::Zero();
    Matrix3 measured_covariance = Matrix3::Identity();
    double reflectivity = 0.0;
    BeamExposure exposure;
    std::vector<std::size_t> own;  // returns

    bool is_target() const { return existence >= 0.5; }
    Vector3 p_m() const { return mean.head<3>(); }
    Matrix3 P() const { return covariance.topLeftCorner<3, 3>(); }
  };

  void take(const LocalCloud& cloud) {
    beams_.assign(cloud);
    const TimeNs before = now_;
    now_ = beams_.middle();
    sensor_m_ = beams_.p_local_lidar_m();
    stride_ = (cloud.scan->size() + config_.rays_per_sweep - 1) / config_.rays_per_sweep;
    air.follow(sensor_m_);
    for (Guess& g : guesses) {
      move(g, to_seconds(now_ - before));
      g.existence *= std::exp(-to_seconds(now_ - before) / config_.target.lifetime_s);
      const double steps_s = to_seconds(now_ - before), to_hidden = 1.0 / config_.target.seen_for_s;
      const double to_seen = 1.0 / config_.target.hidden_for_s, left = std::exp(-(to_hidden + to_seen) * steps_s);
      g.hidden = g.hidden * left + to_hidden / (to_hidden + to_seen) * (1.0 - left);
      g.num_returns = 0;
      g.exposure = exposure(g);
      g.own.clear();
    }
    for (Guess& g : hidden) {
      move(g, to_seconds(now_ - before));
      g.existence *= std::exp(-to_seconds(now_ - before) / config_.target.lifetime_s);
    }
    sort_returns(cloud);
    give_to_targets();
    give_clusters();
    for (Guess& g : guesses) judge(g);
    put_together();
    const std::size_t old = guesses.size();
    bear(old);
    num_born += guesses.size() - old;
    bequeath();
    keep_best();
    while (!waiting_.empty() && waiting_.front().since <= now_ - from_seconds(config_.learning_delay_s)) {
      const Waiting first = waiting_.front();
      waiting_.erase(waiting_.begin());
      double background = 1.0;
      for (const Guess& g : guesses) background = g.id == first.of ? 1.0 - g.existence : background;
      air.hit(first.p_m, background / stride_);
    }
    clear(cloud);
  }

  std::vector<Guess> guesses, hidden;
  int num_heirs = 0, num_joined = 0, num_parted = 0;
  std::size_t num_born = 0, num_dropped = 0;

 private:
  struct Return {
    Vector3 p_m;
    TimeNs t;
    double reflectivity;
    bool in_free_air, taken = false;
  };
  struct Waiting {
    TimeNs since;
    Vector3 p_m;
    std::uint32_t of;
  };
  /// That two are one body.
  struct Evidence {
    double of_one = 1.0;  // likelihood ratio
    int silent = 0;       // sweeps since
  };
  struct Measured {
    Vector3 p_m, extent_m;
    Matrix3 R;
    TimeNs t;
    double reflectivity;
    bool in_free_air;
  };

  void move(Guess& g, double dt_s) const {
    Matrix6 F = Matrix6::Identity(), Q;
    const double q = config_.target.acceleration_density;
    for (int a = 0; a < 3; ++a) F(a, a + 3) = dt_s;
    const Matrix3 I = Matrix3::Identity();
    Q << q * std::pow(dt_s, 3) / 3.0 * I, q * dt_s * dt_s / 2.0 * I, q * dt_s * dt_s / 2.0 * I, q * dt_s * I;
    g.mean = F * g.mean;
    g.covariance = F * g.covariance * F.transpose() + Q;
  }

  Matrix3 of_pose(const Vector3& p_m) const {
    MeasurementNoise noise;
    noise.sigma_range_m = config_.noise.sigma_range_m;
    noise.sigma_position_m.setConstant(config_.noise.sigma_position_m);
    noise.sigma_attitude_rad.setConstant(config_.noise.sigma_attitude_rad);
    const Vector3 way_m = beams_.R_local_lidar().inverse() * (p_m - sensor_m_);
    return point_covariance(way_m.normalized(), way_m.norm(), beams_.R_local_lidar(), noise.Sigma_w());
  }
  double sampling_sq(const Guess& g) const {
    return std::max(std::pow(config_.target.sigma_sampling_m, 2), g.size_m * g.size_m / 16.0);
  }

  BeamExposure exposure(const Guess& g, TimeNs t) const {
    const double sigma_m = std::sqrt((g.P() + of_pose(g.p_m())).trace() / 3.0);
    return beams_.exposure({t, g.p_m(), g.mean.tail<3>(), sigma_m, config_.target.radius_m});
  }
  BeamExposure exposure(const Guess& g) const { return exposure(g, now_); }

  double clutter(const Measured& of, double beams_per_sr) const {
    const Vector3& p_m = of.p_m;
    double share = air.clutter_share(p_m);
    if (of.in_free_air && share > config_.free_air_share) share = config_.free_air_share;
    const double edge_m = config_.air.voxel_m, range_m = std::max((p_m - sensor_m_).norm(), edge_m);
    const double beams = std::max(beams_per_sr * edge_m * edge_m / (range_m * range_m), 0.01);
    return (1.0 - std::exp(-beams * share)) / std::pow(edge_m, 3);
  }

  void sort_returns(const LocalCloud& cloud) {
    returns_.clear();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Vector3 p_m = cloud.points_local_m[i].cast<double>();
      const double range_m = (p_m - sensor_m_).norm();
      if (air.clutter_share(p_m) > config_.background_share || range_m > config_.max_range_m) {
        air.hit(p_m, 1.0 / stride_);
        continue;
      }
      const double edge_m = config_.air.voxel_m, blur_m = 2.5 * config_.noise.sigma_attitude_rad * range_m;
      const int near = std::max(static_cast<int>(std::ceil(blur_m / edge_m)), 1);
      const int far = static_cast<int>(std::ceil((blur_m + config_.free_reach_m) / edge_m));
      const bool free = air.is_free_around(p_m, near, config_.free_share) &&
                        !air.is_hit_around(p_m, std::max(far, near), config_.hit_share);
      returns_.push_back({p_m, cloud.time_of(i), cloud.reflectivity_of(i), free});
    }
  }

  /// Squared statistical distance of a return, infinite beyond 8 m.
  double distance_sq(const Guess& g, const Return& r) const {
    const Vector3 d_m = r.p_m - g.p_m() - to_seconds(r.t - now_) * g.mean.tail<3>();
    const Matrix3 S = g.P() + of_pose(g.p_m()) + sampling_sq(g) * Matrix3::Identity();
    return d_m.norm() > 8.0 ? INFINITY : d_m.dot(S.inverse() * d_m);
  }

  void give_to_targets() {
    // Minus twice the logarithm of the density of its returns, of which those of a large body lie wider.
    const auto unlikely = [&](const Guess& g, const Return& r) {
      return distance_sq(g, r) + 3.0 * std::log(sampling_sq(g) / sampling_sq(Guess()));
    };
    for (std::size_t i = 0; i < returns_.size(); ++i) {
      Guess* nearest = nullptr;
      for (Guess& g : guesses) {
        if (!g.is_target() || distance_sq(g, returns_[i]) >= 16.0) continue;
        if (nearest == nullptr || unlikely(g, returns_[i]) < unlikely(*nearest, returns_[i])) nearest = &g;
      }
      if (nearest == nullptr) continue;
      nearest->own.push_back(i);
      returns_[i].taken = true;
    }
  }

  void give_clusters() {
    clusters_.clear();
    const double near_m = config_.cluster_distance_m;
    std::vector<char> joined(returns_.size(), 0);
    for (std::size_t i = 0; i < returns_.size(); ++i) {
      if (returns_[i].taken || joined[i]) continue;
      std::vector<std::size_t> cluster = {i};
      joined[i] = 1;
      for (std::size_t k = 0; k < cluster.size(); ++k) {
        for (std::size_t j = 0; j < returns_.size(); ++j) {
          if (returns_[j].taken || joined[j] || (returns_[j].p_m - returns_[cluster[k]].p_m).norm() > near_m) continue;
          joined[j] = 1;
          cluster.push_back(j);
        }
      }
      std::sort(cluster.begin(), cluster.end());
      clusters_.push_back(cluster);
    }
    for (Guess& g : guesses) {
      if (g.is_target()) continue;
      auto nearest = clusters_.end();
      double least = 16.0;
      for (auto cluster = clusters_.begin(); cluster != clusters_.end(); ++cluster) {
        const double d_sq = distance_sq(g, returns_[cluster->front()]);
        if (d_sq < least) nearest = cluster, least = d_sq;
      }
      if (nearest == clusters_.end()) continue;
      g.own = *nearest;
      clusters_.erase(nearest);
    }
  }

  Measured measured(const std::vector<std::size_t>& own, const Guess& by) const {
    Measured m;
    Vector3 sum_m = Vector3::Zero(), low_m = returns_[own[0]].p_m, high_m = low_m;
    TimeNs sum = 0;
    m.reflectivity = 0.0;
    m.in_free_air = std::all_of(own.begin(), own.end(), [&](auto i) { return returns_[i].in_free_air; });
    for (const std::size_t i : own) {
      sum_m += returns_[i].p_m;
      low_m = low_m.cwiseMin(returns_[i].p_m);
      high_m = high_m.cwiseMax(returns_[i].p_m);
      sum += returns_[i].t - beams_.stamp();
      m.reflectivity = std::max(m.reflectivity, returns_[i].reflectivity);
    }
    const auto count = static_cast<double>(own.size());
    const Vector3 mean_m = sum_m / count;
    m.t = beams_.stamp() + sum / static_cast<TimeNs>(own.size());
    m.extent_m = high_m - low_m;
    m.p_m = mean_m + config_.target.seen_side_m * (mean_m - sensor_m_).normalized();
    m.R = of_pose(mean_m) + sampling_sq(by) * (1.0 / count + 0.1) * Matrix3::Identity();
    return m;
  }

  void judge(Guess& g) {
    const double hidden_before = g.hidden;
    const bool seen = !g.own.empty() && corrected(g, measured(g.own, g));
    const bool near = (g.p_m() - sensor_m_).norm() <= config_.target.small_within_m;
    if (!seen) bayes(g, g.rate.none(g.exposure.shots));
    // The number of returns is negative binomial; what does not depend on the share cancels.
    const auto likelihood = [&](double share) {
      const double r = config_.target.return_variation, mean = share * g.exposure.shots;
      const double none = std::pow(r / (r + mean), r);
      if (!seen) return hidden_before + (1.0 - hidden_before) * none;
      return none * std::pow(mean / (r + mean), g.num_returns);
    };
    const double if_small = g.small * likelihood(config_.target.small_share);
    const double if_uav = (1.0 - g.small) * likelihood(config_.target.least_share);
    if (near)
      g.small = std::clamp(if_small / (if_small + if_uav), 1.0 / (1.0 + std::exp(6.0)), 1.0 / (1.0 + std::exp(-6.0)));
    for (const std::size_t i : g.own) {
      returns_[i].taken = true;
      if (!g.is_target()) waiting_.push_back({now_, returns_[i].p_m, g.id});
    }
  }

  /// Three cases: it does not exist, it is hidden, it can be seen. @param if_seen  likelihood ratio of the last one
  static void bayes(Guess& g, double if_seen) {
    const double not_there = 1.0 - g.existence, behind = g.existence * g.hidden;
    const double seen = (g.existence - behind) * if_seen;
    g.existence = (behind + seen) / (not_there + behind + seen);
    g.hidden = behind / (behind + seen);
  }

  /// With its probability the measurement is the target's; without, all stays as it was.
  bool corrected(Guess& g, const Measured& m) const {
    Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Identity();
    for (int a = 0; a < 3; ++a) H(a, a + 3) = to_seconds(m.t - now_);
    const Matrix3 S = H * g.covariance * H.transpose() + m.R;
    const Vector3 off_m = m.p_m - H * g.mean;
    const double d_sq = off_m.dot(S.inverse() * off_m);
    if (m.extent_m.norm() > std::max(config_.target.max_size_m, 2.0 * g.size_m) || d_sq >= 16.0) return false;
    const double density = std::exp(-d_sq / 2.0) / std::sqrt((2.0 * std::numbers::pi * S).determinant());
    const double none = g.rate.none(g.exposure.shots);
    const double of_target = std::max(1.0 - none, 0.02) * density / clutter(m, g.exposure.beams_per_sr);
    bayes(g, none + of_target);
    const double is_its = (1.0 - g.hidden) * of_target / (none + of_target);
    const Eigen::Matrix<double, 6, 3> K = g.covariance * H.transpose() * S.inverse();
    const Vector6 with = g.mean + K * off_m, mean = is_its * with + (1.0 - is_its) * g.mean;
    const Matrix6 P_with = (Matrix6::Identity() - K * H) * g.covariance;
    g.covariance = is_its * (P_with + (with - mean) * (with - mean).transpose()) +
                   (1.0 - is_its) * (g.covariance + (g.mean - mean) * (g.mean - mean).transpose());
    g.mean = mean;
    tell(g, m);
    g.seen = now_;
    ++g.num_sweeps;
    if (g.size_m > 0.0) {
      g.size_m = std::min(std::max(g.extent_m.maxCoeff(), 0.998 * g.size_m), 1.5 * config_.target.body_m);
    }
    if (g.is_target()) g.rate.update(g.num_returns, g.exposure.shots, 0.95);
    return true;
  }

  static void tell(Guess& g, const Measured& m) {
    g.num_returns = static_cast<int>(g.own.size());
    g.extent_m = m.extent_m;
    g.measured_m = m.p_m;
    g.measured_covariance = m.R;
    g.reflectivity = m.reflectivity;
  }

  /// One body is as likely as two at first. One has 17 returns of 100 in the middle third, two have 2. Who lies inside
  /// of a body is of it.
  void put_together() {
    for (auto& [pair, evidence] : together_) ++evidence.silent;
    std::erase_if(together_, [](const auto& item) { return item.second.silent > 50; });
    for (Guess& g : guesses) take_apart(g);
    for (std::size_t i = 0; i < guesses.size(); ++i) {
      for (std::size_t j = i + 1; j < guesses.size(); ++j) {
        Guess &a = guesses[i], &b = guesses[j];
        if (!a.is_target() || !b.is_target() || a.num_returns == 0 || b.num_returns == 0) continue;
        const double apart_m = (a.p_m() - b.p_m()).norm();
        if (apart_m >= config_.target.body_m) continue;
        bool third_between = false;
        for (const Guess& g : guesses) {
          third_between =
              third_between || (g.is_target() && g.num_returns > 0 && (g.p_m() - a.p_m()).norm() < apart_m &&
                                (g.p_m() - b.p_m()).norm() < apart_m && g.id != a.id && g.id != b.id);
        }
        if (third_between) continue;
        Evidence& evidence = together_[std::minmax(a.id, b.id)];
        evidence.silent = 0;
        const bool inside = 2.0 * apart_m < std::max(a.size_m, b.size_m);
        const bool enough = a.own.size() + b.own.size() >= 3;
        const double ratio = enough ? likelihood_ratio(a.own, b.own) : 1.0;
        evidence.of_one = std::clamp(evidence.of_one * ratio, std::exp(-6.0), std::exp(6.0));
        if ((evidence.of_one <= std::exp(3.0) || !enough) && !inside) continue;
        Guess &older = a.begun < b.begun || (a.begun == b.begun && a.id < b.id) ? a : b, &other = &older == &a ? b : a;
        const Vector6 mean = 0.5 * (a.mean + b.mean);
        older.covariance = 0.5 * (a.covariance + (a.mean - mean) * (a.mean - mean).transpose() + b.covariance +
                                  (b.mean - mean) * (b.mean - mean).transpose());
        const double across_m = 2.0 * (a.p_m() - b.p_m()).norm();
        older.size_m = std::min(std::max(across_m, std::max(a.size_m, b.size_m)), 1.5 * config_.target.body_m);
        older.mean = mean;
        older.existence = std::max(a.existence, b.existence);
        other.existence = 0.0;
        other.was_target = false;
        older.own.insert(older.own.end(), other.own.begin(), other.own.end());
        tell(older, measured(older.own, older));
        std::erase_if(together_, [&](const auto& item) {
          const auto& [low, high] = item.first;
          return low == a.id || high == a.id || low == b.id || high == b.id;
        });
        ++num_joined;
      }
    }
  }

  /// The halves of a large body, by a plane through the mean of its returns and across the way to the farthest one.
  void take_apart(Guess& g) {
    if (g.size_m <= 0.0 || g.own.size() < 6) return;
    const Vector3 at_m = middle(g.own);
    Vector3 farthest_m = at_m;
    for (const std::size_t i : g.own) {
      if ((returns_[i].p_m - at_m).norm() > (farthest_m - at_m).norm()) farthest_m = returns_[i].p_m;
    }
    std::vector<std::size_t> near, far;
    for (const std::size_t i : g.own) {
      ((returns_[i].p_m - at_m).dot(farthest_m - at_m) > 0.0 ? far : near).push_back(i);
    }
    if (near.empty() || far.empty()) return;
    Evidence& evidence = together_[{g.id, g.id}];
    evidence.silent = 0;
    evidence.of_one = std::clamp(evidence.of_one * likelihood_ratio(near, far), std::exp(-6.0), std::exp(6.0));
    if (evidence.of_one > std::exp(-6.0) * (1.0 + 1e-9)) return;
    g.size_m = 0.0;
    ++num_parted;
    std::erase_if(together_, [&](const auto& item) { return item.first.first == g.id || item.first.second == g.id; });
  }

  double likelihood_ratio(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) const {
    const Vector3 from_m = middle(a), to_m = middle(b);
    const double length_m = (to_m - from_m).norm();
    double ratio = 1.0;
    for (const auto* half : {&a, &b}) {
      for (const std::size_t r : *half) {
        const double at_m = (returns_[r].p_m - from_m).dot((to_m - from_m).normalized());
        ratio *= at_m > length_m / 3.0 && at_m < 2.0 * length_m / 3.0 ? 0.17 / 0.02 : 0.83 / 0.98;
      }
    }
    return ratio;
  }

  Vector3 middle(const std::vector<std::size_t>& own) const {
    Vector3 sum_m = Vector3::Zero();
    for (const std::size_t i : own) sum_m += returns_[i].p_m;
    return sum_m / static_cast<double>(own.size());
  }

  void bear(std::size_t num_old) {
    for (const std::vector<std::size_t>& cluster : clusters_) {
      const Measured m = measured(cluster, Guess());
      if (!m.in_free_air || m.extent_m.norm() > config_.target.max_size_m) {
        for (const std::size_t i : cluster) waiting_.push_back({now_, returns_[i].p_m, 0});
        continue;
      }
      const bool beside =
          std::any_of(guesses.begin(), guesses.begin() + static_cast<std::ptrdiff_t>(num_old), [&](auto& g) {
            return g.is_target() && (g.p_m() - m.p_m).norm() < std::max(config_.cluster_distance_m, g.size_m);
          });
      if (beside || guesses.size() - num_old == static_cast<std::size_t>(config_.max_hypotheses)) continue;
      Guess g;
      g.id = g.identity = next_id_++;
      g.begun = g.seen = now_;
      g.own = cluster;
      g.rate = {20.0 * config_.target.return_share, 20.0, config_.target.return_variation};
      g.mean.head<3>() = m.p_m;
      g.covariance.diagonal().tail<3>().setConstant(std::pow(config_.target.sigma_velocity_mps, 2));
      g.covariance.topLeftCorner<3, 3>() = m.R;
      const BeamExposure seen = exposure(g, m.t);
      const double known = come_back(g, m, num_old);
      const double some = std::max(1.0 - g.rate.none(seen.shots), 0.02);
      const double of_target = (config_.target.birth_per_m3 + known) * some;
      g.existence = of_target / (of_target + clutter(m, seen.beams_per_sr));
      tell(g, m);
      move(g, to_seconds(now_ - m.t));
      guesses.push_back(g);
      for (const std::size_t i : cluster) waiting_.push_back({now_, returns_[i].p_m, g.id});
    }
  }

  /// Density of the targets that nothing was seen of now, where something was. The newborn is the likeliest of them
  /// when that is likelier than all else together.
  double come_back(Guess& newborn, const Measured& m, std::size_t num_old) const {
    std::vector<std::pair<double, const Guess*>> all;
    for (std::size_t k = 0; k < num_old; ++k) {
      if (guesses[k].was_target && guesses[k].num_returns == 0) all.push_back({0.0, &guesses[k]});
    }
    for (const Guess& g : hidden) all.push_back({0.0, &g});
    double sum = 0.0;
    for (auto& [density, g] : all) {
      Guess at = *g;
      shift(at, to_seconds(m.t - now_));
      const Matrix3 S = at.P() + m.R;
      const Vector3 off_m = m.p_m - at.p_m();
      density = std::max(g->existence, 0.1) * std::exp(-0.5 * off_m.dot(S.inverse() * off_m)) /
                std::sqrt((2.0 * std::numbers::pi * S).determinant());
      sum += density;
    }
    for (const auto& [density, g] : all) {
      if (density < 0.5 * (sum + config_.target.strangers_per_m3)) continue;
      newborn.heir_of = g->identity;
      newborn.rate = g->rate;
      newborn.small = g->small;
      newborn.size_m = g->size_m;
      Guess at = *g;
      shift(at, to_seconds(m.t - now_));
      const Matrix3 S = at.P() + m.R;
      const Vector3 off_m = m.p_m - at.p_m();
      if (off_m.dot(S.inverse() * off_m) >= 16.0) continue;
      const Eigen::Matrix<double, 6, 3> K = at.covariance.leftCols<3>() * S.inverse();
      Matrix6 keeps = Matrix6::Identity();
      keeps.leftCols<3>() -= K;
      newborn.mean = at.mean + K * off_m;
      newborn.covariance = keeps * at.covariance;
    }
    return sum;
  }

  /// To a time so near that nothing pushes it meanwhile.
  static void shift(Guess& g, double dt_s) {
    Matrix6 F = Matrix6::Identity();
    for (int a = 0; a < 3; ++a) F(a, a + 3) = dt_s;
    g.mean = F * g.mean;
    g.covariance = F * g.covariance * F.transpose();
  }

  void bequeath() {
    for (Guess& heir : guesses) {
      if (!heir.is_target()) continue;
      heir.was_target = true;
      const std::uint32_t wanted = heir.heir_of;
      heir.heir_of = 0;
      if (wanted == 0) continue;
      bool free = false;
      for (Guess& g : guesses) {
        if (g.identity != wanted || g.seen >= heir.begun) continue;
        g.existence = 0.0;
        g.was_target = false;
        free = true;
      }
      free = std::erase_if(hidden, [&](const Guess& g) { return g.identity == wanted; }) > 0 || free;
      if (free) heir.identity = wanted;
      num_heirs += free;
      for (Guess& g : guesses) {
        if (g.heir_of == heir.identity) g.heir_of = 0;
      }
    }
  }

  void keep_best() {
    std::sort(guesses.begin(), guesses.end(), [](const Guess& a, const Guess& b) {
      return a.existence > b.existence || (a.existence == b.existence && a.id < b.id);
    });
    for (std::size_t j = 1; j < guesses.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        const double same_m = (guesses[j].is_target() ? 0.25 : 0.75) * config_.cluster_distance_m;
        if ((guesses[i].p_m() - guesses[j].p_m()).norm() >= same_m) continue;
        guesses[j].existence = 0.0;
        guesses[j].was_target = false;
      }
    }
    std::erase_if(guesses, [&](const Guess& g) {
      const double lost_m = config_.sigma_lost_m * (g.is_target() ? 1.0 : 2.0);
      if (g.existence >= 1e-7 && std::sqrt(g.P().diagonal().maxCoeff()) <= lost_m) return false;
      if (g.was_target && hidden.size() < static_cast<std::size_t>(config_.max_hypotheses)) {
        hidden.push_back(g);
        hidden.back().num_returns = 0;
      }
      return true;
    });
    std::erase_if(hidden,
                  [&](const Guess& g) { return std::sqrt(g.P().diagonal().maxCoeff()) > config_.sigma_hidden_m; });
    const auto most = static_cast<std::size_t>(config_.max_hypotheses);
    if (guesses.size() <= most) return;
    num_dropped += guesses.size() - most;
    guesses.resize(most);
  }

  void clear(const LocalCloud& cloud) {
    const Scan& scan = *cloud.scan;
    first_ray_ = (first_ray_ + 1) % stride_;
    for (int i = 0; i < scan.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (i % stride_ != first_ray_ || (!scan.beams->masked.empty() && scan.beams->masked[at] != 0)) continue;
      const Pose& T = cloud.T_local_lidar_of_beam(i);
      const Vector3 from_m = T * scan.beams->origins_lidar[at].cast<double>();
      const Vector3 direction = T.linear() * scan.beams->directions_lidar[at].cast<double>();
      const double ended_m = scan.hit(i) ? static_cast<double>(scan.range_m[at]) : beams_.nearest_return_m(direction);
      const double most_m = scan.hit(i) ? config_.ray_max_m : config_.empty_ray_m;
      const double length_m = std::min(ended_m - config_.air.voxel_m, most_m);
      if (length_m <= 0.0) continue;
      air.pass(from_m, from_m + length_m * direction);
    }
  }

  TrackBeforeDetectConfig config_;
  BeamIndex beams_;
  TimeNs now_ = 0;
  Vector3 sensor_m_ = Vector3::Zero();
  int stride_ = 1, first_ray_ = 0;
  std::uint32_t next_id_ = 1;
  std::vector<Return> returns_;
  std::vector<std::vector<std::size_t>> clusters_;
  std::vector<Waiting> waiting_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Evidence> together_;

 public:
  AirMap air;
};

/// Things in a world that moves: the distance along a ray at a time.
using MovingWorld = std::function<World(double t_s)>;

/// A sweep of a sensor that moves while it turns, with reflectivities.
LocalCloud sweep_of(const MovingWorld& world, const std::shared_ptr<const BeamTable>& beams, TimeNs stamp,
                    TimeNs duration, const Random& random, std::uint32_t number) {
  auto scan = std::make_shared<Scan>();
  scan->stamp = stamp;
  scan->duration = duration;
  scan->beams = beams;
  scan->range_m.resize(static_cast<std::size_t>(beams->size()));
  scan->reflectivity.resize(scan->range_m.size());
  LocalCloud cloud;
  for (int c = 0; c < beams->cols; ++c) {
    const double t_s = to_seconds(stamp + (duration == 0 ? 0 : from_seconds(beams->column_offset_s[c])));
    cloud.T_local_lidar.push_back(
        pose_at({0.3 * t_s, 0.5 * std::sin(t_s), 4.0 - 0.1 * t_s}, 0.37 * number + 0.2 * t_s));
    const Pose& T = cloud.T_local_lidar.back();
    const World now = world(t_s);
    for (int r = 0; r < beams->rows; ++r) {
      const auto i = static_cast<std::size_t>(r * beams->cols + c);
      const double t_m =
          now(T * beams->origins_lidar[i].cast<double>(), T.linear() * beams->directions_lidar[i].cast<double>());
      scan->range_m[i] = t_m < 30.0 && random.uniform(number, i) < 0.9 ? static_cast<float>(t_m) : 0.0F;
      scan->reflectivity[i] = static_cast<float>(random.uniform(number, 100'000 + i));
    }
  }
  cloud.scan = scan;
  for (int i = 0; i < scan->size(); ++i) {
    if (!scan->hit(i) || (!beams->masked.empty() && beams->masked[i] != 0)) continue;
    cloud.points_local_m.push_back(
        (cloud.T_local_lidar_of_beam(i) * scan->point_lidar(i).cast<double>()).cast<float>());
    cloud.beam.push_back(static_cast<std::uint32_t>(i));
  }
  return cloud;
}

class HypothesesOf : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Worlds, HypothesesOf, ::testing::Range(0, 8));

TEST_P(HypothesesOf, ARandomWorldAreThoseOfThePlainOnes) {
  const auto world_number = static_cast<std::uint32_t>(GetParam());
  const Random random(world_number, "world");
  const auto u = [&](std::uint32_t k) { return random.uniform(1'000'000, k); };
  TrackBeforeDetectConfig config;
  config.air.size_m = {32.0, 32.0, 16.0};
  config.air.voxel_m = 0.5 + 0.25 * (world_number % 3);
  config.max_hypotheses = world_number % 4 == 3 ? 4 : 60;
  config.rays_per_sweep = world_number % 2 == 0 ? 100'000 : 1000;
  config.max_range_m = world_number % 3 == 1 ? 12.0 : 60.0;
  config.ray_max_m = 10.0 + 10.0 * u(1);
  config.empty_ray_m = world_number == 6 ? 0.0 : world_number == 2 ? 8.0 : 15.0;
  config.learning_delay_s = 0.2 + 0.8 * u(2);
  config.target.radius_m = world_number % 4 == 1 ? 0.05 : 0.3;
  config.target.lifetime_s = 5.0 + 50.0 * u(3);
  config.target.acceleration_density = 0.5 + 5.0 * u(4);
  config.target.return_variation = 0.5 + 2.0 * u(5);
  config.target.birth_per_m3 = 2e-4 * std::pow(20.0, u(6));
  const bool large = world_number % 2 == 0;
  config.target.max_size_m = large ? 4.0 : 0.8 + u(7);
  config.target.body_m = world_number % 4 == 3 ? 0.0 : 2.0 + world_number % 3;
  config.noise.sigma_attitude_rad = world_number % 4 == 1 ? 0.03 : 0.005;
  config.free_share = 0.002 + 0.01 * u(8);
  config.cluster_distance_m = 0.5 + 0.5 * u(9);

  struct Flyer {
    Vector3 p_m, v_mps;
    double radius_m, from_s, to_s;
  };
  std::vector<Flyer> flyers;
  for (std::uint32_t k = 0; k < 9; ++k) {
    const auto n = random.normal3(2'000'000, k);
    const double azimuth = 2.0 * std::numbers::pi * u(20 + k);
    flyers.push_back({Vector3((4.0 + 9.0 * u(40 + k)) * std::cos(azimuth), (4.0 + 9.0 * u(40 + k)) * std::sin(azimuth),
                              3.5 + 2.0 * u(60 + k)),
                      1.2 * Vector3(n[0], n[1], 0.1 * n[2]), k == 0 ? (large ? 1.2 : 0.9) : 0.15 + 0.2 * u(80 + k),
                      1.5 + 0.2 * k, 5.0 + 0.3 * k});
  }
  flyers[8] = flyers[7];  // two side by side that part
  flyers[8].p_m += Vector3(0.0, 0.0, 0.9);
  flyers[8].v_mps.z() += 0.3;
  const World tree = bar({7.0, 5.0, 0.0}, {7.0, 5.0, 6.0}, 0.2);
  const MovingWorld world = [&](double t_s) {
    std::vector<World> things = {ground(), tree};
    for (const Flyer& f : flyers) {
      if (t_s > f.from_s && t_s < f.to_s) things.push_back(sphere(f.p_m + (t_s - f.from_s) * f.v_mps, f.radius_m));
    }
    return all_of(things);
  };
  auto beams = std::make_shared<BeamTable>(*make_beams(30, 90, 30.0, -40.0));
  for (std::size_t i = 0; i < beams->origins_lidar.size(); ++i) {
    beams->origins_lidar[i] = 0.05F * beams->directions_lidar[i];
    if (world_number % 2 == 1) beams->masked.push_back(i % 97 == 0);
  }

  Hypotheses ours(config);
  PlainHypotheses plain(config);
  std::size_t told = 0, most = 0;
  double largest_m = 0.0;
  for (std::uint32_t i = 0; i < 60; ++i) {
    const LocalCloud cloud = sweep_of(world, beams, i * kSweep, world_number % 2 == 0 ? kSweep : 0, random, i);
    ours.take(cloud);
    plain.take(cloud);
    ASSERT_EQ(ours.all().size(), plain.guesses.size()) << i;
    std::vector<Detection> detections;
    std::vector<Track> tracks;
    ours.append_told(detections);
    ours.append_told(tracks);
    std::size_t row = 0;
    for (std::size_t k = 0; k < plain.guesses.size(); ++k) {
      const Hypothesis& h = ours.all()[k];
      const PlainHypotheses::Guess& g = plain.guesses[k];
      ASSERT_EQ(h.id, g.id) << i;
      ASSERT_EQ(h.identity, g.identity) << i;
      ASSERT_EQ(h.t, cloud.stamp() + cloud.scan->duration / 2);
      ASSERT_NEAR(h.existence, g.existence, 1e-7) << i;
      ASSERT_NEAR(h.small.probability(), g.small, 1e-7) << i;
      ASSERT_LT((h.mean - g.mean).norm(), 1e-7) << i;
      ASSERT_LT((h.covariance - g.covariance).norm(), 1e-7) << i;
      ASSERT_EQ(h.num_sweeps, g.num_sweeps);
      ASSERT_EQ(h.num_returns, g.num_returns);
      ASSERT_NEAR(h.size_m, g.size_m, 1e-9);
      largest_m = std::max(largest_m, g.size_m);
      ASSERT_LT((h.extent_m - g.extent_m).norm(), 1e-9);
      ASSERT_LT((h.measured_local_m - g.measured_m).norm(), 1e-9);
      ASSERT_LT((h.measured_covariance - g.measured_covariance).norm(), 1e-9);
      ASSERT_EQ(h.reflectivity, g.reflectivity);
      if (g.existence * (1.0 - g.small) < config.told_existence) continue;
      ASSERT_LT(row, tracks.size());
      const Detection& d = detections[row];
      const Track& track = tracks[row++];
      EXPECT_EQ(d.t, h.t);
      EXPECT_EQ(d.position_m, h.p_local_m());
      EXPECT_EQ(d.covariance, h.position_covariance());
      EXPECT_EQ(d.extent_m, h.extent_m);
      EXPECT_EQ(d.num_points, h.num_returns);
      EXPECT_NEAR(d.confidence, g.existence * (1.0 - g.small), 1e-7);
      EXPECT_EQ(d.reflectivity, h.reflectivity);
      EXPECT_EQ(track.id, g.identity);
      EXPECT_EQ(track.t, h.t);
      EXPECT_EQ(track.position_m, h.p_local_m());
      EXPECT_EQ(track.velocity_mps, h.v_local_mps());
      EXPECT_EQ((track.covariance.topLeftCorner<6, 6>()), h.covariance);
      EXPECT_EQ(track.num_detections, h.num_sweeps);
      EXPECT_EQ(track.corrected, h.num_returns > 0);
      EXPECT_EQ(track.measured_m, h.measured_local_m);
      EXPECT_EQ(track.measured_covariance, h.measured_covariance);
      EXPECT_EQ(track.reflectivity, h.reflectivity);
    }
    EXPECT_EQ(row, tracks.size());
    EXPECT_EQ(row, detections.size());
    told += row;
    most = std::max(most, ours.all().size());
    for (std::uint32_t k = 0; k < 200; ++k) {
      const Vector3 p_m(30.0 * random.uniform(i, 300'000 + k) - 15.0, 30.0 * random.uniform(i, 301'000 + k) - 15.0,
                        15.0 * random.uniform(i, 302'000 + k) - 3.0);
      ASSERT_NEAR(ours.air().clutter_share(p_m), plain.air.clutter_share(p_m), 1e-12);
    }
  }
  if (world_number == 0) {
    EXPECT_GT(plain.num_heirs, 0) << "some of those that are given up come back";
  }
  if (world_number == 0 || world_number == 4) {
    EXPECT_GT(plain.num_joined, 0) << "the largest one falls into parts";
    EXPECT_GT(largest_m, 1.5) << "of 2.4 m";
  }
  std::vector<Counter> counters;
  ours.append_counters(counters);
  ASSERT_EQ(counters.size(), 1U);
  EXPECT_EQ(counters[0].of, plain.num_born);
  EXPECT_EQ(counters[0].count, plain.num_dropped);
  EXPECT_GE(told, world_number == 6                            ? 0U
                  : world_number % 4 == 1 || world_number == 2 ? 1U
                                                               : 20U)
      << most << " at a time, born " << plain.num_born;
}

/// Returns at a height where the background is not known, and whatever is a candidate waits.
class Waiting {
 public:
  Waiting() {
    config.air.size_m = {64.0, 64.0, 32.0};
    config.background_share = 1.0;
    config.learning_delay_s = 60.0;
    config.rays_per_sweep = 10'000'000;
    hypotheses = std::make_unique<Hypotheses>(config);
  }
  /// A sweep of returns in voxels of their own, along x first.
  void take(std::size_t count, double z_m) {
    auto beams = std::make_shared<BeamTable>();
    beams->rows = 1;
    beams->cols = static_cast<int>(count);
    beams->column_offset_s.assign(count, 0.0F);
    beams->directions_lidar.assign(count, Eigen::Vector3f::UnitX());
    beams->origins_lidar.assign(count, Eigen::Vector3f::Zero());
    auto scan = std::make_shared<Scan>();
    scan->stamp = number_++ * kSweep;
    scan->beams = beams;
    scan->range_m.assign(count, 0.1F);  // too short to clear air
    LocalCloud cloud;
    cloud.scan = scan;
    cloud.T_local_lidar.assign(count, pose_at({0.0, 0.0, 0.0}));
    for (std::size_t i = 0; i < count; ++i) {
      cloud.points_local_m.push_back(place(i, z_m));
      cloud.beam.push_back(static_cast<std::uint32_t>(i));
    }
    hypotheses->take(cloud);
  }
  static Eigen::Vector3f place(std::size_t i, double z_m) {
    return {-29.75F + 0.5F * static_cast<float>(i % 100), -29.75F + 0.5F * static_cast<float>(i / 100),
            static_cast<float>(z_m)};
  }
  bool learned(std::size_t i, double z_m) const {
    return hypotheses->air().clutter_share(place(i, z_m).cast<double>()) > hypotheses->air().prior_share();
  }

  TrackBeforeDetectConfig config;
  std::unique_ptr<Hypotheses> hypotheses;

 private:
  TimeNs number_ = 0;
};

// What no more room is for is background at once; of what waits, the oldest.
// By brute force: the gamma distribution of the share, and Poisson numbers of returns.
TEST(Smallness, EachSweepCountsAsItsNegativeBinomialLikelihoodsSay) {
  const auto likelihood = [](int n, double mean, double variation) {
    double sum = 0.0, norm = 0.0;
    for (int i = 0; i < 200'000; ++i) {
      const double x = 1e-4 * (i + 0.5);  // times the mean
      const double weight = std::pow(x, variation - 1.0) * std::exp(-variation * x);
      norm += weight;
      sum += weight * std::pow(mean * x, n) * std::exp(-mean * x) / std::tgamma(n + 1.0);
    }
    return sum / norm;
  };
  for (const double variation : {1.0, 2.5}) {
    for (const double shots : {2.0, 30.0}) {
      for (const int n : {0, 1, 4}) {
        Smallness small;
        small.weigh(n, shots, 0.0, 0.02, 0.065, variation);
        const double ratio = likelihood(n, 0.02 * shots, variation) / likelihood(n, 0.065 * shots, variation);
        EXPECT_NEAR(small.log_odds, std::log(ratio), 1e-3) << variation << ' ' << shots << ' ' << n;
      }
    }
  }
}

TEST(Smallness, ABirdIsKnownAfterAFewSecondsAndTheSmallestUavIsNotTakenForOne) {
  const Random random(11, "smallness");
  constexpr double kShots = 7.5, kPrior = 0.05;  // a Mid-360 at 10 m
  int birds = 0, uavs = 0;
  double bird_sweeps = 0.0, uav_small_sweeps = 0.0;
  for (std::uint32_t flight = 0; flight < 200; ++flight) {
    for (const bool bird : {true, false}) {
      Smallness small{std::log(kPrior / (1.0 - kPrior))};
      for (std::uint32_t sweep = 0; sweep < 200; ++sweep) {
        const double share = (bird ? 0.02 : 0.065) * -std::log(random.uniform(flight, 4 * sweep + bird));
        int n = 0;  // Poisson
        for (double left = share * kShots, u = random.uniform(flight, 4 * sweep + 2 + bird), p = std::exp(-left),
                    sum = p;
             u > sum && n < 50; sum += p) {
          p *= left / ++n;
        }
        small.weigh(n, kShots, 0.0, 0.02, 0.065, 1.0);
        (bird ? bird_sweeps : uav_small_sweeps) += (bird ? small.probability() < 0.5 : small.probability() > 0.5);
      }
      (bird ? birds : uavs) += small.probability() > 0.5;
    }
  }
  EXPECT_GT(birds, 195);
  EXPECT_LT(uavs, 5);
  EXPECT_LT(bird_sweeps / 200, 45.0) << "told for 4.5 s in the mean";
  EXPECT_LT(uav_small_sweeps / 200, 4.0) << "a fiftieth of 20 s";
}

TEST(Smallness, SilenceOfWhatMayBeHiddenSaysLittleAndNothingIsEverCertain) {
  Smallness seen, hidden;
  seen.weigh(0, 30.0, 0.0, 0.02, 0.065, 1.0);
  hidden.weigh(0, 30.0, 1.0, 0.02, 0.065, 1.0);
  EXPECT_GT(seen.log_odds, 0.3);
  EXPECT_EQ(hidden.log_odds, 0.0);
  for (int i = 0; i < 1000; ++i) seen.weigh(0, 30.0, 0.0, 0.02, 0.065, 1.0);
  EXPECT_LT(seen.probability(), 0.998);
  for (int i = 0; i < 12; ++i) seen.weigh(4, 30.0, 0.0, 0.02, 0.065, 1.0);
  EXPECT_LT(seen.probability(), 0.5) << "it has learned better";
}

TEST(Hypotheses, ReturnsThatWaitAreBounded) {
  Waiting waiting;
  waiting.take(4098, 0.25);
  for (const std::size_t i : {0U, 1U, 2000U, 4095U}) EXPECT_FALSE(waiting.learned(i, 0.25)) << i;
  for (const std::size_t i : {4096U, 4097U}) EXPECT_TRUE(waiting.learned(i, 0.25)) << i;
  for (const double z_m : {1.25, 2.25, 3.25}) waiting.take(4096, z_m);
  EXPECT_FALSE(waiting.learned(0, 0.25)) << "16384 wait";
  waiting.take(2, 4.25);
  EXPECT_TRUE(waiting.learned(0, 0.25));
  EXPECT_TRUE(waiting.learned(1, 0.25));
  EXPECT_FALSE(waiting.learned(2, 0.25));
  EXPECT_FALSE(waiting.learned(1, 4.25));
}

}  // namespace
}  // namespace swiftlet
