// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Range at which Scan::intensity equals the reflectivity of a Lambertian surface at normal incidence.
inline constexpr float kIntensityRange_m = 10.0F;

/// Noise of the measured range, by one of two laws.
/// `constant`: sigma_range_m [Vrba 2025, eq. 66], or a table by range; linear between its points, constant outside.
/// `signal`: sigma^2 = floor^2 + (sigma_at_reference * (reference_snr / S)^exponent)^2 with the S of DetectionConfig;
/// floor = floor_m + floor_rise_m * log10(floor_snr / S), not below floor_m. The defaults are fitted to an OS1-128's
/// data sheet and to recorded frames (tests/sim/scenario/lidar_noise_fit_test.cpp).
/// Either law is multiplied by factor(incidence), if there is such a table.
struct RangeNoiseConfig {
  enum class Law { kConstant, kSignal };
  Law law = Law::kConstant;
  double sigma_range_m = 0.03;
  double floor_m = 0.0079;
  double floor_rise_m = 0.0033;
  double floor_snr = 2000.0;
  double sigma_at_reference_m = 0.1;
  double reference_snr = 0.54;
  double exponent = 0.76;
  std::vector<double> table_range_m;
  std::vector<double> table_sigma_m;
  std::vector<double> table_incidence_deg;
  std::vector<double> table_incidence_factor;

  void visit(ConfigVisitor& v);
};

/// Detection of returns by the receiver. The received signal, in standard deviations of the receiver's noise, is
///   S = G * reflectivity * cos(incidence) * range^-n
/// for a surface larger than the beam. A return is detected when S + noise > threshold. G and n follow from the two
/// ranges in a data sheet at which the detection probability is 0.9 for Lambertian targets at normal incidence, with 10
/// % and with 80 % reflectivity. n is 2 in vacuum (range_80 = 2.83 range_10). Data sheets give 1.9 (OS1) or, where
/// firmware limits the range, more.
struct DetectionConfig {
  bool always = false;
  double range_10_percent_m = 40.0;
  double range_80_percent_m = 120.0;
  double retro_gain = 20.0;  ///< signal of a retro-reflector relative to a Lambertian surface of its reflectivity

  void visit(ConfigVisitor& v);
};

/// Width of the beam. Sub-rays are the cubature points of a Gaussian beam: 5 = center and a cross, 9 = 3 x 3
/// Gauss-Hermite. Echoes within a pulse's length merge into one at their power-weighted range (mixed pixel); of
/// separate echoes the strongest is returned.
struct BeamWidthConfig {
  int sub_rays = 1;
  double divergence_deg = 0.18;  ///< full width at half maximum
  double pulse_length_m = 0.5;

  void visit(ConfigVisitor& v);
};

/// Tables of noise and detection, for fast evaluation.
class LidarMeasurement {
 public:
  LidarMeasurement(const RangeNoiseConfig& noise, const DetectionConfig& detection, double range_max_m, bool ideal);

  /// Standard deviation of the range noise [m] of a surface with reflectivity * cos(incidence) = `brightness`.
  float sigma_m(float range_m, float cos_incidence, float brightness) const {
    float sigma = 0.0F, gain = 0.0F;
    look_up(range_m, cos_incidence, brightness, sigma, gain);
    return sigma;
  }
  /// Signal over receiver noise of a surface with reflectivity * cos(incidence) = `brightness` that fills the beam.
  float snr(float range_m, float brightness) const { return brightness * interpolate(range_m).gain; }
  /// Standard deviation and gain with one table look-up.
  void look_up(float range_m, float cos_incidence, float brightness, float& sigma, float& gain) const {
    const Entry entry = interpolate(range_m);
    gain = entry.gain;
    sigma = signal_sigmas_m_.empty() ? entry.sigma_m : signal_sigma_m(brightness * gain);
    if (!flat_incidence_) sigma *= incidence_factor(cos_incidence);
  }
  float threshold_snr() const { return threshold_; }
  /// Probability that a return of this signal is detected: Phi(snr - threshold), 0 or 1 beyond 4.5 standard deviations.
  double detection_probability(float snr) const;
  /// True if a return is detected, given one draw of a standard normal. `draw` is only called when it can change the
  /// result.
  template <class Draw>
  bool detected(float snr, Draw&& draw) const {
    const float margin = snr - threshold_;
    if (margin > kCertain) return true;
    if (margin < -kCertain) return false;
    return margin + static_cast<float>(draw()) > 0.0F;
  }

 private:
  /// [-] Margin in standard deviations of the noise beyond which the detection is certain and no number is drawn.
  static constexpr float kCertain = 4.5F;
  struct Entry {
    float sigma_m, gain;
  };
  Entry interpolate(float range_m) const {
    const float place = range_m * entries_per_m_;
    const int before = static_cast<int>(place);
    if (before >= last_) return entries_[last_];
    const float s = place - static_cast<float>(before);
    const Entry a = entries_[before];
    const Entry b = entries_[before + 1];
    return {a.sigma_m + s * (b.sigma_m - a.sigma_m), a.gain + s * (b.gain - a.gain)};
  }
  float signal_sigma_m(float snr) const;
  float incidence_factor(float cos_incidence) const;

  std::vector<Entry> entries_;  // at equal steps of the range
  float entries_per_m_ = 1.0F;
  int last_ = 0;
  std::vector<float> signal_sigmas_m_;    // at equal steps of 1 / sqrt(snr), 0..1; empty: another law
  std::vector<float> incidence_factors_;  // at equal steps of the cosine, 0..1
  bool flat_incidence_ = true;
  float threshold_ = 0.0F;
};

}  // namespace swiftlet::sim
