// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/cameras.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {
namespace {

// [s] Time constants of a follow camera: of target and distance, and of the direction. Larger values move it more
// smoothly and later.
constexpr double kSmoothing_s = 1.2, kTurning_s = 0.7;
// [-] Enlargement of the framed region. Larger values leave wider margins around the vehicles.
constexpr double kMargin = 1.25;
// [ns] Interval of occlusion tests of follow cameras. Smaller values cost time.
constexpr TimeNs kTestInterval = 200'000'000;
// [ns] Time with a free view from the configured position until the camera returns there. Smaller values swing more
// often.
constexpr TimeNs kFreeLongEnough = 2'000'000'000;
// [-] Shares of unblocked sight lines from which a follow camera keeps its direction, and accepts a new one. Larger
// values move the camera more often.
constexpr double kSeenEnough = 0.6, kSeenWell = 0.8;
// [-] Largest number of vehicles of a team to which sight lines are tested. Larger values cost time.
constexpr std::size_t kMaxTested = 8;
// [rad] Largest elevation of a moved camera. Larger values look straight down, where the heading is undefined.
constexpr double kHighest_rad = radians(80.0);
// [-] Diameter of the largest vehicle as a share of the picture's height, for a follow camera without configured
// position. Larger values place the camera nearer.
constexpr double kVehicleShare = 0.18;
const Eigen::Vector3d kFollowFrom = Eigen::Vector3d(-7.0, -7.0, 2.1).normalized();

Eigen::Matrix4d look(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up_hint) {
  const Eigen::Vector3d back = (eye - target).normalized();
  Eigen::Vector3d right = up_hint.cross(back);
  if (right.norm() < 1e-6) right = Eigen::Vector3d::UnitY().cross(back);
  if (right.norm() < 1e-6) right = Eigen::Vector3d::UnitX();
  right.normalize();
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.block<1, 3>(0, 0) = right;
  T.block<1, 3>(1, 0) = back.cross(right);
  T.block<1, 3>(2, 0) = back;
  T.block<3, 1>(0, 3) = -T.block<3, 3>(0, 0) * eye;
  return T;
}

// Depth 1 at near, 0 at far.
Eigen::Matrix4d perspective(double fov_rad, double aspect, double near_m, double far_m) {
  const double f = 1.0 / std::tan(0.5 * fov_rad);
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = f / aspect;
  clip(1, 1) = f;
  clip(2, 2) = near_m / (far_m - near_m);
  clip(2, 3) = near_m * far_m / (far_m - near_m);
  clip(3, 2) = -1.0;
  return clip;
}

Eigen::Matrix4d parallel(double width_m, double height_m, double near_m, double far_m) {
  Eigen::Matrix4d clip = Eigen::Matrix4d::Identity();
  clip(0, 0) = 2.0 / width_m;
  clip(1, 1) = 2.0 / height_m;
  clip(2, 2) = 1.0 / (far_m - near_m);
  clip(2, 3) = far_m / (far_m - near_m);
  return clip;
}

}  // namespace

std::optional<Eigen::Vector3d> View::project(const Eigen::Vector3d& p_world_m) const {
  const Eigen::Vector4d camera = T_camera_world * p_world_m.homogeneous();
  const double depth = -camera.z();
  if (depth < near_m) return std::nullopt;
  const Eigen::Vector4d clip = clip_camera * camera;
  return Eigen::Vector3d((0.5 + 0.5 * clip.x() / clip.w()) * width_px, (0.5 - 0.5 * clip.y() / clip.w()) * height_px,
                         depth);
}

double View::pixels_per_m(double depth_m) const {
  const double scale = 0.5 * clip_camera(1, 1) * height_px;
  return orthographic ? scale : scale / std::max(depth_m, near_m);
}

View perspective_view(const Eigen::Vector3d& eye_world_m, const Eigen::Vector3d& target_world_m, double fov_deg,
                      int width_px, int height_px, const Eigen::Vector3d& up_world) {
  View view;
  view.T_camera_world = look(eye_world_m, target_world_m, up_world);
  view.eye_world_m = eye_world_m;
  view.width_px = width_px;
  view.height_px = height_px;
  view.near_m = 0.05;
  view.far_m = 2000.0;
  view.clip_camera = perspective(radians(fov_deg), static_cast<double>(width_px) / height_px, view.near_m, view.far_m);
  return view;
}

