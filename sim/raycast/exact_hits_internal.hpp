// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "sim/raycast/embree_internal.hpp"
#include "sim/raycast/embree_scene.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"

/// Internal to sim/raycast: computes which triangle a ray meets, and where, with the same bits on every processor.
///
/// Embree's rounding depends on instruction set and manufacturer. Ranges differ in their last bits, and near an edge
/// also the triangle. Therefore Embree only proposes triangles, which are enlarged in their planes by more than its
/// error. A rule in IEEE double arithmetic tests the proposals:
/// 1. The ray passes the three edges on the same side, by the signs of the volumes that it spans with them. Triangles
/// with a common edge compute this volume with opposite signs, so that no ray passes between them.
/// 2. The surface is visible: the origin is at least kMinHeight_m off the plane, and the surface is not nearly
/// edge-on. The margin, projected along the ray, exceeds Embree's error at that range.
/// 3. The nearest triangle within the range of the query is the result; at equal ranges the first in the scene.
///
/// Nearly all rays get one proposal that is clearly nearer than all others and far from its edges. The rest (5 % in a
/// forest) are tested in full, and traced again where that does not decide.
namespace swiftlet::sim {

/// [-] Cosine of the incidence below which a surface counts as edge-on and is not met. Smaller values need wider
/// margins.
inline constexpr double kMinCosine = 0.01;
/// [m] Distance of an origin from the plane of a triangle below which the triangle is not met.
inline constexpr double kMinHeight_m = 1e-4;

/// Rays of a packet in any frame, the same for all arguments.
struct alignas(64) Rays {
  std::array<float, kPacketSize> origin_x, origin_y, origin_z, direction_x, direction_y, direction_z;

  void set(int i, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) {
    origin_x[i] = origin.x(), origin_y[i] = origin.y(), origin_z[i] = origin.z();
    direction_x[i] = direction.x(), direction_y[i] = direction.y(), direction_z[i] = direction.z();
  }
};

/// Up to kPacketSize rays through one scene, and the triangle met by each. The frame of the scene is any frame, the
/// same for all arguments.
class ExactQuery {
 public:
  explicit ExactQuery(const TriangleScene& scene)
      : scene_(&scene),
        tree_(scene.scene.get()),
        slack_factor_(1.0F + 2.0F * kErrorPerRange),
        slack_m_(scene.slack_m) {}

  /// Sets one ray; lanes must be filled from 0 on.
  void set_ray(int lane, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, double range_max_m);
  /// Sets all lanes.
  void set_rays(const Rays& rays, const std::array<float, kPacketSize>& range_max_m);

  /// Finds the nearest triangle of each of the first `count` rays, tracing each alone.
  void trace_singly(int count);
  /// Finds them for kPacketSize rays at once; best for rays with similar directions.
  void trace_together();
  /// Finds them for rays with different directions; best with a tree for scattered rays.
  void trace_scattered();
  /// True if the ray of lane 0 meets any triangle.
  bool is_blocked();

  bool met(int lane) const { return triangle_[lane] != kNone; }
  // For rays that meet a triangle:
  std::uint32_t triangle(int lane) const { return triangle_[lane]; }
  std::uint32_t surface(int lane) const { return scene_->facets[triangle_[lane]].surface; }
  float range_m(int lane) const { return static_cast<float>(range_m_[lane]); }
  float cos_incidence(int lane) const { return static_cast<float>(cos_incidence_[lane]); }

 private:
  struct Context;
  template <typename T>
  using Lanes = std::array<T, kPacketSize>;
  static constexpr std::uint32_t kNone = RTC_INVALID_GEOMETRY_ID;
  static constexpr std::uint32_t kSeveral = kNone - 1;
  static constexpr float kErrorPerRange = 5e-7F / static_cast<float>(kMinCosine);

  static void take_proposals(const RTCFilterFunctionNArguments* args);
  static void take_sixteen(ExactQuery& query, int lane, const RTCFilterFunctionNArguments* args);
  static void take_eight(ExactQuery& query, int lane, const RTCFilterFunctionNArguments* args);
  static void test_immediately(const RTCFilterFunctionNArguments* args);
  void begin();
  template <typename Packet>
  Packet packet_from(int lane) const;
  template <typename Registers>
  void propose_at_once(int lane, const RTCFilterFunctionNArguments* args);
  void propose(int lane, std::uint32_t triangle, float& tfar);
  void conclude();
  void test_proposals(int first_lane);
  void test_in_full(int lane);
  bool test(int lane, std::uint32_t triangle);
  bool passes_inside(int lane, std::uint32_t triangle) const;
  void trace_again(int lane);
  RTCRay single_ray(int lane) const;
  float error_m(float range_m) const;
  float with_slack_m(float range_m) const { return slack_factor_ * range_m + slack_m_; }

  // Callbacks read and write whole registers of these, as Embree does with the packet.
  RTCRayHit16 packet_;
  alignas(64) Lanes<float> nearest_proposal_m_;
  alignas(64) Lanes<std::uint32_t> first_proposal_;   // kNone: none
  alignas(64) Lanes<std::uint32_t> second_proposal_;  // another one within the slack of the nearest
  // Results:
  alignas(64) Lanes<double> range_m_, cos_incidence_;
  alignas(64) Lanes<std::uint32_t> triangle_;

  Lanes<double> range_max_m_;
  const TriangleScene* scene_;
  RTCScene tree_;
  float slack_factor_, slack_m_;  // a ray continues beyond a proposal, to factor * range + slack
};

/// Computes the facets, the enlarged corners and the slack of a scene from its corners.
void prepare_for_exact_hits(TriangleScene& scene);

}  // namespace swiftlet::sim
