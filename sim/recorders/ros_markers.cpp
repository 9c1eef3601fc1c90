// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/ros_markers.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace swiftlet::sim {
namespace {

// Constants of visualization_msgs/Marker.
enum MarkerType : std::int32_t { kArrow = 0, kCube = 1, kSphere = 2, kText = 9, kTriangleList = 11 };
enum MarkerAction : std::int32_t { kAdd = 0, kDeleteAll = 3 };

constexpr double kMinSize_m = 0.1;  // a box without extent would be invisible

/// One marker; unset members have the message's defaults.
struct Marker {
  std::string frame = "world";
  const char* space = "";
  std::int32_t id = 0;
  MarkerType type = kSphere;
  MarkerAction action = kAdd;
  Vector3 position_m = Vector3::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vector3 scale_m = Vector3::Zero();
  Eigen::Vector4f color = Eigen::Vector4f::Zero();
  std::vector<Vector3> points_m = {};
  std::string text = {};
  bool moves = false;  // moves with its frame
};

void encode_marker(const Marker& marker, TimeNs t, std::uint32_t sequence, RosEncoder& out) {
  out.header(sequence, t, marker.frame);
  out.text(marker.space);
  out.put(marker.id);
  out.put(static_cast<std::int32_t>(marker.type));
  out.put(static_cast<std::int32_t>(marker.action));
  out.put_pose(marker.position_m, marker.rotation);
  out.vector3(marker.scale_m);
  for (const float value : marker.color) out.put(value);
  out.put(std::int32_t{0});  // lifetime: unlimited
  out.put(std::int32_t{0});
  out.put(marker.moves);  // frame_locked
  out.count(marker.points_m.size());
  for (const Vector3& p : marker.points_m) out.vector3(p);
  out.count(0);  // colors
  if (out.dialect() == RosDialect::kRos2) {
    out.text("");  // texture_resource
    out.header(sequence, t, "");
    out.text("");  // format of the texture
    out.count(0);  // its data
    out.count(0);  // uv_coordinates
  }
  out.text(marker.text);
  out.text("");  // mesh_resource
  if (out.dialect() == RosDialect::kRos2) {
    out.text("");  // mesh_file
    out.count(0);
  }
  out.put(false);  // mesh_use_embedded_materials
}

void begin_markers(std::size_t count, TimeNs t, std::uint32_t sequence, RosEncoder& out) {
  out.begin();
  out.count(1 + count);
  encode_marker({.action = kDeleteAll}, t, sequence, out);
}

/// Ellipsoid of three standard deviations.
Marker covariance_marker(const Track& track, std::int32_t id) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(track.covariance.topLeftCorner<3, 3>());
  Matrix3 axes = solver.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) *= -1.0;
  return {.space = "covariance",
          .id = id,
          .position_m = track.position_m,
          .rotation = Eigen::Quaterniond(axes),
          .scale_m = 6.0 * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt(),
          .color = {0.2F, 0.6F, 1.0F, 0.25F}};
}

Eigen::Vector4f opaque(const Eigen::Vector3f& color_rgb) { return {color_rgb.x(), color_rgb.y(), color_rgb.z(), 1.0F}; }

void append_triangles(const Mesh& mesh, const Eigen::Affine3f& T_frame_mesh, std::vector<Vector3>& points_m) {
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) points_m.push_back((T_frame_mesh * mesh.vertices_mesh_m[v]).cast<double>());
  }
}

/// The disc of a rotor, visible from both sides.
void append_disc(const VehicleShape::RotorShape& rotor, std::vector<Vector3>& points_m) {
  constexpr int kCorners = 12;
  const Vector3 hub_m = rotor.hub_body_m.cast<double>();
  const auto rim_m = [&](int k) {
    const double angle = 2.0 * std::numbers::pi * k / kCorners;
    return Vector3(hub_m + rotor.radius_m * Vector3(std::cos(angle), std::sin(angle), 0.0));
  };
  for (int k = 0; k < kCorners; ++k) {
    for (const Vector3& p_m : {hub_m, rim_m(k), rim_m(k + 1), hub_m, rim_m(k + 1), rim_m(k)}) points_m.push_back(p_m);
  }
}

