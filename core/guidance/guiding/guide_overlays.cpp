// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/guiding/guide_overlays.hpp"

#include "core/guidance/path_overlay.hpp"

namespace swiftlet {
namespace {

const Eigen::Vector4f kSecondaryColor{0.35F, 0.8F, 1.0F, 1.0F};
const Eigen::Vector4f kPrimaryColor{0.9F, 0.22F, 0.21F, 1.0F};
const Eigen::Vector4f kVisibleColor{0.2F, 0.75F, 0.35F, 0.8F};
const Eigen::Vector4f kOverlapColor{0.95F, 0.85F, 0.1F, 1.0F};

Overlay line(const char* name, const Eigen::Vector4f& color, const char* meaning) {
  Overlay overlay;
  overlay.name = name;
  overlay.kind = Overlay::Kind::kLines;
  overlay.size_m = 3.0F;
  overlay.colors = {color};
  overlay.legend = {{meaning, color}};
  return overlay;
}

void append_segment(const Vector3& a_local_m, const Vector3& b_local_m, Overlay& overlay) {
  overlay.positions.push_back(a_local_m.cast<float>());
  overlay.positions.push_back(b_local_m.cast<float>());
}

void append_border(const PlaneRegion& region, double height_local_m, Overlay& overlay) {
  for (const Ring& ring : region.rings_m) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      append_segment({ring[j].x(), ring[j].y(), height_local_m}, {ring[i].x(), ring[i].y(), height_local_m}, overlay);
    }
  }
}

}  // namespace

void append_guide_overlays(const TeamPlan& plan, double height_local_m, std::vector<Overlay>& overlays) {
  // Each path has the trail color of the vehicle that flies it, if the guide is the first vehicle.
  Overlay secondary = line("guide.secondary_path", kSecondaryColor, "path of the guided vehicle");
  for (std::size_t i = 1; i < plan.secondary_path.size(); ++i) {
    append_segment(plan.secondary_path[i - 1].p_local_m, plan.secondary_path[i].p_local_m, secondary);
  }
  Overlay primary = line("guide.primary_path", kPrimaryColor, "path of the guide");
  for (std::size_t i = 1; i < plan.primary_local_m.size(); ++i) {
    append_segment(plan.primary_local_m[i - 1], plan.primary_local_m[i], primary);
  }
  Overlay visible = line("guide.visible", kVisibleColor, "viewpoints of a waypoint");
  append_border(union_of(plan.visible), height_local_m, visible);
  Overlay overlap = line("guide.overlap", kOverlapColor, "viewpoints of most of the path");
  append_border(plan.viewpoint.overlap, height_local_m, overlap);

  std::vector<Vector3> viewpoint_local_m;
  if (plan.viewpoint.num_visible > 0) viewpoint_local_m.push_back(plan.viewpoint.p_local_m);
  Overlay place = path_overlay("guide.viewpoint", viewpoint_local_m, 0.12F);
  place.colors = {kOverlapColor};
  for (Overlay* overlay : {&secondary, &primary, &visible, &overlap, &place}) overlays.push_back(std::move(*overlay));
}

}  // namespace swiftlet
