// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

/// Internal to sim/raycast: differences between Embree 3 and Embree 4. Embree 3 keeps context, flags and filter of a
/// query in one structure; Embree 4 separates the context from the arguments.
namespace swiftlet::sim {

#if RTC_VERSION_MAJOR >= 4

using EmbreeContext = RTCRayQueryContext;
inline constexpr auto kFilterInArguments = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

/// Context and options of one query. The context is the first member, so that a filter can cast its address to the
/// containing structure.
struct EmbreeQuery {
  EmbreeContext context;
  RTCFilterFunctionN filter;  ///< may be null
  bool coherent = false;      ///< the rays of a packet have similar directions

  explicit EmbreeQuery(RTCFilterFunctionN filter_in = nullptr) : filter(filter_in) { rtcInitRayQueryContext(&context); }

  /// For RTCIntersectArguments and RTCOccludedArguments, whose members are equal.
  template <typename Arguments>
  void fill(Arguments& arguments) {
    arguments.context = &context;
    arguments.filter = filter;
    const int flags = (coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT) |
                      (filter != nullptr ? RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER : 0);
    arguments.flags = static_cast<RTCRayQueryFlags>(flags);
  }
  RTCIntersectArguments to_intersect() {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    fill(arguments);
    return arguments;
  }
};

inline void intersect(const int* valid, RTCScene scene, EmbreeQuery& query, RTCRayHit16& rays) {
  RTCIntersectArguments arguments = query.to_intersect();
  rtcIntersect16(valid, scene, &rays, &arguments);
}
inline void intersect(const int* valid, RTCScene scene, EmbreeQuery& query, RTCRayHit8& rays) {
  RTCIntersectArguments arguments = query.to_intersect();
  rtcIntersect8(valid, scene, &rays, &arguments);
}
inline void intersect(RTCScene scene, EmbreeQuery& query, RTCRayHit& ray) {
  RTCIntersectArguments arguments = query.to_intersect();
  rtcIntersect1(scene, &ray, &arguments);
}
inline void occluded(RTCScene scene, EmbreeQuery& query, RTCRay& ray) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  query.fill(arguments);
  rtcOccluded1(scene, &ray, &arguments);
}

#else

using EmbreeContext = RTCIntersectContext;
inline constexpr auto kFilterInArguments = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

/// Context and options of one query. The context is the first member, so that a filter can cast its address to the
/// containing structure.
struct EmbreeQuery {
  EmbreeContext context;
  bool coherent = false;  ///< the rays of a packet have similar directions

  explicit EmbreeQuery(RTCFilterFunctionN filter = nullptr) {
    rtcInitIntersectContext(&context);
    context.filter = filter;
  }

  EmbreeContext* with_flags() {
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return &context;
  }
};

inline void intersect(const int* valid, RTCScene scene, EmbreeQuery& query, RTCRayHit16& rays) {
  rtcIntersect16(valid, scene, query.with_flags(), &rays);
}
inline void intersect(const int* valid, RTCScene scene, EmbreeQuery& query, RTCRayHit8& rays) {
  rtcIntersect8(valid, scene, query.with_flags(), &rays);
}
inline void intersect(RTCScene scene, EmbreeQuery& query, RTCRayHit& ray) {
  rtcIntersect1(scene, query.with_flags(), &ray);
}
inline void occluded(RTCScene scene, EmbreeQuery& query, RTCRay& ray) { rtcOccluded1(scene, query.with_flags(), &ray); }

#endif

}  // namespace swiftlet::sim
