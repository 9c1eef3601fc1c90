// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/lidar_measurement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {
namespace {

// [-] Entries of the tables over range, incidence and signal. More entries interpolate more exactly.
constexpr int kRangeEntries = 2048;
constexpr int kIncidenceEntries = 256;
constexpr int kSignalEntries = 1024;
constexpr double kQuantile90 = 1.2815515655446004;  // Phi(this) = 0.9
// [-] Detection threshold in standard deviations of the receiver's noise. With larger values the probability of a
// return falls within a shorter interval of range.
constexpr double kThresholdSnr = 6.0;
// [-] Reflectivities to which the two ranges of a data sheet refer.
constexpr double kReflectivityLow = 0.1;
constexpr double kReflectivityHigh = 0.8;

bool ascending(const std::vector<double>& values) {
  return std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end();
}

double linear(const std::vector<double>& x, const std::vector<double>& y, double at) {
  if (at <= x.front()) return y.front();
  if (at >= x.back()) return y.back();
  const auto after = std::upper_bound(x.begin(), x.end(), at) - x.begin();
  const double s = (at - x[after - 1]) / (x[after] - x[after - 1]);
  return y[after - 1] + s * (y[after] - y[after - 1]);
}

}  // namespace

void RangeNoiseConfig::visit(ConfigVisitor& v) {
  v.choice("law", law, {"constant", "signal"}, "[-] law of the standard deviation: constant (or table), or by signal");
  v.field("sigma_range_m", sigma_range_m,
          "[m] standard deviation of the range if constant; the value known to the agent", Range::non_negative());
  v.field("floor_m", floor_m, "[m] signal: least standard deviation, for strong signals", Range::non_negative());
  v.field("floor_rise_m", floor_rise_m,
          "[m] signal: increase of the floor per tenfold decrease of the signal below floor_snr",
          Range::non_negative());
  v.field("floor_snr", floor_snr, "[-] signal: signal-to-noise ratio above which the floor is floor_m",
          Range::positive());
  v.field("sigma_at_reference_m", sigma_at_reference_m, "[m] signal: part added in quadrature at reference_snr",
          Range::non_negative());
  v.field("reference_snr", reference_snr,
          "[-] signal: signal-to-noise ratio at which the added part is sigma_at_reference_m", Range::positive());
  v.field("exponent", exponent, "[-] signal: exponent of the decrease of the added part with the signal",
          Range::between(0, 4));
  v.field("table_range_m", table_range_m, "[m] ranges of table_sigma_m, ascending; empty: constant sigma_range_m",
          Range::non_negative());
  v.field("table_sigma_m", table_sigma_m, "[m] standard deviations at table_range_m", Range::non_negative());
  v.field("table_incidence_deg", table_incidence_deg, "[deg] incidences of table_incidence_factor, ascending",
          Range::between(0, 90));
  v.field("table_incidence_factor", table_incidence_factor,
          "[-] factors of the standard deviation at table_incidence_deg", Range::non_negative());
  v.check(table_sigma_m.size() == table_range_m.size(), "table_sigma_m", "as many values as table_range_m");
  v.check(ascending(table_range_m), "table_range_m", "ascending ranges");
  v.check(table_incidence_factor.size() == table_incidence_deg.size(), "table_incidence_factor",
          "as many values as table_incidence_deg");
  v.check(ascending(table_incidence_deg), "table_incidence_deg", "ascending incidences");
}

void DetectionConfig::visit(ConfigVisitor& v) {
  v.field("always", always, "[-] whether every surface within range_max_m is detected");
  v.field("range_10_percent_m", range_10_percent_m,
          "[m] range at which 9 of 10 shots on a Lambertian surface of 10 % reflectivity return", Range::positive());
  v.field("range_80_percent_m", range_80_percent_m,
          "[m] range at which 9 of 10 shots on a Lambertian surface of 80 % reflectivity return", Range::positive());
  v.field("retro_gain", retro_gain,
          "[-] signal of a retro-reflector relative to a Lambertian surface of its reflectivity", Range::positive());
  v.check(range_80_percent_m > range_10_percent_m, "range_80_percent_m", "more than range_10_percent_m");
}

