// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/beam_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/detection/direction_bins.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/rounding.hpp"

namespace swiftlet {
namespace {

/// [-] Distance of a beam from a target's center, in widths of the hit probability, beyond which the beam is taken to
/// miss. Larger values cost time; the probability of a hit is below 0.2 % there.
constexpr double kBeamReach_sigma = 2.5;
/// [rad] Least radius of the cone in which the density of beams is counted. Larger values smooth the density.
constexpr double kAround_rad = 0.1;
/// [beams] Expected hits after which the count stops: a sweep without returns is then practically impossible.
constexpr double kEnoughShots = 1000.0;
/// [m] Least range of a target; nearer ones have no exposure.
constexpr double kNearest_m = 0.2;
/// [-] Slope of the logistic curve that deviates by less than 0.01 from the normal distribution.
constexpr double kLogistic = 1.702;

// Probability that a beam did not end before a surface of uncertain range. A range of 0 is a beam without return.
double share_beyond(double range_m, double surface_m, double sigma_m) {
  if (range_m <= 0.0) return 1.0;
  const double beyond_sigma = (range_m - surface_m) / std::max(sigma_m, kRounding);
  return 1.0 / (1.0 + elementary::exp(-kLogistic * std::clamp(beyond_sigma, -20.0, 20.0)));
}

}  // namespace

void BeamIndex::assign(const LocalCloud& cloud, std::span<const Eigen::Vector3f> empty_lidar) {
  const Scan& scan = *cloud.scan;
  const BeamTable& table = *scan.beams;
  stamp_ = cloud.stamp();
  middle_ = cloud.stamp() + scan.duration / 2;
  half_sweep_s_ = 0.5 * to_seconds(scan.duration);
  const Pose& T_middle = cloud.T_local_lidar[static_cast<std::size_t>(scan.cols() / 2)];
  p_local_lidar_m_ = T_middle.translation();
  R_local_lidar_ = T_middle.linear();
  origins_local_m_.clear();
  offset_s_.clear();
  sensor_moved_m_ = 0.0;
  for (int column = 0; column < scan.cols(); ++column) {
    const auto at = static_cast<std::size_t>(column);
    origins_local_m_.push_back(cloud.T_local_lidar[at].translation());
    offset_s_.push_back(scan.duration == 0 ? 0.0 : table.column_offset_s[at] - half_sweep_s_);
    sensor_moved_m_ = std::max(sensor_moved_m_, (origins_local_m_.back() - p_local_lidar_m_).norm());
  }

  rotations_.clear();
  for (const Pose& T : cloud.T_local_lidar) rotations_.push_back(T.linear().cast<float>());
  unsorted_.clear();
  bin_of_.clear();
  starts_.assign(kAzimuths * kRows + 1, 0);
  nearest_return_m_.assign(kAzimuths * kRows, std::numeric_limits<float>::infinity());
  const bool masks = !table.masked.empty();
  for (int row = 0; row < scan.rows(); ++row) {
    for (int column = 0; column < scan.cols(); ++column) {
      const auto i = static_cast<std::size_t>(row * scan.cols() + column);
      if (masks && table.masked[i]) continue;
      add(table.directions_lidar[i], scan.range_m[i], column);
    }
  }
  for (const Eigen::Vector3f& d_lidar : empty_lidar) add(d_lidar, 0.0F, scan.cols() / 2);
  for (std::size_t b = 1; b < starts_.size(); ++b) starts_[b] += starts_[b - 1];
  beams_.resize(unsorted_.size());
  for (std::size_t i = 0; i < unsorted_.size(); ++i) beams_[starts_[bin_of_[i]]++] = unsorted_[i];
  for (std::size_t b = starts_.size() - 1; b > 0; --b) starts_[b] = starts_[b - 1];  // restores the start of each bin
  starts_[0] = 0;
}

void BeamIndex::add(const Eigen::Vector3f& direction_lidar, float range_m, int column) {
  const Eigen::Vector3f d = rotations_[static_cast<std::size_t>(column)] * direction_lidar;
  if (!d.allFinite() || d.isZero(0.0F) || !(range_m >= 0.0F)) return;
  const int bin = bin_of(d.cast<double>());
  unsorted_.push_back({d, range_m, column});
  bin_of_.push_back(static_cast<std::uint16_t>(bin));
  ++starts_[static_cast<std::size_t>(bin) + 1];
  float& nearest_m = nearest_return_m_[static_cast<std::size_t>(bin)];
  if (range_m > 0.0F) nearest_m = std::min(nearest_m, range_m);
}

int BeamIndex::bin_of(const Vector3& d) {
  return bin_in(d.z() + 1.0, 2.0, kRows) * kAzimuths + bin_in(turn_of(d.x(), d.y()), 4.0, kAzimuths);
}

double BeamIndex::nearest_return_m(const Vector3& direction_local) const {
  const int bin = bin_of(direction_local), row = bin / kAzimuths, turn = bin % kAzimuths;
  float nearest_m = std::numeric_limits<float>::infinity();
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, kRows - 1); ++r) {
    for (int t = turn + kAzimuths - 1; t <= turn + kAzimuths + 1; ++t) {
      nearest_m = std::min(nearest_m, nearest_return_m_[static_cast<std::size_t>(r * kAzimuths + t % kAzimuths)]);
    }
  }
  return nearest_m;
}

