// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_overlays.hpp"

#include <cmath>
#include <span>
#include <utility>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr double kShownVoxels_m = 12.0;  ///< [m] range of the voxels in the overlay; larger values are slow to draw

Overlay marks(const char* name, Overlay::Kind kind, float size_m, std::vector<Eigen::Vector4f> colors = {}) {
  Overlay overlay;
  overlay.name = name;
  overlay.kind = kind;
  overlay.colors = std::move(colors);
  overlay.size_m = size_m;
  return overlay;
}

/// The cell A at the agent's height: the disc of S, cut by the half-spaces; corners in order, relative to the agent.
std::vector<Vector3> level_outline(double radius_m, std::span<const HalfSpace> cuts) {
  // [-] Corners that approximate the disc.
  constexpr int kCorners = 72;
  std::vector<Vector3> corners, left;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    corners.emplace_back(radius_m * elementary::cos(angle), radius_m * elementary::sin(angle), 0.0);
  }
  for (const HalfSpace& cut : cuts) {
    left.clear();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector3 &from = corners[i], &to = corners[(i + 1) % corners.size()];
      const double out_from = cut.normal_local.dot(from) - cut.offset_m,
                   out_to = cut.normal_local.dot(to) - cut.offset_m;
      if (out_from <= 0.0) left.push_back(from);
      if ((out_from <= 0.0) != (out_to <= 0.0)) left.push_back(from + out_from / (out_from - out_to) * (to - from));
    }
    corners.swap(left);
  }
  return corners;
}

}  // namespace

void append_rbl_overlays(const RblPlanner& planner, const RblPlanner::Step& step, const Vector3& goal_local_m,
                         std::vector<Overlay>& overlays) {
  const RblCell& cell = planner.cell();
  const Vector3& p_local_m = planner.p_local_m();
  const auto place = [&](const Vector3& q) { return Eigen::Vector3f((p_local_m + q).cast<float>()); };
  // For a ball, only the slice at the agent's height is shown.
  const std::vector<Vector3> corners = level_outline(cell.radius_m(), planner.cuts());
  Overlay area = marks("rbl.cell", Overlay::Kind::kTriangles, 0.0F);
  Overlay outline = marks("rbl.cell_outline", Overlay::Kind::kPolyline, 2.0F);
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    for (const Vector3& corner : {corners.front(), corners[i], corners[i + 1]}) area.positions.push_back(place(corner));
  }
  for (std::size_t i = 0; i <= corners.size() && !corners.empty(); ++i) {
    outline.positions.push_back(place(corners[i % corners.size()]));
  }
  Overlay sensing = marks("rbl.sensing", Overlay::Kind::kPolyline, 1.0F, {{0.1F, 0.1F, 0.1F, 0.6F}});
  const std::vector<Vector3> disc = level_outline(cell.radius_m(), {});
  for (std::size_t i = 0; i <= disc.size(); ++i) sensing.positions.push_back(place(disc[i % disc.size()]));
  Overlay samples = marks("rbl.samples", Overlay::Kind::kPoints, 0.06F, {{0.05F, 0.05F, 0.05F, 0.8F}});
  for (int i = 0; i < cell.num_samples(); ++i) {
    const Vector3 q = cell.point(i);
    if (std::abs(q.z()) <= 0.51 * cell.step_m() && cell.contains(i)) samples.positions.push_back(place(q));
  }
  Overlay centroid = marks("rbl.centroid", Overlay::Kind::kSpheres, 0.16F);
  centroid.positions = {step.centroid_local_m.cast<float>()};
  Overlay sensing_centroid =
      marks("rbl.sensing_centroid", Overlay::Kind::kSpheres, 0.1F, {{0.05F, 0.05F, 0.05F, 1.0F}});
  sensing_centroid.positions = {step.sensing_local_m.cast<float>()};
  // The destination is far away, so only its direction is shown.
  const Vector3 to_destination = step.destination_local_m - p_local_m;
  const double shown_m = std::min(to_destination.norm(), cell.radius_m() + 1.0);
  Overlay destination = marks("rbl.destination", Overlay::Kind::kLines, 3.0F);
  destination.positions = {p_local_m.cast<float>(), place(shown_m * to_destination.normalized())};
  Overlay goal = marks("rbl.goal", Overlay::Kind::kSpheres, 0.22F);
  goal.positions = {goal_local_m.cast<float>()};
  for (Overlay* overlay : {&area, &outline, &sensing, &samples, &centroid, &sensing_centroid, &destination, &goal}) {
    overlays.push_back(std::move(*overlay));
  }
}

void append_rbl_voxels(const OccupancyView& map, const Vector3& p_local_m, std::vector<Overlay>& overlays) {
  Overlay voxels =
      marks("rbl.voxels", Overlay::Kind::kCubes, static_cast<float>(map.edge_m()), {{0.45F, 0.32F, 0.2F, 1.0F}});
  std::vector<Vector3> centers_local_m;
  map.occupied_within(p_local_m, kShownVoxels_m, kEver, centers_local_m);
  for (const Vector3& center_local_m : centers_local_m) voxels.positions.push_back(center_local_m.cast<float>());
  overlays.push_back(std::move(voxels));
}

}  // namespace swiftlet
