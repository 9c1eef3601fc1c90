// SPDX-License-Identifier: BSD-3-Clause
#include "sim/raycast/exact_hits_internal.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet::sim {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// What Embree hands to the callbacks; it knows the first member only.
struct ExactQuery::Context {
  RTCIntersectContext embree;
  ExactQuery* query;

  Context(ExactQuery* query_in, RTCFilterFunctionN callback) : query(query_in) {
    rtcInitIntersectContext(&embree);
    embree.filter = callback;
  }
};

namespace {

alignas(64) constexpr std::array<int, kPacketSize> kAllLanes = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                                -1, -1, -1, -1, -1, -1, -1, -1};

// Embree may pass a ray by a triangle, across the ray, within this part of the distance to its farthest corner: eight
// roundings to single precision.
constexpr double kRelativeError = 5e-7;
// Of what Facet::least_cosine_per_m counts with.
constexpr double kLargeTriangle_m = 1.0;
constexpr int kNeverFirm = 255;
constexpr double kFirmStep = 1.0 / 512.0;

/// Where a ray meets the plane of a facet.
struct PlaneHit {
  double range_m, cosine;
  bool visible;
};

// Rule 2. Without branches, for several rays at a time.
[[gnu::always_inline]] inline PlaneHit meet_plane(double ox, double oy, double oz, double dx, double dy, double dz,
                                                  const Facet& facet) {
  const double nx = facet.normal.x(), ny = facet.normal.y(), nz = facet.normal.z();
  const double height =
      (nx * (facet.corner_m.x() - ox) + ny * (facet.corner_m.y() - oy)) + nz * (facet.corner_m.z() - oz);
  const double approach = (nx * dx + ny * dy) + nz * dz;
  const double range_m = height / approach;
  const double cosine = std::abs(approach);
  const double least_cosine = facet.least_cosine_per_m * (range_m + kLargeTriangle_m);
  const bool visible =
      (range_m > 0.0) & (cosine >= least_cosine) & (cosine >= kLeastCosine) & (std::abs(height) >= kLeastHeight_m);
  return {range_m, cosine < 1.0 ? cosine : 1.0, visible};
}

}  // namespace

// ---- rays
// -------------------------------------------------------------------------------------------------------------

void ExactQuery::set_ray(int lane, const Vector3f& origin, const Vector3f& direction, double range_max_m) {
  origin_x_[lane] = origin.x(), origin_y_[lane] = origin.y(), origin_z_[lane] = origin.z();
  direction_x_[lane] = direction.x(), direction_y_[lane] = direction.y(), direction_z_[lane] = direction.z();
  range_max_m_[lane] = range_max_m;
  num_proposals_[lane] = 0;
  nearest_proposal_m_[lane] = static_cast<float>(range_max_m);
}

void ExactQuery::trace_singly(int count) {
  Context context(this, take_proposals);
  Coordinates u, v;
  for (int lane = 0; lane < count; ++lane) {
    RTCRayHit one;
    one.ray = single_ray(lane);
    one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(tree_, &context.embree, &one);
    u[lane] = one.hit.u;
    v[lane] = one.hit.v;
  }
  conclude(count, u.data(), v.data());
}

void ExactQuery::trace_together() {
  Context context(this, take_proposals);
  context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  auto packet = packet_from<RTCRayHit16>(0);
  rtcIntersect16(kAllLanes.data(), tree_, &context.embree, &packet);
  conclude(kPacketSize, packet.hit.u, packet.hit.v);
}

void ExactQuery::trace_scattered() {
  if (scene_->for_scattered_rays) tree_ = scene_->for_scattered_rays.get();
  Context context(this, take_proposals);
  Coordinates u, v;
  for (int first = 0; first < kPacketSize; first += 8) {
    auto packet = packet_from<RTCRayHit8>(first);
    rtcIntersect8(kAllLanes.data(), tree_, &context.embree, &packet);
    std::copy_n(packet.hit.u, 8, &u[first]);
    std::copy_n(packet.hit.v, 8, &v[first]);
  }
  conclude(kPacketSize, u.data(), v.data());
}

// Of the rays of as many lanes as it holds.
template <typename Packet>
Packet ExactQuery::packet_from(int lane) const {
  Packet packet;
  for (int i = 0; i < static_cast<int>(std::size(packet.ray.id)); ++i) {
    packet.ray.org_x[i] = origin_x_[lane + i];
    packet.ray.org_y[i] = origin_y_[lane + i];
    packet.ray.org_z[i] = origin_z_[lane + i];
    packet.ray.dir_x[i] = direction_x_[lane + i];
    packet.ray.dir_y[i] = direction_y_[lane + i];
    packet.ray.dir_z[i] = direction_z_[lane + i];
    packet.ray.tnear[i] = 0.0F;
    packet.ray.tfar[i] = with_slack_m(nearest_proposal_m_[lane + i]);
    packet.ray.time[i] = 0.0F;
    packet.ray.mask[i] = ~0U;
    packet.ray.id[i] = static_cast<unsigned int>(lane + i);
    packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  }
  return packet;
}

