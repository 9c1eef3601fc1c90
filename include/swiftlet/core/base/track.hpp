// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// A flying object tracked over time [Vrba 2025, sec. III-F]: position, velocity and acceleration. Local frame between
/// stages, world in Action.
struct Track {
  static constexpr const char* kName = "tracks";
  std::uint32_t id = 0;
  TimeNs t = 0;
  Vector3 position_m = Vector3::Zero();
  Vector3 velocity_mps = Vector3::Zero();
  Vector3 acceleration_mps2 = Vector3::Zero();
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Identity();
  int num_detections = 0;                             ///< detections associated so far
  bool corrected = false;                             ///< a measurement was associated in the newest cloud
  Vector3 measured_m = Vector3::Zero();               ///< the newest measured position
  Matrix3 measured_covariance = Matrix3::Identity();  ///< covariance of measured_m
  double reflectivity = 0.0;                          ///< maximum over the returns of that measurement; 0: not known

  static void visit(auto& t, auto& v) {
    v.time("t_s", t.t, "[s] time of validity, in the newest cloud");
    v.field("id", t.id, "[-] identity of the track");
    v.field("*_m", t.position_m, "[m] position in the world frame as estimated by the vehicle");
    v.field("v*_mps", t.velocity_mps, "[m/s] velocity, in the same axes");
    v.field("a*_mps2", t.acceleration_mps2, "[m/s^2] acceleration, in the same axes");
    v.covariance("cov_*_m2", t.covariance, "[m^2] covariance of the position");
    v.field("num_detections", t.num_detections, "[-] detections associated so far");
    v.field("corrected", t.corrected, "[-] 1: a measurement was found in the newest cloud");
    v.field("measured_*_m", t.measured_m, "[m] newest measured position");
    v.covariance("measured_cov_*_m2", t.measured_covariance, "[m^2] covariance of the measured position");
    v.field("reflectivity", t.reflectivity,
            "[-] maximum over the returns of the measurement; 1: white Lambertian, 0: not known");
  }
};

/// State of one track in a tracker with several motion models: estimates by the single models. Local frame.
struct TrackModes {
  enum Model { kConstantVelocity, kConstantAcceleration, kCoordinatedTurn, kModels };
  std::uint32_t id = 0;                                             ///< id of the track
  std::array<double, kModels> probability{};                        ///< probabilities of the models; they sum to 1
  std::array<Eigen::Matrix<double, 9, 1>, kModels> mean_local_m{};  ///< position, velocity, acceleration by each model
};

}  // namespace swiftlet
