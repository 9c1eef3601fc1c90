// SPDX-License-Identifier: BSD-3-Clause
#include "sim/raycast/exact_hits_internal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace swiftlet::sim {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Context passed by Embree to the callbacks; Embree uses only the first member.
struct ExactQuery::Context {
  EmbreeQuery embree;
  ExactQuery* query;
  const void* packet = nullptr;  // rays in consecutive lanes
  int packet_size = 0, first_lane = 0;

  Context(ExactQuery* query_in, RTCFilterFunctionN callback) : embree(callback), query(query_in) {}
};

namespace {

alignas(64) constexpr std::array<int, kPacketSize> kAllLanes = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                                -1, -1, -1, -1, -1, -1, -1, -1};

// Bound of Embree's error across the ray, relative to the distance of the triangle's farthest corner: eight roundings
// in single precision. A ray may miss a triangle by this.
constexpr double kRelativeError = 5e-7;
// Range offset in the definition of Facet::least_cosine_per_m.
constexpr double kLargeTriangle_m = 1.0;
constexpr int kNeverFirm = 255;
// [-] Resolution of the margin stored in a Facet.
constexpr double kFirmStep = 1.0 / 512.0;

/// Vector registers of GCC and clang.
typedef double Doubles __attribute__((vector_size(32)));
typedef long long Masks __attribute__((vector_size(32)));
struct Eight {
  static constexpr unsigned int kLanes = 8;
  typedef float Floats __attribute__((vector_size(32)));
  typedef int Ints __attribute__((vector_size(32)));
};
struct Sixteen {
  static constexpr unsigned int kLanes = 16;
  typedef float Floats __attribute__((vector_size(64)));
  typedef int Ints __attribute__((vector_size(64)));
};

template <typename Register>
[[gnu::always_inline]] inline void load(const void* lanes, Register& to) {
  __builtin_memcpy(&to, lanes, sizeof to);
}
template <typename Register>
[[gnu::always_inline]] inline void store(const Register& from, void* lanes) {
  __builtin_memcpy(lanes, &from, sizeof from);
}

/// Intersection of a ray with the plane of a facet.
struct PlaneHit {
  double range_m, cosine;
  bool visible;
};

// Rule 2. test_proposals() evaluates it for several rays at once.
PlaneHit meet_plane(double ox, double oy, double oz, double dx, double dy, double dz, const Facet& facet) {
  const double nx = facet.normal.x(), ny = facet.normal.y(), nz = facet.normal.z();
  const double height =
      (nx * (facet.corner_m.x() - ox) + ny * (facet.corner_m.y() - oy)) + nz * (facet.corner_m.z() - oz);
  const double approach = (nx * dx + ny * dy) + nz * dz;
  const double range_m = height / approach;
  const double cosine = std::abs(approach);
  const double least_cosine = facet.least_cosine_per_m * (range_m + kLargeTriangle_m);
  const bool visible =
      (range_m > 0.0) & (cosine >= least_cosine) & (cosine >= kMinCosine) & (std::abs(height) >= kMinHeight_m);
  return {range_m, cosine < 1.0 ? cosine : 1.0, visible};
}

}  // namespace

// ---- rays ----

void ExactQuery::set_ray(int lane, const Vector3f& origin, const Vector3f& direction, double range_max_m) {
  RTCRay16& rays = packet_.ray;
  rays.org_x[lane] = origin.x(), rays.org_y[lane] = origin.y(), rays.org_z[lane] = origin.z();
  rays.dir_x[lane] = direction.x(), rays.dir_y[lane] = direction.y(), rays.dir_z[lane] = direction.z();
  range_max_m_[lane] = range_max_m;
}

void ExactQuery::set_rays(const Rays& rays, const std::array<float, kPacketSize>& range_max_m) {
  const auto copy = [](const std::array<float, kPacketSize>& from, float* to) {
    std::copy_n(from.data(), kPacketSize, to);
  };
  copy(rays.origin_x, packet_.ray.org_x);
  copy(rays.origin_y, packet_.ray.org_y);
  copy(rays.origin_z, packet_.ray.org_z);
  copy(rays.direction_x, packet_.ray.dir_x);
  copy(rays.direction_y, packet_.ray.dir_y);
  copy(rays.direction_z, packet_.ray.dir_z);
  std::copy_n(range_max_m.data(), kPacketSize, range_max_m_.data());
}