bool ExactQuery::is_blocked() {
  triangle_[0] = kNone;
  range_m_[0] = range_max_m_[0];
  Context context(this, judge_at_once);
  RTCRay ray = single_ray(0);
  rtcOccluded1(tree_, &context.embree, &ray);
  return met(0);
}

RTCRay ExactQuery::single_ray(int lane) const {
  RTCRay ray{};
  ray.org_x = origin_x_[lane];
  ray.org_y = origin_y_[lane];
  ray.org_z = origin_z_[lane];
  ray.dir_x = direction_x_[lane];
  ray.dir_y = direction_y_[lane];
  ray.dir_z = direction_z_[lane];
  ray.tfar = with_slack_m(static_cast<float>(range_max_m_[lane]));
  ray.mask = ~0U;
  ray.id = static_cast<unsigned int>(lane);
  return ray;
}

// How far Embree may be wrong about the range of a visible surface; the slack is twice that.
inline float ExactQuery::error_m(float range_m) const { return 0.5F * (slack_m_ + (slack_factor_ - 1.0F) * range_m); }

// ---- first pass: Embree proposes, the rule judges afterwards
// ------------------------------------------------------------------

namespace {

/// Vector registers of GCC and clang.
struct Sixteen {
  static constexpr unsigned int kLanes = 16;
  typedef float Floats __attribute__((vector_size(64)));
  typedef int Ints __attribute__((vector_size(64)));
};
struct Eight {
  static constexpr unsigned int kLanes = 8;
  typedef float Floats __attribute__((vector_size(32)));
  typedef int Ints __attribute__((vector_size(32)));
};

template <typename Register>
[[gnu::always_inline]] inline void load(const void* lanes, Register& to) {
  __builtin_memcpy(&to, lanes, sizeof to);
}
template <typename Register>
[[gnu::always_inline]] inline void store(const Register& from, void* lanes) {
  __builtin_memcpy(lanes, &from, sizeof from);
}

}  // namespace

// For neighboring lanes at once, in registers as wide as those that Embree has written the packet from: to read it lane
// by lane would wait for each of those stores.
template <typename Registers>
[[gnu::always_inline]] inline void ExactQuery::propose_at_once(const RTCFilterFunctionNArguments* args) {
  const auto lane = RTCRayN_id(args->ray, Registers::kLanes, 0);
  typename Registers::Floats tfar_m, nearest_m;
  typename Registers::Ints valid, triangle, count, first, second;
  load(&RTCRayN_tfar(args->ray, Registers::kLanes, 0), tfar_m);
  load(args->valid, valid);
  load(&RTCHitN_primID(args->hit, Registers::kLanes, 0), triangle);
  load(&nearest_proposal_m_[lane], nearest_m);
  load(&num_proposals_[lane], count);
  load(&first_proposal_[lane], first);
  load(&second_proposal_[lane], second);

  const typename Registers::Ints is_alone =  // those before are behind it for sure
      valid & ((tfar_m * slack_factor_ + slack_m_ < nearest_m) | (count == 0));
  const typename Registers::Ints is_second = valid & ~is_alone & (count == 1);
  const typename Registers::Ints is_nearest = valid & (tfar_m < nearest_m);
  nearest_m = is_nearest ? tfar_m : nearest_m;
  tfar_m = valid ? nearest_m * slack_factor_ + slack_m_ : tfar_m;

  store((is_second & triangle) | (~is_second & second), &second_proposal_[lane]);
  store((is_alone & triangle) | (~is_alone & first), &first_proposal_[lane]);
  store((is_alone & 1) | (~is_alone & (count - valid)), &num_proposals_[lane]);
  store(nearest_m, &nearest_proposal_m_[lane]);
  store(tfar_m, &RTCRayN_tfar(args->ray, Registers::kLanes, 0));
}

// The ray goes on a little way behind, because a proposal from there may be the nearer one.
inline void ExactQuery::propose(int lane, std::uint32_t triangle, float& tfar) {
  const float with_slack_m = tfar * slack_factor_ + slack_m_;
  if (num_proposals_[lane] == 0 || with_slack_m < nearest_proposal_m_[lane]) {
    num_proposals_[lane] = 1;
    first_proposal_[lane] = triangle;
  } else if (++num_proposals_[lane] == 2) {
    second_proposal_[lane] = triangle;
  }
  nearest_proposal_m_[lane] = std::min(nearest_proposal_m_[lane], tfar);
  tfar = nearest_proposal_m_[lane] * slack_factor_ + slack_m_;
}