View top_view(const Eigen::Vector2d& center_world_m, double span_m, double bottom_m, double top_m, int width_px,
              int height_px) {
  View view;
  view.eye_world_m = {center_world_m.x(), center_world_m.y(), top_m + 1.0};
  view.T_camera_world = look(view.eye_world_m, view.eye_world_m - Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY());
  view.width_px = width_px;
  view.height_px = height_px;
  view.orthographic = true;
  view.near_m = 0.5;
  view.far_m = top_m - bottom_m + 2.0;
  view.clip_camera = parallel(span_m * width_px / height_px, span_m, view.near_m, view.far_m);
  return view;
}

CameraController::CameraController(const CameraConfig& config, VehicleId vehicle, std::vector<float> radii_m,
                                   const Eigen::AlignedBox3d& bounds_m, BlocksSight blocks_sight)
    : config_(config),
      vehicle_(vehicle),
      radii_m_(std::move(radii_m)),
      bounds_m_(bounds_m),
      blocks_sight_(std::move(blocks_sight)) {
  set_size(config_.size_px().x(), config_.size_px().y());
  if (config_.type == CameraConfig::Type::kFollow && config_.position_m == config_.target_m) {
    double radius_m = 0.0;
    for (std::size_t i = 0; i < radii_m_.size(); ++i) {
      if (looks_at(i)) radius_m = std::max<double>(radius_m, radii_m_[i]);
    }
    if (radius_m == 0.0) radius_m = 0.5;
    config_.position_m = radius_m / (kVehicleShare * std::tan(radians(0.5 * config_.fov_deg))) * kFollowFrom;
  }
  if (config_.position_m.norm() > 0.0) {
    const Eigen::Vector3d from = config_.position_m.normalized();
    configured_ = {std::atan2(from.y(), from.x()), std::asin(std::clamp(from.z(), -1.0, 1.0)), 1.0};
  }
  goal_ = stand_ = configured_;
  if (bounds_m_.isEmpty()) bounds_m_ = Eigen::AlignedBox3d(Eigen::Vector3d(-10, -10, 0), Eigen::Vector3d(10, 10, 5));
  // Both zero: chosen by the type.
  if (config_.position_m != config_.target_m) return;
  if (config_.type == CameraConfig::Type::kOnboard || config_.type == CameraConfig::Type::kDepth) {
    const double front = vehicle_ >= 0 && vehicle_ < static_cast<int>(radii_m_.size()) ? 0.5 * radii_m_[vehicle_] : 0.1;
    config_.position_m = {front, 0.0, 0.05};
    config_.target_m = {front + 1.0, 0.0, -0.05};
  }
  if (config_.type == CameraConfig::Type::kFixed) {  // the whole world, viewed from its south-western corner
    const double size = bounds_m_.diagonal().norm();
    config_.target_m = bounds_m_.center();
    config_.position_m = bounds_m_.center() + 0.6 * size * Eigen::Vector3d(-0.75, -0.9, 0.7).normalized() /
                                                  std::tan(radians(0.5 * config_.fov_deg));
  }
}

void CameraController::set_size(int width_px, int height_px) {
  width_px_ = width_px;
  height_px_ = height_px;
}

Eigen::Vector3d CameraController::center_of(std::span<const VehicleState> states) const {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (looks_at(i)) box.extend(states[i].p_world_m);
  }
  return box.isEmpty() ? bounds_m_.center() : box.center();
}

double CameraController::distance_for_all(const Eigen::Vector3d& target_world_m, const Eigen::Vector3d& direction_world,
                                          std::span<const VehicleState> states) const {
  const Eigen::Matrix3d R =
      look(target_world_m + direction_world, target_world_m, Eigen::Vector3d::UnitZ()).topLeftCorner<3, 3>();
  const double half_y = radians(0.5 * config_.fov_deg);
  const double half_x = std::atan(std::tan(half_y) * width_px_ / height_px_);
  double distance = 0.0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!looks_at(i)) continue;
    const Eigen::Vector3d p = R * (states[i].p_world_m - target_world_m);
    // A sphere touches the plane of the frustum at half angle a when |x| cos a + r = (distance - z) sin a.
    const double r = kMargin * (i < radii_m_.size() ? radii_m_[i] : 0.5);
    distance = std::max(distance, p.z() + (kMargin * std::abs(p.x()) * std::cos(half_x) + r) / std::sin(half_x));
    distance = std::max(distance, p.z() + (kMargin * std::abs(p.y()) * std::cos(half_y) + r) / std::sin(half_y));
  }
  return distance;
}

