// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/tracking/track_overlays.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {
namespace {

/// [m] Radius of the sphere at a track.
constexpr float kRadius_m = 0.15F;
/// [s] Length of the drawn prediction, and interval of its points.
constexpr double kAhead_s = 2.0, kAheadStep_s = 0.25;
/// [-] Corners that approximate an ellipse.
constexpr int kEllipseCorners = 36;
/// [-] Size of the drawn ellipses in standard deviations.
constexpr double kSigmas = 3.0;

Eigen::Vector4f color_of(std::uint32_t id) {
  // Distinguishable to most color-blind readers (Okabe and Ito 2008).
  static const Eigen::Vector4f kColors[] = {{0.90F, 0.62F, 0.00F, 1}, {0.80F, 0.47F, 0.65F, 1},
                                            {0.34F, 0.71F, 0.91F, 1}, {0.94F, 0.89F, 0.26F, 1},
                                            {0.00F, 0.62F, 0.45F, 1}, {0.84F, 0.37F, 0.00F, 1}};
  return kColors[id % std::size(kColors)];
}

void add_line(Overlay& lines, const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector4f& color) {
  lines.positions.push_back(a);
  lines.positions.push_back(b);
  lines.colors.push_back(color);
  lines.colors.push_back(color);
}

/// Predicted position: accelerated for at most 0.5 s, then at constant velocity.
Vector3 ahead(const Track& track, double dt_s) {
  const double accelerated_s = std::min(dt_s, 0.5);
  const Vector3 v = track.velocity_mps + track.acceleration_mps2 * accelerated_s;
  return track.position_m + track.velocity_mps * accelerated_s +
         0.5 * track.acceleration_mps2 * accelerated_s * accelerated_s + v * (dt_s - accelerated_s);
}

/// Ellipsoid of `kSigmas` standard deviations, as its sections in the planes of its axes.
void add_ellipsoid(Overlay& lines, const Track& track) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(track.covariance.topLeftCorner<3, 3>());
  if (solver.info() != Eigen::Success) return;
  const Vector3 half_axes = kSigmas * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Matrix3 axes = solver.eigenvectors() * half_axes.asDiagonal();
  for (int plane = 0; plane < 3; ++plane) {
    const Vector3 u = axes.col(plane), w = axes.col((plane + 1) % 3);
    const auto corner = [&](int k) {
      const double angle = 2.0 * std::numbers::pi * k / kEllipseCorners;
      return Eigen::Vector3f(
          (track.position_m + elementary::cos(angle) * u + elementary::sin(angle) * w).cast<float>());
    };
    for (int k = 0; k < kEllipseCorners; ++k) add_line(lines, corner(k), corner(k + 1), color_of(track.id));
  }
}

}  // namespace

void TrackOverlays::push(std::span<const Track> tracks) {
  for (Trail& trail : trails_) trail.alive = false;
  for (const Track& track : tracks) {
    auto trail = std::find_if(trails_.begin(), trails_.end(), [&](const Trail& t) { return t.id == track.id; });
    if (trail == trails_.end()) {
      trails_.emplace_back();
      trail = trails_.end() - 1;
      trail->id = track.id;
    }
    trail->alive = true;
    trail->points_local_m[(trail->first + trail->count) % Trail::kCapacity] = track.position_m.cast<float>();
    if (trail->count < Trail::kCapacity)
      ++trail->count;
    else
      trail->first = (trail->first + 1) % Trail::kCapacity;
  }
  std::erase_if(trails_, [](const Trail& trail) { return !trail.alive; });
}

void TrackOverlays::append(std::span<const Track> tracks, std::vector<Overlay>& overlays) const {
  Overlay balls, lines, ellipses;
  balls.name = lines.name = "tracks";
  ellipses.name = "tracks.covariance";
  balls.kind = Overlay::Kind::kSpheres;
  balls.size_m = kRadius_m;
  lines.kind = ellipses.kind = Overlay::Kind::kLines;
  lines.size_m = 3.0F;
  ellipses.size_m = 1.5F;
  for (const Track& track : tracks) {
    const Eigen::Vector4f color = color_of(track.id);
    lines.legend.push_back({"track " + std::to_string(track.id), color});
    balls.positions.push_back(track.position_m.cast<float>());
    balls.colors.push_back(color);
    // Prediction as dashes.
    for (double t = 0.0; t < kAhead_s; t += 2.0 * kAheadStep_s)
      add_line(lines, ahead(track, t).cast<float>(), ahead(track, t + kAheadStep_s).cast<float>(), color);
    add_ellipsoid(ellipses, track);
  }
  if (!tracks.empty()) lines.legend.push_back({"prediction", color_of(tracks.front().id), true});
  for (const Trail& trail : trails_) {
    for (std::size_t k = 0; k + 1 < trail.count; ++k) {
      add_line(lines, trail.points_local_m[(trail.first + k) % Trail::kCapacity],
               trail.points_local_m[(trail.first + k + 1) % Trail::kCapacity], color_of(trail.id));
    }
  }
  overlays.push_back(std::move(balls));
  overlays.push_back(std::move(lines));
  overlays.push_back(std::move(ellipses));
}

}  // namespace swiftlet