namespace {

// Do the rays of a packet lie in neighboring lanes?
bool in_order(const RTCFilterFunctionNArguments* args) {
  const unsigned int* const lane = &RTCRayN_id(args->ray, args->N, 0);
  unsigned int differ = 0;
  for (unsigned int i = 1; i < args->N; ++i) differ |= lane[i] ^ (lane[0] + i);
  return differ == 0;
}

}  // namespace

#if defined(__GNUC__) && !defined(__clang__)
#define SWIFTLET_TARGET(name) [[gnu::target(name)]]
#else
#define SWIFTLET_TARGET(name)
#endif

SWIFTLET_TARGET("avx512f,avx512vl,avx512dq")
void ExactQuery::take_sixteen(ExactQuery& query, const RTCFilterFunctionNArguments* args) {
  query.propose_at_once<Sixteen>(args);
}

SWIFTLET_TARGET("avx2")
void ExactQuery::take_eight(ExactQuery& query, const RTCFilterFunctionNArguments* args) {
  query.propose_at_once<Eight>(args);
}

// Embree's callback for every enlarged triangle that rays meet before their `tfar`. A packet is as wide as the
// registers that Embree has found on this processor.
void ExactQuery::take_proposals(const RTCFilterFunctionNArguments* args) {
  ExactQuery& query = *reinterpret_cast<const Context*>(args->context)->query;
  const unsigned int count = args->N;
  if (count == 16 && in_order(args)) return take_sixteen(query, args);
  if (count == 8 && in_order(args)) return take_eight(query, args);
  for (unsigned int i = 0; i < count; ++i) {
    if (args->valid[i] == 0) continue;
    query.propose(static_cast<int>(RTCRayN_id(args->ray, count, i)), RTCHitN_primID(args->hit, count, i),
                  RTCRayN_tfar(args->ray, count, i));
  }
}

void ExactQuery::conclude(int count, const float* u, const float* v) {
  fetch(count);
  std::array<bool, kPacketSize> visible;
  if (count == kPacketSize) {
    judge_planes(range_m_, cos_incidence_, visible);
  } else {
    visible.fill(false);
  }
  std::array<bool, kPacketSize> in_full;
  for (int lane = 0; lane < count; ++lane) {
    triangle_[lane] = kNone;
    in_full[lane] = false;
    if (num_proposals_[lane] == 0) continue;  // whoever meets no enlarged triangle meets none
    const std::uint32_t triangle = first_proposal_[lane];
    const int steps = scene_->facets[triangle].firm_steps;
    const float firm = steps == kNeverFirm ? 2.0F : static_cast<float>(kFirmStep) * static_cast<float>(steps);
    const bool inside = std::min(std::min(u[lane], v[lane]), 1.0F - u[lane] - v[lane]) >= firm;
    if (num_proposals_[lane] == 1 && visible[lane] && inside && range_m_[lane] <= range_max_m_[lane]) {
      triangle_[lane] = triangle;
    } else {
      in_full[lane] = true;
      __builtin_prefetch(&scene_->corners_m[triangle]);
    }
  }
  for (int lane = 0; lane < count; ++lane) {
    if (in_full[lane]) judge_in_full(lane);
  }
}

// Asks the memory for what the rule is going to read of the proposals.
void ExactQuery::fetch(int count) const {
  for (int lane = 0; lane < count; ++lane) {
    if (num_proposals_[lane] == 0) continue;
    __builtin_prefetch(&scene_->facets[first_proposal_[lane]]);
    if (num_proposals_[lane] != 2) continue;
    __builtin_prefetch(&scene_->corners_m[first_proposal_[lane]]);
    __builtin_prefetch(&scene_->facets[second_proposal_[lane]]);
    __builtin_prefetch(&scene_->corners_m[second_proposal_[lane]]);
  }
}

// Where the rays meet the planes of their first proposals.
void ExactQuery::judge_planes(Lanes& range_m, Lanes& cosine, std::array<bool, kPacketSize>& visible) const {
  static const Facet kNowhere{};
  for (int i = 0; i < kPacketSize; ++i) {
    const Facet& facet = num_proposals_[i] > 0 ? scene_->facets[first_proposal_[i]] : kNowhere;
    const PlaneHit hit =
        meet_plane(origin_x_[i], origin_y_[i], origin_z_[i], direction_x_[i], direction_y_[i], direction_z_[i], facet);
    range_m[i] = hit.range_m;
    cosine[i] = hit.cosine;
    visible[i] = hit.visible;
  }
}

