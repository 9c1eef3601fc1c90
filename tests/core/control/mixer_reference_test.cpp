// SPDX-License-Identifier: BSD-3-Clause
// The mixer beside its priorities written out: each part takes what it can, found by halving.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <functional>
#include <vector>

#include "swiftlet/core/control/mixer.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/support/airframes.hpp"

namespace swiftlet {
namespace {

/// The greatest share in [0, 1] that fits; the smaller ones fit then, too.
double greatest_share(const std::function<bool(double)>& fits) {
  if (fits(1.0)) return 1.0;
  double share = 0.0;
  for (double half = 0.5; half > 1e-15; half *= 0.5) {
    if (fits(share + half)) share += half;
  }
  return share;
}

Eigen::VectorXd plain_forces(const Airframe& airframe, const Wrench& wanted, double lift_N) {
  const int n = airframe.num_rotors();
  Eigen::MatrixXd B(4, n);
  for (int i = 0; i < n; ++i) {
    const Rotor& rotor = airframe.rotors[static_cast<std::size_t>(i)];
    const double drags = rotor.spin == Rotor::Spin::kCcw ? -1.0 : 1.0;
    B.col(i) << 1.0, rotor.position_m.y(), -rotor.position_m.x(), drags * airframe.torque_to_thrust_m;
  }
  const Eigen::MatrixXd inverse = B.completeOrthogonalDecomposition().pseudoInverse();
  const auto force_N = [&](double speed_radps) {
    return airframe.thrust_constant_N_per_radps2 * speed_radps * speed_radps;
  };
  const double least_N = force_N(airframe.rotor_speed_min_radps), most_N = force_N(airframe.rotor_speed_max_radps);
  constexpr double kSlack_N = 1e-12;

  Eigen::VectorXd tilt = inverse.middleCols(1, 2) * wanted.torque_body_Nm.head<2>();
  const Eigen::VectorXd lifted = inverse.col(0) * std::max(wanted.thrust_N, lift_N);
  tilt *= greatest_share([&](double share) {
    if (share * (tilt.maxCoeff() - tilt.minCoeff()) > most_N - least_N + kSlack_N) return false;
    // No rotor below its least for a lift that is allowed.
    for (int i = 0; i < n; ++i) {
      if (tilt[i] < 0.0 && share * -tilt[i] > std::max(lifted[i] - least_N, 0.0) + kSlack_N) return false;
    }
    return true;
  });

  double low_N = 0.0, high_N = 1e300;
  for (int i = 0; i < n; ++i) {
    low_N = std::max(low_N, (least_N - tilt[i]) / inverse(i, 0));
    high_N = std::min(high_N, (most_N - tilt[i]) / inverse(i, 0));
  }
  const double thrust_N = low_N > high_N ? (low_N + high_N) / 2.0 : std::max(low_N, std::min(high_N, wanted.thrust_N));
  const Eigen::VectorXd base = inverse.col(0) * thrust_N + tilt;
  const Eigen::VectorXd yaw = inverse.col(3) * wanted.torque_body_Nm.z();
  const double share = greatest_share([&](double tried) {
    for (int i = 0; i < n; ++i) {
      const double total_N = base[i] + tried * yaw[i];
      if (yaw[i] > 0.0 && total_N > most_N + kSlack_N) return false;
      if (yaw[i] < 0.0 && total_N < least_N - kSlack_N) return false;
    }
    return true;
  });
  return (base + share * yaw).cwiseMax(least_N).cwiseMin(most_N);
}

TEST(MixerReference, EveryForceIsThatOfThePriorities) {
  std::vector<Airframe> airframes;
  for (const auto& [name, airframe] : testing::all_airframes()) airframes.push_back(airframe);
  for (const int n : {4, 5, 6, 8}) airframes.push_back(testing::ring_of_rotors(n));
  // Unequal arms: rotors share the thrust unequally.
  airframes.push_back(testing::x500());
  airframes.back().rotors[0].position_m.x() *= 1.3;
  airframes.back().rotors[3].position_m.y() *= 0.8;
  const Random random(11, "test.mixer");
  std::uint32_t draw = 0;
  for (const Airframe& airframe : airframes) {
    const Mixer mixer(airframe);
    const double weight_N = airframe.mass_kg * 9.81;
    for (int i = 0; i < 300; ++i) {
      ++draw;
      const auto uniform = [&](double min, double max, std::uint32_t index) {
        return random.uniform(min, max, draw, index);
      };
      const double much = std::pow(10.0, uniform(-2.5, 0.5, 0)) * weight_N * airframe.arm_length_m;
      const Wrench wanted{uniform(-0.2, 1.5, 1) * airframe.max_thrust_N(),
                          {uniform(-much, much, 2), uniform(-much, much, 3), 0.3 * uniform(-much, much, 4)}};
      const double lift_N = i % 3 == 0 ? 1e300 : uniform(0.0, 1.5, 5) * weight_N;
      const Mixer::Forces got = mixer.forces(wanted, lift_N);
      const Eigen::VectorXd expected = plain_forces(airframe, wanted, lift_N);
      for (int k = 0; k < airframe.num_rotors(); ++k) {
        ASSERT_NEAR(got[static_cast<std::size_t>(k)], expected[k], 1e-7 * weight_N) << i << ", rotor " << k;
      }
    }
  }
}

TEST(MixerReference, NeedsFourRotorsAndTakesEight) {
  EXPECT_NO_THROW(Mixer{testing::ring_of_rotors(8)});
  EXPECT_THROW(Mixer{testing::ring_of_rotors(9)}, std::invalid_argument);
  EXPECT_NO_THROW(Mixer{testing::ring_of_rotors(4)});
}

}  // namespace
}  // namespace swiftlet