void encode_solids(const std::vector<Marker>& solids, TimeNs t, std::uint32_t sequence, RosEncoder& out) {
  out.begin();
  out.count(solids.size());
  std::int32_t id = 0;
  for (Marker solid : solids) {
    solid.id = id++;
    solid.type = kTriangleList;
    solid.scale_m = Vector3::Ones();
    encode_marker(solid, t, sequence, out);
  }
}

}  // namespace

void encode_world_markers(const Scene& scene, TimeNs t, std::uint32_t sequence, RosEncoder& out) {
  std::vector<Marker> solids(scene.materials.size());
  for (std::size_t m = 0; m < solids.size(); ++m) {
    solids[m].space = "world";
    solids[m].color = opaque(scene.materials[m].color_rgb);
  }
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    append_triangles(mesh, instance.T_world_mesh, solids[mesh.material].points_m);
  }
  std::erase_if(solids, [](const Marker& solid) { return solid.points_m.empty(); });
  encode_solids(solids, t, sequence, out);
}

void encode_vehicle_markers(const VehicleShape& shape, const std::string& frame, TimeNs t, std::uint32_t sequence,
                            RosEncoder& out) {
  std::vector<Marker> solids;
  for (const Mesh& mesh : shape.meshes) {
    solids.push_back({.frame = frame,
                      .space = "model",
                      .color = opaque(shape.materials.at(mesh.material).color_rgb),
                      .moves = true});
    append_triangles(mesh, Eigen::Affine3f::Identity(), solids.back().points_m);
  }
  if (!shape.rotors.empty()) {
    solids.push_back({.frame = frame, .space = "model", .color = {0.2F, 0.2F, 0.2F, 0.35F}, .moves = true});
    for (const VehicleShape::RotorShape& rotor : shape.rotors) append_disc(rotor, solids.back().points_m);
  }
  encode_solids(solids, t, sequence, out);
}

void encode_detection_markers(std::span<const Detection> detections, TimeNs t, std::uint32_t sequence,
                              RosEncoder& out) {
  begin_markers(detections.size(), t, sequence, out);
  std::int32_t id = 0;
  for (const Detection& detection : detections) {
    encode_marker({.space = "detections",
                   .id = id++,
                   .type = kCube,
                   .position_m = detection.position_m,
                   .scale_m = detection.extent_m.cwiseMax(kMinSize_m),
                   .color = {1.0F, 0.1F, 0.1F, 0.8F}},
                  detection.t, sequence, out);
  }
}

void encode_track_markers(std::span<const Track> tracks, TimeNs t, std::uint32_t sequence, RosEncoder& out) {
  constexpr std::size_t kMarkersPerTrack = 4;
  begin_markers(kMarkersPerTrack * tracks.size(), t, sequence, out);
  const Eigen::Vector4f color(0.2F, 0.6F, 1.0F, 1.0F);
  for (const Track& track : tracks) {
    const auto id = static_cast<std::int32_t>(track.id);
    encode_marker({.space = "tracks",
                   .id = id,
                   .position_m = track.position_m,
                   .scale_m = Vector3::Constant(0.4),
                   .color = color},
                  track.t, sequence, out);
    encode_marker(covariance_marker(track, id), track.t, sequence, out);
    encode_marker({.space = "velocity",
                   .id = id,
                   .type = kArrow,
                   .scale_m = {0.08, 0.2, 0.0},  // diameters of shaft and head
                   .color = color,
                   .points_m = {track.position_m, track.position_m + track.velocity_mps}},
                  track.t, sequence, out);
    encode_marker({.space = "names",
                   .id = id,
                   .type = kText,
                   .position_m = track.position_m + 0.5 * Vector3::UnitZ(),
                   .scale_m = {0.0, 0.0, 0.4},
                   .color = Eigen::Vector4f::Ones(),
                   .text = std::to_string(track.id)},
                  track.t, sequence, out);
  }
}

}  // namespace swiftlet::sim