BeamExposure BeamIndex::exposure(const RoundTarget& target) const {
  BeamExposure result;
  const Vector3 p_m = target.p_local_m + to_seconds(middle_ - target.t) * target.v_local_mps;
  const Vector3 from_lidar_m = p_m - p_local_lidar_m_;
  const double range_m = from_lidar_m.norm();
  if (!(range_m > kNearest_m) || beams_.empty()) return result;
  const Vector3 d = from_lidar_m / range_m;
  const double width_sq = target.radius_m * target.radius_m + 2.0 * target.sigma_m * target.sigma_m;
  const double moves_m = sensor_moved_m_ + half_sweep_s_ * target.v_local_mps.norm();
  const double reach =
      std::min(1.0, (kBeamReach_sigma * std::sqrt(0.5 * width_sq) + target.radius_m + moves_m) / range_m);
  const double reach_rad = std::max(elementary::asin(reach), kAround_rad);

  // Bins that overlap the cone of reach_rad around the target: rows by elevation, then bins of each row by azimuth.
  const double elevation = elementary::asin(std::clamp(d.z(), -1.0, 1.0)), pole = 0.5 * std::numbers::pi;
  const double low_z = elevation - reach_rad <= -pole ? -1.0 : elementary::sin(elevation - reach_rad);
  const double high_z = elevation + reach_rad >= pole ? 1.0 : elementary::sin(elevation + reach_rad);
  const int first_row = bin_in(low_z + 1.0, 2.0, kRows), last_row = bin_in(high_z + 1.0, 2.0, kRows);
  const double flat = std::sqrt(d.x() * d.x() + d.y() * d.y()), sine = elementary::sin(std::min(reach_rad, pole));
  int first_turn = 0, num_turn = kAzimuths;
  if (sine < 0.7 * flat) {  // the cone does not contain a pole
    const double s = sine / flat, c = std::sqrt(1.0 - s * s);
    const int last_turn = bin_in(turn_of(c * d.x() - s * d.y(), c * d.y() + s * d.x()), 4.0, kAzimuths);
    first_turn = bin_in(turn_of(c * d.x() + s * d.y(), c * d.y() - s * d.x()), 4.0, kAzimuths);
    num_turn = (last_turn - first_turn + kAzimuths) % kAzimuths + 1;
  }

  double num_beams = 0.0;
  for (int row = first_row; row <= last_row; ++row) {
    for (int k = 0; k < num_turn; ++k) {
      const auto bin = static_cast<std::size_t>(row * kAzimuths + (first_turn + k) % kAzimuths);
      num_beams += starts_[bin + 1] - starts_[bin];
      if (result.shots > kEnoughShots) continue;
      for (std::uint32_t i = starts_[bin]; i < starts_[bin + 1]; ++i) {
        const Beam& beam = beams_[i];
        const auto column = static_cast<std::size_t>(beam.column);
        const Vector3 to_m = p_m + offset_s_[column] * target.v_local_mps - origins_local_m_[column];
        const Vector3 direction = beam.direction_local.cast<double>();
        const double along_m = to_m.dot(direction);
        if (along_m <= 0.0) continue;
        const double across_sq = to_m.squaredNorm() - along_m * along_m;
        const double exponent = across_sq / width_sq;
        if (exponent > kBeamReach_sigma * kBeamReach_sigma) continue;
        const double shots = target.radius_m * target.radius_m / width_sq * elementary::exp(-exponent);
        result.shots += shots * share_beyond(beam.range_m, along_m - target.radius_m, target.sigma_m);
      }
    }
  }
  const double num_bins = static_cast<double>(num_turn) * (last_row - first_row + 1);
  result.beams_per_sr = num_beams / (num_bins * 4.0 * std::numbers::pi / (kAzimuths * kRows));
  return result;
}

}  // namespace swiftlet
