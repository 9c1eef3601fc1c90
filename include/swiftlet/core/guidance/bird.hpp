// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "swiftlet/core/guidance/agile.hpp"

namespace swiftlet {

/// Flight of a small bird: 5 to 12 m/s (Alerstam et al., PLoS Biology 5(8), 2007) with sudden turns. Flapping
/// alternates with folded wings, which gives bounding flight (Rayner, J. Theor. Biol. 117, 1985; Tobalske,
/// Bioinspiration and Biomimetics 5, 2010). The bird perches from time to time.
struct BirdConfig : ModuleConfigOf<BirdConfig> {
  std::uint64_t seed = 1;
  double speed_max_mps = 9.0;
  double speed_min_mps = 5.0;
  double acceleration_max_mps2 = 5.0;
  Eigen::Vector3d area_min_m = {-30.0, -30.0, 4.0};
  Eigen::Vector3d area_max_m = {30.0, 30.0, 10.0};
  double turn_s = 2.0;
  std::vector<Eigen::Vector3d> perches_m;

  void visit(ConfigVisitor& v) override;
};

/// Endless flight: an AgileSpline with targets changed by the bird, plus bounds: a harmonic of the height that begins
/// and ends smoothly. Any frame, the same for all arguments.
class BirdFlight {
 public:
  /// Begins at rest at `start`.
  BirdFlight(const BirdConfig& config, const Vector3& start_m, double vertical_speed_mps,
             double vertical_acceleration_mps2);

  void advance(double dt_s);
  /// Position, velocity, acceleration now.
  Reference reference() const;
  bool is_perched() const { return phase_ == Phase::kPerched; }

 private:
  enum class Phase { kFlying, kToPerch, kPerched };
  void fly();
  void seek_perch();
  double drawn_s(double mean_s);
  /// Share of the bounds and its first two time derivatives: a quintic that begins and ends at rest.
  void bounding_share(double (&share)[3]) const;

  BirdConfig config_;
  Random random_;
  AgileSpline spline_;
  Phase phase_ = Phase::kFlying;
  double t_s_ = 0.0, turn_at_s_ = 0.0, change_at_s_ = 0.0;
  double bounds_since_s_ = 0.0;  ///< time of the last change of bounds_
  bool bounds_ = false;
  Vector3 perch_m_ = Vector3::Zero();
  std::uint32_t num_drawn_ = 0;
};

/// Throws std::invalid_argument when speed or acceleration are beyond the motion limits.
std::unique_ptr<Guidance> make_bird(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