void BeamWidthConfig::visit(ConfigVisitor& v) {
  v.field("sub_rays", sub_rays, "[-] rays per beam: 1, 5 or 9", Range::between(1, 9));
  v.field("divergence_deg", divergence_deg, "[deg] full width of the beam at half maximum", Range::between(0, 10));
  v.field("pulse_length_m", pulse_length_m, "[m] distance below which two echoes merge into one",
          Range::non_negative());
  v.check(sub_rays == 1 || sub_rays == 5 || sub_rays == 9, "sub_rays", "1, 5 or 9");
}

LidarMeasurement::LidarMeasurement(const RangeNoiseConfig& noise, const DetectionConfig& detection, double range_max_m,
                                   bool ideal) {
  last_ = kRangeEntries;
  entries_per_m_ = static_cast<float>(kRangeEntries / range_max_m);
  const bool all_detected = ideal || detection.always;
  threshold_ = all_detected ? -1e30F : static_cast<float>(kThresholdSnr);
  const double exponent = elementary::log(kReflectivityHigh / kReflectivityLow) /
                          elementary::log(detection.range_80_percent_m / detection.range_10_percent_m);
  const double snr_90 = kThresholdSnr + kQuantile90;
  for (int i = 0; i <= kRangeEntries; ++i) {
    const double range_m = i * range_max_m / kRangeEntries;
    Entry entry{};
    if (!ideal) {
      entry.sigma_m =
          static_cast<float>(noise.table_range_m.empty() ? noise.sigma_range_m
                                                         : linear(noise.table_range_m, noise.table_sigma_m, range_m));
    }
    // Within the first step, the gain at its end: such near surfaces are detected in any case.
    const double far_enough_m = std::max(range_m, range_max_m / kRangeEntries);
    entry.gain = static_cast<float>(snr_90 / kReflectivityLow *
                                    elementary::pow(detection.range_10_percent_m / far_enough_m, exponent));
    entries_.push_back(entry);
  }
  for (int i = 0; i <= kSignalEntries && noise.law == RangeNoiseConfig::Law::kSignal && !ideal; ++i) {
    const double inverse_snr = elementary::pow(static_cast<double>(i) / kSignalEntries, 2);
    const double decades_below = elementary::log(std::max(noise.floor_snr * inverse_snr, 1.0)) / std::numbers::ln10;
    signal_sigmas_m_.push_back(static_cast<float>(elementary::hypot(
        noise.floor_m + noise.floor_rise_m * decades_below,
        noise.sigma_at_reference_m * elementary::pow(noise.reference_snr * inverse_snr, noise.exponent))));
  }
  flat_incidence_ = noise.table_incidence_deg.empty();
  for (int i = 0; i <= kIncidenceEntries && !flat_incidence_; ++i) {
    const double incidence_deg = degrees(elementary::acos(static_cast<double>(i) / kIncidenceEntries));
    incidence_factors_.push_back(
        static_cast<float>(linear(noise.table_incidence_deg, noise.table_incidence_factor, incidence_deg)));
  }
}

// Interpolates over 1 / sqrt(snr), which makes the law almost linear between entries.
float LidarMeasurement::signal_sigma_m(float snr) const {
  const float place = std::sqrt(1.0F / std::max(snr, 1.0F)) * kSignalEntries;
  const int before = std::min(static_cast<int>(place), kSignalEntries - 1);
  const float s = place - static_cast<float>(before);
  return signal_sigmas_m_[before] + s * (signal_sigmas_m_[before + 1] - signal_sigmas_m_[before]);
}

float LidarMeasurement::incidence_factor(float cos_incidence) const {
  const float place = std::clamp(cos_incidence, 0.0F, 1.0F) * kIncidenceEntries;
  const int before = std::min(static_cast<int>(place), kIncidenceEntries - 1);
  const float s = place - static_cast<float>(before);
  return incidence_factors_[before] + s * (incidence_factors_[before + 1] - incidence_factors_[before]);
}

double LidarMeasurement::detection_probability(float snr) const {
  const double margin = static_cast<double>(snr) - threshold_;
  if (margin > kCertain) return 1.0;
  if (margin < -kCertain) return 0.0;
  return 0.5 * std::erfc(-margin / std::numbers::sqrt2);
}

}  // namespace swiftlet::sim