void ExactQuery::trace_singly(int count) {
  for (int lane = 0; lane < count; ++lane) {
    nearest_proposal_m_[lane] = 0.0F;
    trace_again(lane);
  }
}

void ExactQuery::trace_together() {
  begin();
  Context context(this, take_proposals);
  context.embree.coherent = true;
  context.packet = &packet_;
  context.packet_size = kPacketSize;
  intersect(kAllLanes.data(), tree_, context.embree, packet_);
  conclude();
}

void ExactQuery::trace_scattered() {
  begin();
  if (scene_->for_scattered_rays) tree_ = scene_->for_scattered_rays.get();
  Context context(this, take_proposals);
  for (int first = 0; first < kPacketSize; first += 8) {
    auto packet = packet_from<RTCRayHit8>(first);
    context.packet = &packet;
    context.packet_size = 8;
    context.first_lane = first;
    intersect(kAllLanes.data(), tree_, context.embree, packet);
    std::copy_n(packet.hit.u, 8, &packet_.hit.u[first]);
    std::copy_n(packet.hit.v, 8, &packet_.hit.v[first]);
  }
  conclude();
}

// Resets the proposals.
void ExactQuery::begin() {
  for (int i = 0; i < kPacketSize; ++i) {
    packet_.ray.tnear[i] = 0.0F;
    packet_.ray.tfar[i] = with_slack_m(static_cast<float>(range_max_m_[i]));
    packet_.ray.time[i] = 0.0F;
    packet_.ray.mask[i] = ~0U;
    packet_.ray.id[i] = static_cast<unsigned int>(i);
    packet_.ray.flags[i] = 0;
    packet_.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet_.hit.u[i] = packet_.hit.v[i] = 0.0F;
    nearest_proposal_m_[i] = std::numeric_limits<float>::infinity();
    first_proposal_[i] = second_proposal_[i] = kNone;
  }
}

// Loads as many rays as Packet has lanes.
template <typename Packet>
Packet ExactQuery::packet_from(int lane) const {
  Packet packet;
  const auto copy = [lane](const auto& from, auto& to) { std::copy_n(&from[lane], std::size(to), to); };
  copy(packet_.ray.org_x, packet.ray.org_x);
  copy(packet_.ray.org_y, packet.ray.org_y);
  copy(packet_.ray.org_z, packet.ray.org_z);
  copy(packet_.ray.dir_x, packet.ray.dir_x);
  copy(packet_.ray.dir_y, packet.ray.dir_y);
  copy(packet_.ray.dir_z, packet.ray.dir_z);
  copy(packet_.ray.tnear, packet.ray.tnear);
  copy(packet_.ray.tfar, packet.ray.tfar);
  copy(packet_.ray.time, packet.ray.time);
  copy(packet_.ray.mask, packet.ray.mask);
  copy(packet_.ray.id, packet.ray.id);
  copy(packet_.ray.flags, packet.ray.flags);
  copy(packet_.hit.geomID, packet.hit.geomID);
  return packet;
}

bool ExactQuery::is_blocked() {
  triangle_[0] = kNone;
  range_m_[0] = range_max_m_[0];
  Context context(this, test_immediately);
  RTCRay ray = single_ray(0);
  occluded(tree_, context.embree, ray);
  return met(0);
}

RTCRay ExactQuery::single_ray(int lane) const {
  RTCRay ray{};
  ray.org_x = packet_.ray.org_x[lane];
  ray.org_y = packet_.ray.org_y[lane];
  ray.org_z = packet_.ray.org_z[lane];
  ray.dir_x = packet_.ray.dir_x[lane];
  ray.dir_y = packet_.ray.dir_y[lane];
  ray.dir_z = packet_.ray.dir_z[lane];
  ray.tfar = with_slack_m(static_cast<float>(range_max_m_[lane]));
  ray.mask = ~0U;
  ray.id = static_cast<unsigned int>(lane);
  return ray;
}