Eigen::Vector3d CameraController::Stand::direction_world() const {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad), std::cos(elevation_rad) * std::sin(azimuth_rad),
          std::sin(elevation_rad)};
}

double CameraController::distance_for(const Eigen::Vector3d& target_world_m, const Stand& stand,
                                      std::span<const VehicleState> states) const {
  return std::max(stand.reach * config_.position_m.norm(),
                  distance_for_all(target_world_m, stand.direction_world(), states));
}

double CameraController::seen_share(const Eigen::Vector3d& target_world_m, const Stand& stand,
                                    std::span<const VehicleState> states) const {
  const Eigen::Vector3d direction = stand.direction_world();
  const Eigen::Vector3d eye = target_world_m + distance_for(target_world_m, stand, states) * direction;
  const Eigen::Matrix3d R = look(eye, target_world_m, Eigen::Vector3d::UnitZ()).topLeftCorner<3, 3>();
  const Eigen::Vector3d right = R.row(0), up = R.row(1);
  int seen = 0, num_rays = 0;
  std::size_t num_tested = 0;
  for (std::size_t i = 0; i < states.size() && num_tested < kMaxTested; ++i) {
    if (!looks_at(i)) continue;
    ++num_tested;
    const double r = 0.8 * (i < radii_m_.size() ? radii_m_[i] : 0.5);
    for (const Eigen::Vector3d& beside :
         {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(r * right), Eigen::Vector3d(-r * right),
          Eigen::Vector3d(r * up), Eigen::Vector3d(-r * up)}) {
      ++num_rays;
      seen += blocks_sight_(states[i].p_world_m + beside, eye) ? 0 : 1;
    }
  }
  return num_rays > 0 ? static_cast<double>(seen) / num_rays : 1.0;
}

