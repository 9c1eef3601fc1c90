// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/intercept_overlays.hpp"

#include <Eigen/LU>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [-] Points that approximate a predicted curve, and the rim of the net.
constexpr int kCurvePoints = 25, kRimPoints = 36;

}  // namespace

void append_curve(const char* name, const char* meaning, const Eigen::Vector4f& color, double duration_s,
                  const std::function<Vector3(double)>& place_local_m, std::vector<Overlay>& overlays) {
  Overlay& line = overlays.emplace_back();
  line.name = name;
  line.kind = Overlay::Kind::kPolyline;
  line.size_m = 3.0F;
  line.colors = {color};
  line.legend = {{meaning, color}};
  for (int i = 0; i < kCurvePoints; ++i)
    line.positions.push_back(place_local_m(duration_s * i / (kCurvePoints - 1)).cast<float>());
}

void append_net(const CaptureVolume& net, const Vector3& p_local_m, double yaw_rad, std::vector<Overlay>& overlays) {
  const Vector3 middle_m = net.center(p_local_m, yaw_rad);
  Overlay& lines = overlays.emplace_back();
  lines.name = "intercept.net";
  lines.kind = Overlay::Kind::kLines;
  lines.size_m = 2.0F;
  const Eigen::Vector4f color(0.0F, 0.62F, 0.45F, 1.0F);
  lines.colors = {color};
  lines.legend = {{"net", color}};
  const auto rim = [&](int i, double up_m) {
    const double angle = 2.0 * kPi * i / kRimPoints;
    return Eigen::Vector3f(
        (middle_m + Vector3(net.radius_m * elementary::cos(angle), net.radius_m * elementary::sin(angle), up_m))
            .cast<float>());
  };
  for (const double up_m : {-0.5 * net.height_m, 0.5 * net.height_m}) {
    for (int i = 0; i < kRimPoints; ++i) {
      lines.positions.push_back(rim(i, up_m));
      lines.positions.push_back(rim(i + 1, up_m));
    }
    if (net.height_m == 0.0) break;
  }
  for (int i = 0; i < kRimPoints; i += kRimPoints / 4) {  // the ropes
    lines.positions.push_back(p_local_m.cast<float>());
    lines.positions.push_back(rim(i, 0.5 * net.height_m));
  }
}

void append_fence(const Geofence& fence, std::vector<Overlay>& overlays) {
  // Corner (i, j, k): where one side of each pair meets.
  const auto& sides = fence.sides();
  const auto corner = [&](int i, int j, int k) {
    Matrix3 N;
    Vector3 b;
    const int chosen[] = {i, 2 + j, 4 + k};
    for (int row = 0; row < 3; ++row) {
      const Wall& side = sides[static_cast<std::size_t>(chosen[row])];
      N.row(row) = side.normal.transpose();
      b[row] = side.offset_m;
    }
    return Eigen::Vector3f(Vector3(N.inverse() * b).cast<float>());
  };
  Overlay& lines = overlays.emplace_back();
  lines.name = "intercept.fence";
  lines.kind = Overlay::Kind::kLines;
  lines.size_m = 2.0F;
  const Eigen::Vector4f color(0.84F, 0.37F, 0.0F, 0.8F);
  lines.colors = {color};
  lines.legend = {{"geofence", color}};
  const auto edge = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    lines.positions.push_back(a);
    lines.positions.push_back(b);
  };
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      edge(corner(0, i, j), corner(1, i, j));
      edge(corner(i, 0, j), corner(i, 1, j));
      edge(corner(i, j, 0), corner(i, j, 1));
    }
  }
}

}  // namespace swiftlet