// Bound of Embree's range error for a visible surface; the slack is twice that.
inline float ExactQuery::error_m(float range_m) const { return 0.5F * (slack_m_ + (slack_factor_ - 1.0F) * range_m); }

// ---- first pass: Embree proposes, the rule tests afterwards ----

// Processes consecutive lanes at once, in registers as wide as those with which Embree has written the packet: reading
// single lanes would stall on each of those stores.
template <typename Registers>
[[gnu::always_inline]] inline void ExactQuery::propose_at_once(int lane, const RTCFilterFunctionNArguments* args) {
  typename Registers::Floats tfar_m, nearest_m;
  typename Registers::Ints valid, triangle, first, second;
  load(&RTCRayN_tfar(args->ray, Registers::kLanes, 0), tfar_m);
  load(args->valid, valid);
  load(&RTCHitN_primID(args->hit, Registers::kLanes, 0), triangle);
  load(&nearest_proposal_m_[lane], nearest_m);
  load(&first_proposal_[lane], first);
  load(&second_proposal_[lane], second);
  // Prefetches data for the rule. Embree proposes one triangle to all lanes.
  __builtin_prefetch(&scene_->facets[RTCHitN_primID(args->hit, Registers::kLanes, 0)]);

  const typename Registers::Ints is_alone =  // earlier proposals lie behind it in any case
      valid & (tfar_m * slack_factor_ + slack_m_ < nearest_m);
  const typename Registers::Ints joins = valid & ~is_alone;
  const typename Registers::Ints next = second == static_cast<int>(kNone) ? triangle : static_cast<int>(kSeveral);
  nearest_m = (valid & (tfar_m < nearest_m)) ? tfar_m : nearest_m;
  store(is_alone | (joins & next) | (~valid & second), &second_proposal_[lane]);
  store((is_alone & triangle) | (~is_alone & first), &first_proposal_[lane]);
  store(nearest_m, &nearest_proposal_m_[lane]);
  store(valid ? nearest_m * slack_factor_ + slack_m_ : tfar_m, &RTCRayN_tfar(args->ray, Registers::kLanes, 0));
}

// The ray continues for the slack beyond a proposal, because a proposal from there may be the nearer one.
inline void ExactQuery::propose(int lane, std::uint32_t triangle, float& tfar) {
  if (with_slack_m(tfar) < nearest_proposal_m_[lane]) {
    first_proposal_[lane] = triangle;
    second_proposal_[lane] = kNone;
  } else {
    second_proposal_[lane] = second_proposal_[lane] == kNone ? triangle : kSeveral;
  }
  nearest_proposal_m_[lane] = std::min(nearest_proposal_m_[lane], tfar);
  tfar = with_slack_m(nearest_proposal_m_[lane]);
}

#if defined(__GNUC__) && !defined(__clang__)
#define SWIFTLET_TARGET(name) [[gnu::target(name)]]
#else
#define SWIFTLET_TARGET(name)
#endif

SWIFTLET_TARGET("avx512f,avx512vl,avx512dq")
void ExactQuery::take_sixteen(ExactQuery& query, int lane, const RTCFilterFunctionNArguments* args) {
  query.propose_at_once<Sixteen>(lane, args);
}

SWIFTLET_TARGET("avx2")
void ExactQuery::take_eight(ExactQuery& query, int lane, const RTCFilterFunctionNArguments* args) {
  query.propose_at_once<Eight>(lane, args);
}

// Embree's callback for every enlarged triangle that rays meet before their `tfar`. A packet as wide as Embree's
// registers on this processor is passed unchanged, others in parts.
void ExactQuery::take_proposals(const RTCFilterFunctionNArguments* args) {
  const Context& context = *reinterpret_cast<const Context*>(args->context);
  ExactQuery& query = *context.query;
  const unsigned int count = args->N;
  if (args->ray == context.packet && static_cast<int>(count) == context.packet_size) {
    if (count == 16) return take_sixteen(query, context.first_lane, args);
    if (count == 8) return take_eight(query, context.first_lane, args);
  }
  for (unsigned int i = 0; i < count; ++i) {
    if (args->valid[i] == 0) continue;
    query.propose(static_cast<int>(RTCRayN_id(args->ray, count, i)), RTCHitN_primID(args->hit, count, i),
                  RTCRayN_tfar(args->ray, count, i));
  }
}