CameraController::Stand CameraController::freest_stand(const Eigen::Vector3d& target_world_m,
                                                       std::span<const VehicleState> states) const {
  struct Candidate {
    Stand stand;
    double cost;
  };
  std::vector<Candidate> candidates;
  for (int turn = -9; turn <= 9; ++turn) {
    for (const double raised_deg : {0.0, 15.0, -15.0, 30.0, 45.0, 60.0}) {
      for (const double reach : {1.0, 0.6, 0.35}) {
        Stand stand{configured_.azimuth_rad + radians(20.0 * turn), configured_.elevation_rad + radians(raised_deg),
                    reach};
        if (stand.elevation_rad > kHighest_rad && raised_deg > 0.0) continue;
        if (raised_deg < 0.0 && stand.elevation_rad < radians(5.0)) continue;
        const double turned = std::abs(std::remainder(stand.azimuth_rad - goal_.azimuth_rad, 2.0 * M_PI));
        candidates.push_back(
            {stand, std::abs(turn) / 4.5 + std::abs(raised_deg) / 50.0 + 1.5 * (1.0 - reach) + 0.4 * turned});
      }
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  Stand best = configured_;
  double most = -1.0;
  for (const Candidate& candidate : candidates) {
    const double seen = seen_share(target_world_m, candidate.stand, states);
    if (seen > most) {
      most = seen;
      best = candidate.stand;
    }
    if (seen >= kSeenWell) break;
  }
  return best;
}

void CameraController::choose_stand(TimeNs t, const Eigen::Vector3d& target_world_m,
                                    std::span<const VehicleState> states) {
  if (!blocks_sight_ || (started_ && t - tested_at_ < kTestInterval)) return;
  tested_at_ = t;
  const bool at_home = goal_.azimuth_rad == configured_.azimuth_rad &&
                       goal_.elevation_rad == configured_.elevation_rad && goal_.reach == configured_.reach;
  const bool home_is_free = seen_share(target_world_m, configured_, states) >= kSeenEnough;
  if (!home_is_free) free_since_.reset();
  if (home_is_free && !free_since_) free_since_ = t;
  if (at_home && home_is_free) return;
  if (home_is_free && (!started_ || t - *free_since_ >= kFreeLongEnough)) {
    goal_ = configured_;
  } else if (at_home || seen_share(target_world_m, goal_, states) < kSeenEnough) {
    goal_ = freest_stand(target_world_m, states);
  }
  if (!started_) stand_ = goal_;
}

void CameraController::update(TimeNs t, std::span<const VehicleState> states) {
  if (config_.type != CameraConfig::Type::kFollow) return;
  const double blend = started_ ? 1.0 - std::exp(-to_seconds(t - updated_) / kSmoothing_s) : 1.0;
  const Eigen::Vector3d center = center_of(states);
  target_world_m_ = started_ ? Eigen::Vector3d(target_world_m_ + blend * (center - target_world_m_)) : center;
  choose_stand(t, target_world_m_, states);
  const double turn = started_ ? 1.0 - std::exp(-to_seconds(t - updated_) / kTurning_s) : 1.0;
  stand_.azimuth_rad += turn * std::remainder(goal_.azimuth_rad - stand_.azimuth_rad, 2.0 * M_PI);
  stand_.elevation_rad += turn * (goal_.elevation_rad - stand_.elevation_rad);
  stand_.reach += turn * (goal_.reach - stand_.reach);
  const double needed = distance_for(target_world_m_, stand_, states);
  distance_m_ = started_ ? distance_m_ + blend * (needed - distance_m_) : needed;
  distance_m_ = std::max(distance_m_, needed);  // inertia must not move a vehicle out of the picture
  updated_ = t;
  started_ = true;
}

View CameraController::view(const PictureScene& picture) const {
  if (config_.type == CameraConfig::Type::kFollow) return follow(picture);
  if (config_.type == CameraConfig::Type::kTop) return top(picture);
  if (config_.type == CameraConfig::Type::kOnboard || config_.type == CameraConfig::Type::kDepth)
    return on_vehicle(picture);
  return fixed();
}

View CameraController::follow(const PictureScene& picture) const {
  CameraController now = *this;
  if (!started_ || updated_ < picture.t) now.update(picture.t, picture.states);
  const Eigen::Vector3d direction = now.stand_.direction_world();
  // The picture may have become narrower since the last update.
  const double distance_m = std::max(now.distance_m_, distance_for_all(now.target_world_m_, direction, picture.states));
  return perspective_view(now.target_world_m_ + distance_m * direction, now.target_world_m_, config_.fov_deg, width_px_,
                          height_px_);
}

View CameraController::top(const PictureScene& picture) const {
  const double aspect = static_cast<double>(width_px_) / height_px_;
  Eigen::AlignedBox2d area;
  for (std::size_t i = 0; i < picture.states.size(); ++i) {
    if (!looks_at(i)) continue;
    area.extend(picture.states[i].p_world_m.head<2>());
    if (!config_.trails || i >= picture.trails_m.size()) continue;
    for (const Eigen::Vector3f& p : picture.trails_m[i]) area.extend(p.head<2>().cast<double>());
  }
  if (area.isEmpty()) area.extend(bounds_m_.center().head<2>());
  Eigen::Vector2d center = area.center();
  double span = std::max({12.0, kMargin * area.sizes().y() + 4.0, (kMargin * area.sizes().x() + 4.0) / aspect});
  if (config_.span_m > 0.0) {
    span = config_.span_m;
    if (vehicle_ == kNoVehicle) center = config_.target_m.head<2>();
  }

  double top_m = bounds_m_.max().z();
  double bottom_m = bounds_m_.min().z();
  for (const VehicleState& state : picture.states) {
    top_m = std::max(top_m, state.p_world_m.z() + 2.0);
    bottom_m = std::min(bottom_m, state.p_world_m.z() - 2.0);
  }
  return top_view(center, span, bottom_m, top_m, width_px_, height_px_);
}

View CameraController::on_vehicle(const PictureScene& picture) const {
  const Pose T_world_body = vehicle_ >= 0 && vehicle_ < static_cast<int>(picture.states.size())
                                ? picture.states[vehicle_].T_world_body()
                                : Pose::Identity();
  return perspective_view(T_world_body * config_.position_m, T_world_body * config_.target_m, config_.fov_deg,
                          width_px_, height_px_, T_world_body.linear().col(2));
}

View CameraController::fixed() const {
  return perspective_view(config_.position_m, config_.target_m, config_.fov_deg, width_px_, height_px_);
}

}  // namespace swiftlet::sim