// Several proposals, or one near an edge.
void ExactQuery::judge_in_full(int lane) {
  triangle_[lane] = kNone;
  range_m_[lane] = range_max_m_[lane];
  const int num_proposals = num_proposals_[lane];
  if (num_proposals <= 2) judge(lane, first_proposal_[lane]);
  if (num_proposals == 2) judge(lane, second_proposal_[lane]);
  // Embree has looked farther than that behind the nearest proposal.
  const double certain_m = nearest_proposal_m_[lane] + error_m(nearest_proposal_m_[lane]);
  if (!met(lane) || range_m_[lane] > certain_m) trace_again(lane);
}

// True: the nearest so far.
bool ExactQuery::judge(int lane, std::uint32_t triangle) {
  const PlaneHit hit = meet_plane(origin_x_[lane], origin_y_[lane], origin_z_[lane], direction_x_[lane],
                                  direction_y_[lane], direction_z_[lane], scene_->facets[triangle]);
  if (!hit.visible || hit.range_m > range_m_[lane]) return false;
  if (hit.range_m == range_m_[lane] && triangle > triangle_[lane]) return false;
  if (!passes_inside(lane, triangle)) return false;
  range_m_[lane] = hit.range_m;
  cos_incidence_[lane] = hit.cosine;
  triangle_[lane] = triangle;
  return true;
}

// Rule 1. Corners are taken relative to the origin first: the same numbers for all triangles that have the corner.
bool ExactQuery::passes_inside(int lane, std::uint32_t triangle) const {
  const auto& corners_m = scene_->corners_m[triangle];
  const Vector3d origin(origin_x_[lane], origin_y_[lane], origin_z_[lane]);
  const Vector3d direction(direction_x_[lane], direction_y_[lane], direction_z_[lane]);
  const Vector3d a = corners_m[0].cast<double>() - origin, b = corners_m[1].cast<double>() - origin,
                 c = corners_m[2].cast<double>() - origin;
  const double ab = direction.dot(a.cross(b)), bc = direction.dot(b.cross(c)), ca = direction.dot(c.cross(a));
  return (ab >= 0.0 && bc >= 0.0 && ca >= 0.0) || (ab <= 0.0 && bc <= 0.0 && ca <= 0.0);
}

// ---- second pass: the rule judges each proposal before Embree goes on
// ------------------------------------------------------------

void ExactQuery::trace_again(int lane) {
  triangle_[lane] = kNone;
  range_m_[lane] = range_max_m_[lane];
  Context context(this, judge_at_once);
  RTCRayHit one;
  one.ray = single_ray(lane);
  // Nothing lies before the nearest proposal.
  one.ray.tnear = std::max(nearest_proposal_m_[lane] - error_m(nearest_proposal_m_[lane]), 0.0F);
  one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(tree_, &context.embree, &one);
}

// Embree's callback for single rays. What the rule rejects does not stop the ray.
void ExactQuery::judge_at_once(const RTCFilterFunctionNArguments* args) {
  ExactQuery& query = *reinterpret_cast<const Context*>(args->context)->query;
  const auto lane = static_cast<int>(RTCRayN_id(args->ray, 1, 0));
  if (query.judge(lane, RTCHitN_primID(args->hit, 1, 0))) {
    RTCRayN_tfar(args->ray, 1, 0) = query.with_slack_m(static_cast<float>(query.range_m_[lane]));
  } else {
    args->valid[0] = 0;
  }
}

// ---- what Embree traces
// -----------------------------------------------------------------------------------------------

namespace {

/// Lengths of a triangle.
struct Measures {
  int apex = 0;  // opposite to the longest side
  double side_m[3];
  double base_m = 0.0, height_m = 0.0, perimeter_m = 0.0, area_m2 = 0.0;

