// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/target_search.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

struct ParticleTuning {
  double near_m = 4.0;          ///< [m] radius of particles that count as one position
  double min_weight = 1e-6;     ///< [-] lower bound, so that a position may become possible again
  double maneuver_per_s = 0.7;  ///< [1/s] rate at which a particle's acceleration changes
  double max_step_s = 1.0;      ///< [s] upper limit of a step
  std::uint64_t seed = 1;       ///< [-] random seed of the particles; others search positions in another order
};
constexpr ParticleTuning kParticle;

}  // namespace

void TargetSearchConfig::visit(ConfigVisitor& v) {
  v.field("timeout_s", timeout_s, "[s] duration of a search after which it has failed", Range::positive());
  v.field("acceleration_mps2", acceleration_mps2, "[m/s^2] standard deviation of the lost target's acceleration",
          Range::positive());
  v.field("speed_max_mps", speed_max_mps, "[m/s] upper limit of the lost target's speed", Range::positive());
  v.field("range_m", range_m, "[m] range within which the target would be detected", Range::positive());
  v.field("fov_bottom_deg", fov_bottom_deg, "[deg] lower edge of the level LiDAR's field of view",
          Range::between(-89.0, 89.0));
  v.field("fov_top_deg", fov_top_deg, "[deg] upper edge of the level LiDAR's field of view",
          Range::between(-89.0, 89.0));
  v.check(fov_top_deg > fov_bottom_deg, "fov_top_deg", "more than fov_bottom_deg");
}

TargetSearch::TargetSearch(const TargetSearchConfig& config)
    : config_(config),
      random_(kParticle.seed, "guidance.search"),
      tan_bottom_(elementary::tan(config.fov_bottom_deg * kRadPerDeg)),
      tan_top_(elementary::tan(config.fov_top_deg * kRadPerDeg)) {}

void TargetSearch::begin(const PointState& target, double sigma_m, double sigma_mps) {
  ++draws_;
  for (std::uint32_t i = 0; i < kParticles; ++i) {
    const auto place = random_.normal3(draws_, 2 * i), speed = random_.normal3(draws_, 2 * i + 1);
    particles_[i] = {target.p_m + sigma_m * Vector3(place[0], place[1], place[2]),
                     target.v_mps + sigma_mps * Vector3(speed[0], speed[1], speed[2]), 1.0};
  }
  remaining_ = 1.0;
}

void TargetSearch::advance(double dt_s, const Geofence& fence) {
  ++draws_;
  dt_s = std::min(dt_s, kParticle.max_step_s);
  const double spread_mps = config_.acceleration_mps2 * std::sqrt(dt_s / kParticle.maneuver_per_s);
  for (std::uint32_t i = 0; i < kParticles; ++i) {
    Particle& particle = particles_[i];
    // White noise with the same effect as an acceleration that is kept for a second or two.
    const auto n = random_.normal3(draws_, i);
    particle.v_local_mps += spread_mps * Vector3(n[0], n[1], n[2]);
    const double speed_mps = particle.v_local_mps.norm();
    if (speed_mps > config_.speed_max_mps) particle.v_local_mps *= config_.speed_max_mps / speed_mps;
    particle.p_local_m += dt_s * particle.v_local_mps;
    for (const Wall& side : fence.sides()) {
      const double excess_m = side.excess_m(particle.p_local_m);
      if (excess_m <= 0.0) continue;
      particle.p_local_m -= excess_m * side.normal;
      particle.v_local_mps -= 2.0 * std::max(0.0, side.normal.dot(particle.v_local_mps)) * side.normal;
    }
  }
}

void TargetSearch::look(const Vector3& eye_local_m, double dt_s, const OccupancyView* map) {
  const double missed = elementary::exp(-config_.detection_rate_per_s * dt_s);
  double sum = 0.0;
  for (Particle& particle : particles_) {
    if (sees(eye_local_m, particle.p_local_m, map))
      particle.weight = std::max(kParticle.min_weight, missed * particle.weight);
    sum += particle.weight;
  }
  remaining_ = sum / kParticles;
}

bool TargetSearch::sees(const Vector3& eye_local_m, const Vector3& p_local_m, const OccupancyView* map) const {
  const Vector3 to = p_local_m - eye_local_m;
  if (to.squaredNorm() > config_.range_m * config_.range_m) return false;
  const double level_m = to.head<2>().norm();
  if (to.z() < tan_bottom_ * level_m || to.z() > tan_top_ * level_m) return false;
  return map == nullptr || !map->first_hit(eye_local_m, p_local_m);
}

Vector3 TargetSearch::most_probable() const {
  Vector3 best_m = particles_.front().p_local_m;
  double most = -1.0;
  for (const Particle& center : particles_) {
    double sum = 0.0;
    Vector3 middle_m = Vector3::Zero();
    for (const Particle& particle : particles_) {
      if ((particle.p_local_m - center.p_local_m).squaredNorm() > kParticle.near_m * kParticle.near_m) continue;
      sum += particle.weight;
      middle_m += particle.weight * particle.p_local_m;
    }
    if (sum <= most) continue;
    most = sum;
    best_m = middle_m / sum;
  }
  return best_m;
}

void TargetSearch::append_overlay(std::vector<Overlay>& overlays) const {
  Overlay& points = overlays.emplace_back();
  points.name = "intercept.search";
  points.kind = Overlay::Kind::kPoints;
  points.size_m = 0.25F;
  points.legend = {{"possible positions of the lost target", {0.80F, 0.47F, 0.65F, 1.0F}}};
  for (const Particle& particle : particles_) {
    points.positions.push_back(particle.p_local_m.cast<float>());
    points.colors.push_back({0.80F, 0.47F, 0.65F, static_cast<float>(std::clamp(particle.weight, 0.15, 1.0))});
  }
}

}  // namespace swiftlet