// Most rays have one proposal, far from its edges. Only the others are tested in full.
void ExactQuery::conclude() {
  for (int lane = 0; lane < kPacketSize; lane += 8) test_proposals(lane);
  int in_full[kPacketSize];
  int num_in_full = 0;
  for (int lane = 0; lane < kPacketSize; ++lane) {
    if (triangle_[lane] != kSeveral) continue;
    in_full[num_in_full++] = lane;
    // Prefetches data for the rule.
    __builtin_prefetch(&scene_->corners_m[first_proposal_[lane]]);
    if (second_proposal_[lane] >= kSeveral) continue;
    __builtin_prefetch(&scene_->facets[second_proposal_[lane]]);
    __builtin_prefetch(&scene_->corners_m[second_proposal_[lane]]);
  }
  for (int i = 0; i < num_in_full; ++i) test_in_full(in_full[i]);
}

namespace {

typedef int Four __attribute__((vector_size(16)));

// Transposes a matrix of eight rows.
[[gnu::always_inline]] inline void transpose(Eight::Floats (&row)[8]) {
  Eight::Floats pair[8], four[8];
  for (int i = 0; i < 8; i += 2) {
    pair[i] = __builtin_shufflevector(row[i], row[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
    pair[i + 1] = __builtin_shufflevector(row[i], row[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
  }
  for (int i = 0; i < 8; i += 4) {
    for (int k = 0; k < 2; ++k) {
      four[i + 2 * k] = __builtin_shufflevector(pair[i + k], pair[i + 2 + k], 0, 1, 8, 9, 4, 5, 12, 13);
      four[i + 2 * k + 1] = __builtin_shufflevector(pair[i + k], pair[i + 2 + k], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  }
  for (int i = 0; i < 4; ++i) {
    row[i] = __builtin_shufflevector(four[i], four[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    row[i + 4] = __builtin_shufflevector(four[i], four[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

template <int kHalf>
[[gnu::always_inline]] inline Doubles half_of(const Eight::Floats& lanes) {
  constexpr int k = 4 * kHalf;
  return __builtin_convertvector(__builtin_shufflevector(lanes, lanes, k, k + 1, k + 2, k + 3), Doubles);
}

}  // namespace

// Rule 2 for eight lanes, and rule 1 where a ray is certainly inside. Undecided lanes get triangle_ = kSeveral.
void ExactQuery::test_proposals(int first_lane) {
  static const Facet kNoFacet{};
  Eight::Floats facet[8];  // after transpose: corner, normal, least_cosine_per_m, surface and firm_steps of all lanes
  for (int i = 0; i < 8; ++i) {
    const std::uint32_t triangle = first_proposal_[first_lane + i];
    load(triangle == kNone ? &kNoFacet : &scene_->facets[triangle], facet[i]);
  }
  transpose(facet);
  Eight::Ints steps, first, second;
  Eight::Floats u, v;
  load(&facet[7], steps);
  load(&first_proposal_[first_lane], first);
  load(&second_proposal_[first_lane], second);
  load(&packet_.hit.u[first_lane], u);
  load(&packet_.hit.v[first_lane], v);
  steps = (steps >> 24) & 0xFF;
  const Eight::Floats margin = steps == kNeverFirm ? 2.0F : __builtin_convertvector(steps, Eight::Floats) * 0x1p-9F;
  const Eight::Floats w = 1.0F - u - v, uv = u < v ? u : v, inner = uv < w ? uv : w;

  const auto test_four = [&](auto half, int lane) __attribute__((always_inline)) {
    constexpr int kHalf = decltype(half)::value;
    Eight::Floats of_eight;
    const auto rays = [&](const float* lanes) __attribute__((always_inline)) {
      load(&lanes[first_lane], of_eight);
      return half_of<kHalf>(of_eight);
    };
    const RTCRay16& ray = packet_.ray;
    const Doubles nx = half_of<kHalf>(facet[3]), ny = half_of<kHalf>(facet[4]), nz = half_of<kHalf>(facet[5]);
    const Doubles height =
        (nx * (half_of<kHalf>(facet[0]) - rays(ray.org_x)) + ny * (half_of<kHalf>(facet[1]) - rays(ray.org_y))) +
        nz * (half_of<kHalf>(facet[2]) - rays(ray.org_z));
    const Doubles approach = (nx * rays(ray.dir_x) + ny * rays(ray.dir_y)) + nz * rays(ray.dir_z);
    const Doubles range_m = height / approach;
    const Doubles cosine = approach < 0.0 ? -approach : approach;
    const Doubles least_cosine = half_of<kHalf>(facet[6]) * (range_m + kLargeTriangle_m);
    Doubles range_max_m;
    load(&range_max_m_[lane], range_max_m);
    const Masks visible = (range_m > 0.0) & (cosine >= least_cosine) & (cosine >= kMinCosine) &
                          ((height >= kMinHeight_m) | (height <= -kMinHeight_m)) & (range_m <= range_max_m);
    // The true edges lie half of `margin` inside the enlarged ones, whose corners are rounded by at most an eighth of
    // it. Embree's error is less than half, and only for rays near the visibility limit.
    const Masks inside =
        half_of<kHalf>(inner) * cosine >= half_of<kHalf>(margin) * (0.625 * cosine + 0.5 * least_cosine);
    store(range_m, &range_m_[lane]);
    store(cosine < 1.0 ? cosine : Doubles{} + 1.0, &cos_incidence_[lane]);
    return __builtin_convertvector(visible & inside, Four);
  };
  const Four low = test_four(std::integral_constant<int, 0>(), first_lane);
  const Four high = test_four(std::integral_constant<int, 1>(), first_lane + 4);
  const Eight::Ints sure =
      __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7) & (second == static_cast<int>(kNone));
  const Eight::Ints none = first == static_cast<int>(kNone);
  store((sure & first) | (~sure & (none | static_cast<int>(kSeveral))), &triangle_[first_lane]);
}

// Tests several proposals, or one near an edge.
void ExactQuery::test_in_full(int lane) {
  triangle_[lane] = kNone;
  range_m_[lane] = range_max_m_[lane];
  const std::uint32_t second = second_proposal_[lane];
  if (second != kSeveral) test(lane, first_proposal_[lane]);
  if (second < kSeveral) test(lane, second);
  // Embree has searched beyond this distance behind the nearest proposal.
  const double certain_m = nearest_proposal_m_[lane] + error_m(nearest_proposal_m_[lane]);
  if (!met(lane) || range_m_[lane] > certain_m) trace_again(lane);
}

// @return whether the triangle is the nearest so far
bool ExactQuery::test(int lane, std::uint32_t triangle) {
  const RTCRay16& ray = packet_.ray;
  const PlaneHit hit = meet_plane(ray.org_x[lane], ray.org_y[lane], ray.org_z[lane], ray.dir_x[lane], ray.dir_y[lane],
                                  ray.dir_z[lane], scene_->facets[triangle]);
  if (!hit.visible || hit.range_m > range_m_[lane]) return false;
  if (hit.range_m == range_m_[lane] && triangle > triangle_[lane]) return false;
  if (!passes_inside(lane, triangle)) return false;
  range_m_[lane] = hit.range_m;
  cos_incidence_[lane] = hit.cosine;
  triangle_[lane] = triangle;
  return true;
}

// Rule 1. Corners are taken relative to the origin first, which gives equal numbers for all triangles that share a
// corner.
bool ExactQuery::passes_inside(int lane, std::uint32_t triangle) const {
  const auto& corners_m = scene_->corners_m[triangle];
  const RTCRay16& ray = packet_.ray;
  const Vector3d origin(ray.org_x[lane], ray.org_y[lane], ray.org_z[lane]);
  const Vector3d direction(ray.dir_x[lane], ray.dir_y[lane], ray.dir_z[lane]);
  const Vector3d a = corners_m[0].cast<double>() - origin, b = corners_m[1].cast<double>() - origin,
                 c = corners_m[2].cast<double>() - origin;
  const double ab = direction.dot(a.cross(b)), bc = direction.dot(b.cross(c)), ca = direction.dot(c.cross(a));
  return (ab >= 0.0 && bc >= 0.0 && ca >= 0.0) || (ab <= 0.0 && bc <= 0.0 && ca <= 0.0);
}

// ---- second pass: the rule tests each proposal before Embree continues ----

void ExactQuery::trace_again(int lane) {
  triangle_[lane] = kNone;
  range_m_[lane] = range_max_m_[lane];
  Context context(this, test_immediately);
  RTCRayHit one;
  one.ray = single_ray(lane);
  // Starts just before the nearest proposal.
  one.ray.tnear = std::max(nearest_proposal_m_[lane] - error_m(nearest_proposal_m_[lane]), 0.0F);
  one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  intersect(tree_, context.embree, one);
}

// Embree's callback for single rays. A rejected triangle does not stop the ray.
void ExactQuery::test_immediately(const RTCFilterFunctionNArguments* args) {
  ExactQuery& query = *reinterpret_cast<const Context*>(args->context)->query;
  const auto lane = static_cast<int>(RTCRayN_id(args->ray, 1, 0));
  if (query.test(lane, RTCHitN_primID(args->hit, 1, 0))) {
    RTCRayN_tfar(args->ray, 1, 0) = query.with_slack_m(static_cast<float>(query.range_m_[lane]));
  } else {
    args->valid[0] = 0;
  }
}

// ---- triangles for Embree ----

namespace {

/// Dimensions of a triangle.
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

// Moves all sides outwards by the same distance: scales the triangle about the center of its incircle, of radius 2 area
// / perimeter.
std::array<Vector3f, 3> grown(const Vector3d (&corner)[3], const Measures& m, double growth) {
  const Vector3d center = (m.side_m[0] * corner[0] + m.side_m[1] * corner[1] + m.side_m[2] * corner[2]) / m.perimeter_m;
  std::array<Vector3f, 3> out;
  for (int i = 0; i < 3; ++i) out[i] = (center + growth * (corner[i] - center)).cast<float>();
  return out;
}

// Growing a splinter would make it very long. Instead returns the smallest triangle around the rectangle that holds it
// and its margin.
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
/// @return length of the longest side
double prepare(const std::array<Vector3f, 3>& corners_m, double least_margin_m, Facet& facet,
               std::array<Vector3f, 3>& enlarged_m) {
  const Vector3d corner[3] = {corners_m[0].cast<double>(), corners_m[1].cast<double>(), corners_m[2].cast<double>()};
  const Measures m(corner);
  const double radius_m = m.perimeter_m > 0.0 ? 2.0 * m.area_m2 / m.perimeter_m : 0.0;  // radius of the incircle
  // Large triangles are met from afar and at grazing angles; growth by a fiftieth of the incircle costs little.
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
  const double rounding_m = 1.2e-7 * farthest_m;  // rounding of a corner to single precision
  const double least_margin_m = 2e-4 + 2.0 * rounding_m;
  scene.enlarged_m.resize(scene.size());
  scene.enlarged_m.reserve(scene.size() + 1);  // Embree reads 16 bytes at the last corner
  const auto count = static_cast<std::int64_t>(scene.size());
  double longest_m = 0.0;
#pragma omp parallel for schedule(static) reduction(max : longest_m) if (count > 10'000)
  for (std::int64_t i = 0; i < count; ++i) {
    longest_m = std::max(longest_m, prepare(scene.corners_m[i], least_margin_m, scene.facets[i], scene.enlarged_m[i]));
  }
  scene.slack_m = static_cast<float>(1e-3 + 2.0 * (kRelativeError * longest_m + rounding_m) / kMinCosine);
}

}  // namespace swiftlet::sim