  explicit Measures(const Vector3d (&corner)[3]) {
    for (int i = 0; i < 3; ++i) side_m[i] = (corner[(i + 2) % 3] - corner[(i + 1) % 3]).norm();
    apex = static_cast<int>(std::max_element(side_m, side_m + 3) - side_m);
    base_m = side_m[apex];
    perimeter_m = side_m[0] + side_m[1] + side_m[2];
    area_m2 = 0.5 * (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm();
    height_m = base_m > 0.0 ? 2.0 * area_m2 / base_m : 0.0;
  }
};

// All sides move outwards alike: the triangle grows about the center of its incircle, of radius 2 area / perimeter.
std::array<Vector3f, 3> grown(const Vector3d (&corner)[3], const Measures& m, double growth) {
  const Vector3d center = (m.side_m[0] * corner[0] + m.side_m[1] * corner[1] + m.side_m[2] * corner[2]) / m.perimeter_m;
  std::array<Vector3f, 3> out;
  for (int i = 0; i < 3; ++i) out[i] = (center + growth * (corner[i] - center)).cast<float>();
  return out;
}

// A splinter would grow very long. Instead the smallest triangle about the rectangle that holds it and its margin.
std::array<Vector3f, 3> wrapped(const Vector3d (&corner)[3], const Measures& m, double margin_m) {
  const Vector3d& foot = corner[(m.apex + 1) % 3];
  const Vector3d along =
      m.base_m > 0.0 ? Vector3d((corner[(m.apex + 2) % 3] - foot) / m.base_m) : Vector3d(Vector3d::UnitX());
  const Vector3d to_apex = corner[m.apex] - foot;
  Vector3d up = to_apex - along.dot(to_apex) * along;
  up = up.norm() > 1e-9 * m.base_m ? Vector3d(up.normalized()) : Vector3d(along.unitOrthogonal());
  const Vector3d middle = foot + 0.5 * m.base_m * along - margin_m * up;
  const Vector3d half = (m.base_m + 2.0 * margin_m) * along;
  return {(middle - half).cast<float>(), (middle + half).cast<float>(),
          (middle + 2.0 * (m.height_m + 2.0 * margin_m) * up).cast<float>()};
}

/// @param least_margin_m  more than the corners' rounding to single precision
/// @return the longest side
double prepare(const std::array<Vector3f, 3>& corners_m, double least_margin_m, Facet& facet,
               std::array<Vector3f, 3>& enlarged_m) {
  const Vector3d corner[3] = {corners_m[0].cast<double>(), corners_m[1].cast<double>(), corners_m[2].cast<double>()};
  const Measures m(corner);
  const double radius_m = m.perimeter_m > 0.0 ? 2.0 * m.area_m2 / m.perimeter_m : 0.0;  // of the incircle
  // Large triangles are seen from afar and at grazing angles; a fiftieth costs them little.
  const double margin_m = std::max(least_margin_m, 0.02 * radius_m);
  facet.corner_m = corners_m[0];
  const Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  facet.normal = m.area_m2 > 0.0 ? Vector3f((normal / normal.norm()).cast<float>()) : Vector3f(Vector3f::Zero());
  facet.least_cosine_per_m = static_cast<float>(kRelativeError / margin_m * std::max(1.0, m.base_m / kLargeTriangle_m));
  const double growth = 1.0 + margin_m / radius_m;
  const double wrapped_area_m2 = 2.0 * (m.base_m + 2.0 * margin_m) * (m.height_m + 2.0 * margin_m);
  if (m.area_m2 > 0.0 && m.area_m2 * growth * growth <= wrapped_area_m2) {
    enlarged_m = grown(corner, m, growth);
    const double firm_steps = std::ceil(2.0 * margin_m / (growth * m.height_m) / kFirmStep);
    facet.firm_steps = static_cast<std::uint32_t>(std::min<double>(firm_steps, kNeverFirm)) & 0xFFU;
  } else {
    enlarged_m = wrapped(corner, m, margin_m);
    facet.firm_steps = kNeverFirm;
  }
  return m.base_m;
}

}  // namespace

void prepare_for_exact_hits(TriangleScene& scene) {
  Eigen::AlignedBox3f box;
  for (const auto& corners_m : scene.corners_m) {
    for (const Vector3f& corner : corners_m) box.extend(corner);
  }
  const double farthest_m = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).cast<double>().norm();
  const double rounding_m = 1.2e-7 * farthest_m;  // of a corner in single precision
  const double least_margin_m = 2e-4 + 2.0 * rounding_m;
  scene.enlarged_m.resize(scene.size());
  scene.enlarged_m.reserve(scene.size() + 1);  // Embree reads 16 bytes at the last corner
  const auto count = static_cast<std::int64_t>(scene.size());
  double longest_m = 0.0;
#pragma omp parallel for schedule(static) reduction(max : longest_m) if (count > 10'000)
  for (std::int64_t i = 0; i < count; ++i) {
    longest_m = std::max(longest_m, prepare(scene.corners_m[i], least_margin_m, scene.facets[i], scene.enlarged_m[i]));
  }
  scene.slack_m = static_cast<float>(1e-3 + 2.0 * (kRelativeError * longest_m + rounding_m) / kLeastCosine);
}

}  // namespace swiftlet::sim
