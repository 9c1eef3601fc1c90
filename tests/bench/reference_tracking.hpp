// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/LU>
#include <deque>
#include <span>
#include <vector>

#include "swiftlet/core/base/detection.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/background_query.hpp"

/// Algorithm 2 of Vrba 2025 as printed, line by line, with Table II, for frozen scans. A slow reference for the
/// tracker's results.
namespace swiftlet::reference {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Points = std::vector<Vector3>;

struct PlainTrack {
  Vector9 x;
  Matrix9 P;
  int num_detections = 1;
};

class PlainTracker {
 public:
  std::vector<PlainTrack> tracks;  // T

  void new_point_cloud(const LocalCloud& cloud, const BackgroundQuery& O) {
    Points points;
    for (const Eigen::Vector3f& p : cloud.points_local_m) points.push_back(p.cast<double>());
    buffer_.push_back({cloud.stamp(), points});    // line 10
    if (buffer_.size() > 10) buffer_.pop_front();  // lines 11-13
    const double dt_s = buffer_.size() > 1 ? to_seconds(cloud.stamp() - buffer_[buffer_.size() - 2].t) : 0.0;
    std::vector<PlainTrack> kept;
    for (PlainTrack& T : tracks) {  // lines 14-19
      update_track(T, points, O, dt_s);
      if (!(r_unc(T.P) > 5.0)) kept.push_back(T);
    }
    tracks = kept;
  }

  void new_detections(std::span<const Detection> detections, const BackgroundQuery& O) {
    for (const Detection& D : detections) {  // line 21
      PlainTrack T;                          // eqs. (35), (36)
      T.x.setZero();
      T.x.head<3>() = D.position_m;
      Vector9 sigma;
      sigma << Vector3::Constant(0.3), Vector3::Constant(1.0), Vector3::Constant(1.0);
      T.P = sigma.cwiseAbs2().asDiagonal();
      TimeNs t = D.t;
      for (const auto& [stamp, points] : buffer_) {  // lines 23-25
        if (stamp <= D.t) continue;
        update_track(T, points, O, to_seconds(stamp - t));
        t = stamp;
      }
      if (r_unc(T.P) > 5.0) continue;  // line 26
      PlainTrack* similar = nullptr;
      for (PlainTrack& other : tracks) {  // line 27
        if ((other.x.head<3>() - T.x.head<3>()).norm() <= r_unc(other.P) + r_unc(T.P)) similar = &other;
      }
      if (similar != nullptr)
        ++similar->num_detections;  // line 28
      else
        tracks.push_back(T);  // line 30
    }
  }

 private:
  struct Stored {
    TimeNs t;
    Points points;
  };

  static double r_unc(const Matrix9& P) { return 1.5 * std::cbrt(P.topLeftCorner<3, 3>().determinant()); }  // eq. (29)

  static void update_track(PlainTrack& T, const Points& P, const BackgroundQuery& O, double dt_s) {
    Matrix9 A = Matrix9::Identity();  // eq. (30)
    A.block<3, 3>(0, 3) = A.block<3, 3>(3, 6) = dt_s * Matrix3::Identity();
    A.block<3, 3>(0, 6) = 0.5 * dt_s * dt_s * Matrix3::Identity();
    Vector9 xi;  // eq. (34), for a step of 0.1 s
    xi << Vector3::Constant(0.01), Vector3::Constant(0.2), Vector3::Constant(0.3);
    T.x = A * T.x;
    const Matrix9 AP = A.lazyProduct(T.P);
    T.P = AP.lazyProduct(A.transpose()) + Matrix9((dt_s / 0.1 * xi.cwiseAbs2()).asDiagonal());

    const Vector3 r = T.x.head<3>();
    Points near;  // line 37
    for (const Vector3& p : P) {
      if ((p - r).norm() <= std::max(2.5, r_unc(T.P))) near.push_back(p);
    }
    double least = 1e300;
    Vector3 z = Vector3::Zero();
    for (const Points& C : clusters(near)) {  // lines 38-44
      Vector3 c = Vector3::Zero();
      for (const Vector3& p : C) c += p / static_cast<double>(C.size());
      if (O.occupied_within(c, 1.0) || (c - r).norm() >= least) continue;
      least = (c - r).norm();
      z = c;
    }
    if (least == 1e300) return;
    Eigen::Matrix<double, 3, 9> H = Eigen::Matrix<double, 3, 9>::Zero();  // line 45
    H.leftCols<3>().setIdentity();
    const Matrix3 Z = 0.09 * Matrix3::Identity();
    const Eigen::Matrix<double, 9, 3> K = T.P * H.transpose() * (H * T.P * H.transpose() + Z).inverse();
    T.x += K * (z - H * T.x);
    const Matrix9 I_KH = Matrix9::Identity() - K * H;
    T.P = Matrix9(I_KH.lazyProduct(T.P));
  }

  static std::vector<Points> clusters(Points rest) {
    std::vector<Points> out;
    while (!rest.empty()) {
      Points cluster = {rest.back()};
      rest.pop_back();
      for (std::size_t k = 0; k < cluster.size(); ++k) {
        for (std::size_t j = 0; j < rest.size();) {
          if ((cluster[k] - rest[j]).norm() > 0.25) {
            ++j;
            continue;
          }
          cluster.push_back(rest[j]);
          rest[j] = rest.back();
          rest.pop_back();
        }
      }
      out.push_back(cluster);
    }
    return out;
  }

  std::deque<Stored> buffer_;  // B
};

}  // namespace swiftlet::reference
