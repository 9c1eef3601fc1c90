// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "sim/raycast/embree_internal.hpp"
#include "sim/raycast/embree_scene.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"

/// Internal to this room: which triangle a ray meets, and where, with the same bits on every processor.
///
/// Embree rounds differently by instruction set and by maker. Ranges differ in their last bits, and near an edge so
/// does the triangle. Therefore Embree only proposes: it traces triangles that are enlarged in their planes by more
/// than it can err. A rule in IEEE double arithmetic judges the proposals:
///
/// 1. The ray passes the three edges on the same side, by the signs of the volumes that it spans with them. Two
///    triangles with a common edge see the same volume with opposite signs, so no ray slips through between them.
/// 2. The surface is visible: the origin is at least kLeastHeight_m off the plane, and the surface is not nearly
///    edge-on. Seen along the ray, the margin is more than Embree may err at that range.
/// 3. The nearest triangle within the range of the query counts; of equally near ones the first in the scene.
///
/// Nearly all rays get one proposal well before all others and far from its edges. The rest (5 % in a forest) are
/// judged in full, and traced again where that does not decide.
namespace swiftlet::sim {

inline constexpr double kLeastCosine = 0.01;
inline constexpr double kLeastHeight_m = 1e-4;

/// Rays of a packet in any frame, the same for all arguments.
struct alignas(64) Rays {
  std::array<float, kPacketSize> origin_x, origin_y, origin_z, direction_x, direction_y, direction_z;

  void set(int i, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) {
    origin_x[i] = origin.x(), origin_y[i] = origin.y(), origin_z[i] = origin.z();
    direction_x[i] = direction.x(), direction_y[i] = direction.y(), direction_z[i] = direction.z();
  }
};

/// Up to kPacketSize rays through one scene, and the triangle that each one meets. The frame of the scene is
/// any frame, the same for all arguments.
class ExactQuery {
 public:
  explicit ExactQuery(const TriangleScene& scene)
      : scene_(&scene),
        tree_(scene.scene.get()),
        slack_factor_(1.0F + 2.0F * kErrorPerRange),
        slack_m_(scene.slack_m) {}

  /// Lanes are filled from 0 on.
  void set_ray(int lane, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, double range_max_m);
  /// All lanes.
  void set_rays(const Rays& rays, const std::array<float, kPacketSize>& range_max_m);

  /// The nearest triangle of each of the first `count` rays, each traced alone.
  void trace_singly(int count);
  /// The same for kPacketSize rays at once; best for rays that go nearly the same way.
  void trace_together();
  /// The same for rays that go different ways; best in a scene that is made for them.
  void trace_scattered();
  /// Does the ray of lane 0 meet anything at all?
  bool is_blocked();

  bool met(int lane) const { return triangle_[lane] != kNone; }
  // Of rays that have met something:
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
  static constexpr float kErrorPerRange = 5e-7F / static_cast<float>(kLeastCosine);

  static void take_proposals(const RTCFilterFunctionNArguments* args);
  static void take_sixteen(ExactQuery& query, int lane, const RTCFilterFunctionNArguments* args);
  static void take_eight(ExactQuery& query, int lane, const RTCFilterFunctionNArguments* args);
  static void judge_at_once(const RTCFilterFunctionNArguments* args);
  void begin();
  template <typename Packet>
  Packet packet_from(int lane) const;
  template <typename Registers>
  void propose_at_once(int lane, const RTCFilterFunctionNArguments* args);
  void propose(int lane, std::uint32_t triangle, float& tfar);
  void conclude();
  void judge_proposals(int first_lane);
  void judge_in_full(int lane);
  bool judge(int lane, std::uint32_t triangle);
  bool passes_inside(int lane, std::uint32_t triangle) const;
  void trace_again(int lane);
  RTCRay single_ray(int lane) const;
  float error_m(float range_m) const;
  float with_slack_m(float range_m) const { return slack_factor_ * range_m + slack_m_; }

  // Callbacks read and write whole registers of these, just as Embree does with the packet.
  RTCRayHit16 packet_;
  alignas(64) Lanes<float> nearest_proposal_m_;
  alignas(64) Lanes<std::uint32_t> first_proposal_;   // kNone: none
  alignas(64) Lanes<std::uint32_t> second_proposal_;  // within the slack of the nearest
  // The hits.
  alignas(64) Lanes<double> range_m_, cos_incidence_;
  alignas(64) Lanes<std::uint32_t> triangle_;

  Lanes<double> range_max_m_;
  const TriangleScene* scene_;
  RTCScene tree_;
  float slack_factor_, slack_m_;  // a ray goes on behind a proposal, to factor * range + slack
};

/// Fills in the facets, the enlarged corners and the slack of a scene that has its corners.
void prepare_for_exact_hits(TriangleScene& scene);

}  // namespace swiftlet::sim
