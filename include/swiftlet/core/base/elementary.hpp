// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

/// Elementary functions with bit-identical results on all IEEE platforms; results of libm depend on version and
/// processor. Errors are a few units in the last place (tests/core/math/elementary_test.cpp).
namespace swiftlet::elementary {

namespace detail {

// ln 2 and pi/2 in parts whose products with small integers are exact.
inline constexpr double kLn2High = 6.93147180369123816490e-01, kLn2Low = 1.90821492927058770002e-10;
inline constexpr double kHalfPi1 = 1.57079632673412561417e+00, kHalfPi2 = 6.07710050630396597660e-11,
                        kHalfPi3 = 2.02226624879595063154e-21;

inline double scaled(double x, int exponent) {  // x 2^exponent, in two steps for results near the ends of the range
  const auto power = [](int e) { return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + e) << 52); };
  const int half = exponent / 2;
  return x * power(half) * power(exponent - half);
}

struct Reduced {
  double x = 0.0;  // within an eighth of a turn
  int quarter = 0;
};
inline Reduced reduced(double x) {
  // Beyond some thousand turns an angle is meaningless; the remainder by the double nearest to 2 pi is exact.
  if (std::abs(x) > 1e5) x = std::fmod(x, 2.0 * std::numbers::pi);
  const double k = std::floor(x * (2.0 * std::numbers::inv_pi) + 0.5);
  return {((x - k * kHalfPi1) - k * kHalfPi2) - k * kHalfPi3, static_cast<int>(k) & 3};
}
inline double sine_near_zero(double x) {
  const double z = x * x;
  double series = 1.0;
  for (int k = 18; k >= 2; k -= 2) series = 1.0 - series * z / (k * (k + 1));
  return x * series;
}
inline double cosine_near_zero(double x) {
  const double z = x * x;
  double series = 1.0;
  for (int k = 18; k >= 2; k -= 2) series = 1.0 - series * z / (k * (k - 1));
  return series;
}
inline double arc_tangent_of_unit(double x) {  // x in [0, 1]
  // atan x = atan c + atan((x - c) / (1 + x c)) with c the nearest eighth.
  constexpr double kOfEighths[] = {0.0,
                                   0.12435499454676144,
                                   0.24497866312686414,
                                   0.35877067027057225,
                                   0.4636476090008061,
                                   0.5585993153435624,
                                   0.6435011087932844,
                                   0.7188299996216245,
                                   0.7853981633974483};
  const int n = static_cast<int>(8.0 * x + 0.5);
  const double c = 0.125 * n, t = (x - c) / (1.0 + x * c), z = t * t;
  double series = 1.0 / 15.0;
  for (int k = 13; k >= 3; k -= 2) series = 1.0 / k - series * z;
  return kOfEighths[n] + (t - t * z * series);
}

}  // namespace detail

inline double sin(double x) {
  const detail::Reduced r = detail::reduced(x);
  const double value = r.quarter % 2 == 0 ? detail::sine_near_zero(r.x) : detail::cosine_near_zero(r.x);
  return r.quarter >= 2 ? -value : value;
}
inline double cos(double x) {
  const detail::Reduced r = detail::reduced(x);
  const double value = r.quarter % 2 == 0 ? detail::cosine_near_zero(r.x) : detail::sine_near_zero(r.x);
  return r.quarter == 1 || r.quarter == 2 ? -value : value;
}
inline double tan(double x) { return sin(x) / cos(x); }

inline double atan2(double y, double x) {
  const double ax = std::abs(x), ay = std::abs(y);
  if (!(std::max(ax, ay) > 0.0) || std::isinf(ax) || std::isinf(ay)) return std::atan2(y, x);  // exact by definition
  double angle =
      ay <= ax ? detail::arc_tangent_of_unit(ay / ax) : 0.5 * std::numbers::pi - detail::arc_tangent_of_unit(ax / ay);
  if (x < 0.0) angle = std::numbers::pi - angle;
  return std::copysign(angle, y);
}
inline double atan(double x) { return atan2(x, 1.0); }
inline double asin(double x) { return atan2(x, std::sqrt((1.0 - x) * (1.0 + x))); }
inline double acos(double x) { return atan2(std::sqrt((1.0 - x) * (1.0 + x)), x); }

inline double exp(double x) {
  if (!(x > -745.2)) return x < 0.0 ? 0.0 : x;  // NaN stays NaN
  if (x > 709.8) return HUGE_VAL;
  const double k = std::floor(x * std::numbers::log2e + 0.5);
  const double r = (x - k * detail::kLn2High) - k * detail::kLn2Low;
  double series = 1.0;
  for (int n = 14; n >= 1; --n) series = 1.0 + series * r / n;
  return detail::scaled(series, static_cast<int>(k));
}
inline double exp2(double x) {
  if (!(std::abs(x) < 1000.0)) return std::exp2(x);  // 0 or infinity
  const double k = std::floor(x + 0.5);
  return detail::scaled(exp((x - k) * std::numbers::ln2), static_cast<int>(k));
}

inline double log(double x) {
  if (!(x > 0.0) || std::isinf(x)) return std::log(x);  // infinities and NaN
  int exponent = 0;
  double m = std::frexp(x, &exponent);  // exact
  if (m < std::numbers::sqrt2 / 2.0) m *= 2.0, --exponent;
  // log m = 2 artanh s, s = (m - 1) / (m + 1), |s| < 0.172.
  const double s = (m - 1.0) / (m + 1.0), z = s * s;
  double series = 1.0 / 23.0;
  for (int k = 21; k >= 3; k -= 2) series = series * z + 1.0 / k;
  return exponent * detail::kLn2High + (2.0 * s + (2.0 * s * z * series + exponent * detail::kLn2Low));
}
/// Power of a non-negative base.
inline double pow(double base, double exponent) {
  if (exponent == 0.0 || base == 1.0) return 1.0;
  if (base == 0.0) return exponent > 0.0 ? 0.0 : HUGE_VAL;
  return exp(exponent * log(base));
}
inline double cbrt(double x) {
  if (x == 0.0 || !std::isfinite(x)) return x;
  const double a = std::abs(x);
  double root = exp(log(a) / 3.0);
  root -= (root - a / (root * root)) / 3.0;
  return std::copysign(root, x);
}
/// Euclidean norm without scaling: the squares must neither overflow nor underflow.
inline double hypot(double x, double y) { return std::sqrt(x * x + y * y); }
inline double hypot(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }

// Single precision: the double result, rounded.
inline float sin(float x) { return static_cast<float>(sin(static_cast<double>(x))); }
inline float cos(float x) { return static_cast<float>(cos(static_cast<double>(x))); }
inline float exp(float x) { return static_cast<float>(exp(static_cast<double>(x))); }
inline float hypot(float x, float y) {
  return static_cast<float>(hypot(static_cast<double>(x), static_cast<double>(y)));
}
inline float atan2(float y, float x) {
  return static_cast<float>(atan2(static_cast<double>(y), static_cast<double>(x)));
}

}  // namespace swiftlet::elementary
