// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/empty_directions.hpp"

#include <algorithm>
#include <cmath>

#include "core/detection/direction_bins.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// Limits of the test whether a direction is empty.
struct Quiet {
  /// [bins] Returns up to this far away keep a bin from being empty. Larger values leave a wider ring of unknown air
  /// around every return; smaller ones clear air through leaves and along grazing surfaces.
  static constexpr int kReach = 1;
  /// [sweeps] Time for which a return keeps its bin from being empty. A non-repetitive pattern misses bins for a sweep;
  /// larger values leave a longer trail of unknown air behind a moving object.
  static constexpr std::uint32_t kSweeps = 2;
};

// [bins] Step of the position within a bin from sweep to sweep, along the row; across rows its square: the evenly
// distributed sequence R2 of Roberts 2018. Other steps test some places of a bin again and leave others out.
constexpr double kStepTurn = 0.7548776662466927;

double fraction(double x) { return x - std::floor(x); }

}  // namespace

void FieldOfView::visit(ConfigVisitor& v) {
  v.field("bottom_deg", bottom_deg, "[deg] lowest elevation in the frame of the LiDAR", Range::between(-90.0, 90.0));
  v.field("top_deg", top_deg, "[deg] highest elevation; both 0: learned, from lowest to highest return so far",
          Range::between(-90.0, 90.0));
  v.field("width_deg", width_deg, "[deg] width in azimuth, half to each side of the LiDAR's x axis; 360: full turn",
          Range{0.0, 360.0, true});
  v.check(bottom_deg < top_deg || is_learned(), "top_deg", "more than bottom_deg");
}

EmptyDirections::EmptyDirections(const FieldOfView& view)
    : learns_(view.is_learned()),
      turn_seen_(kAzimuths, !learns_),
      returned_in_(static_cast<std::size_t>(kRows) * kAzimuths, 0) {
  if (learns_) return;
  bottom_z_ = static_cast<float>(elementary::sin(view.bottom_deg * kRadPerDeg));
  top_z_ = static_cast<float>(elementary::sin(view.top_deg * kRadPerDeg));
  least_x_ = static_cast<float>(elementary::cos(0.5 * view.width_deg * kRadPerDeg));
}

std::span<const Eigen::Vector3f> EmptyDirections::find(const Scan& scan) {
  empty_.clear();
  is_needed_ = false;
  const BeamTable& beams = *scan.beams;
  for (int i = 0; i < scan.size(); ++i) {
    const bool is_masked = !beams.masked.empty() && beams.masked[i] != 0;
    if (!scan.hit(i) && !is_masked && has_direction(beams, i)) return empty_;
  }
  is_needed_ = true;
  ++sweep_;
  take_returns(scan);
  const double in_turn = fraction(kStepTurn * sweep_), in_row = fraction(kStepTurn * kStepTurn * sweep_);
  const int first_row = bin_in(bottom_z_ + 1.0, 2.0, kRows), last_row = bin_in(top_z_ + 1.0, 2.0, kRows);
  for (int row = first_row; row <= last_row; ++row) {
    for (int turn = 0; turn < kAzimuths; ++turn) {
      const Eigen::Vector3f d =
          direction_at(4.0 * (turn + in_turn) / kAzimuths, 2.0 * (row + in_row) / kRows - 1.0).cast<float>();
      if (is_in_view(d, turn) && is_quiet(row, turn)) empty_.push_back(d);
    }
  }
  return empty_;
}

// Masked beams hit the own vehicle, which hides the air behind, and therefore count as returns.
void EmptyDirections::take_returns(const Scan& scan) {
  const BeamTable& beams = *scan.beams;
  for (int i = 0; i < scan.size(); ++i) {
    const Eigen::Vector3f& d = beams.directions_lidar[i];
    if (!has_direction(beams, i) || !d.allFinite()) continue;
    const int row = bin_in(d.z() + 1.0, 2.0, kRows), turn = bin_in(turn_of(d.x(), d.y()), 4.0, kAzimuths);
    returned_in_[static_cast<std::size_t>(row * kAzimuths + turn)] = sweep_;
    if (!learns_ || !scan.hit(i)) continue;
    bottom_z_ = std::min(bottom_z_, d.z());
    top_z_ = std::max(top_z_, d.z());
    turn_seen_[static_cast<std::size_t>(turn)] = true;
  }
}

bool EmptyDirections::is_in_view(const Eigen::Vector3f& d, int turn) const {
  if (d.z() < bottom_z_ || d.z() > top_z_ || !turn_seen_[static_cast<std::size_t>(turn)]) return false;
  return least_x_ <= -1.0F || d.x() >= least_x_ * d.head<2>().norm();
}

bool EmptyDirections::is_quiet(int row, int turn) const {
  for (int r = std::max(row - Quiet::kReach, 0); r <= std::min(row + Quiet::kReach, kRows - 1); ++r) {
    for (int t = turn - Quiet::kReach; t <= turn + Quiet::kReach; ++t) {
      const std::uint32_t returned_in =
          returned_in_[static_cast<std::size_t>(r * kAzimuths + (t + kAzimuths) % kAzimuths)];
      if (returned_in > 0 && sweep_ - returned_in < Quiet::kSweeps) return false;
    }
  }
  return true;
}

}  // namespace swiftlet
