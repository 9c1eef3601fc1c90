// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/localization/relative_odometry.hpp"

namespace swiftlet {

/// Alignment of the local frames of other observers.
struct FrameLinkConfig {
  double window_s = 15.0;     ///< [s] length of the paths that are compared
  double interval_s = 0.5;    ///< [s] interval between measurements, so that their errors are independent
  double gap_max_s = 0.8;     ///< [s] longest gap of a path that is interpolated
  int min_samples = 20;       ///< [-] least samples of a reported path for a comparison
  double min_spread_m = 2.0;  ///< [m] least horizontal RMS distance of a path from its mean, for a comparison
  /// [m] least RMS distance of a path from a straight motion of constant velocity: straight ones are ambiguous
  double min_bend_m = 1.0;
  double bend_sigmas = 4.0;  ///< [-] least distance of a path from such a motion, in standard deviations of the path
  double support_s = 3.0;    ///< [s] least overlap of other paths that support an alignment
  double support_sigma_m = 1.0;  ///< [m] largest standard deviation, per axis, of an overlap that supports an alignment
  double alone_s = 10.0;         ///< [s] least length of a single path that determines an alignment
  double alone_sigmas = 12.0;    ///< [-] least distance of a single path from a straight motion, in standard deviations
  /// [-] largest RMS residual per axis between two paths of one body, in standard deviations
  double residual_sigma_max = 1.5;
  double gate_sigma = 4.0;  ///< [-] largest distance between tracks of one body, in standard deviations
  /// [-] twice the log-likelihood ratio by which a pair must exceed the next alternative
  double margin = 9.2;
  double sigma_own_m = 0.02;  ///< [m] standard deviation of an observer's own position
  /// [m] standard deviation that does not average out: each observer sees its own side of a target
  double sigma_common_m = 0.05;
  double position_sigma_max_m = 1.5;   ///< [m] standard deviation of the position above which an alignment is lost
  double heading_sigma_max_deg = 5.0;  ///< [deg] standard deviation of the heading above which an alignment is lost
};

struct TrackFusionConfig {
  double reported_existence = 0.5;
  double prior_existence = 2e-4;  ///< [-] prior probability of a target at a reported position
  /// [-] squared Mahalanobis distance of position and velocity up to which two tracks may be one target
  double gate_sq = 22.5;
  double merge_sq = 12.6;  ///< [-] squared Mahalanobis distance up to which two tracks agree on one target
  double break_sq = 33.0;  ///< [-] squared Mahalanobis distance above which joined tracks are separated
  /// [-] twice the log-likelihood ratio by which a partner must exceed the next one
  double margin = 9.2;
  double sure_m = 1.0;         ///< [m] largest standard deviation of the distance of two tracks for a confirmation
  int confirmations = 3;       ///< [-] agreements less disagreements after which two tracks are joined
  double split_after_s = 2.0;  ///< [s] time without agreement after which possibly equal targets are reported as two
  double remember_s = 10.0;    ///< [s] time for which the identity of an unreported target is kept

  void visit(ConfigVisitor& v);
};

/// Several observers of the same targets, each with a track-before-detect detector; docs/detection.md.
struct SharedTracksConfig : ModuleConfigOf<SharedTracksConfig> {
  double rate_hz = 5.0;
  int max_sent = 16;       ///< [-] largest number of tracks in a message, the likeliest first; 120 bytes each
  double certainty = 0.9;  ///< [-] probability of existence of own tracks whose detector reports none
  double timeout_s = 1.0;
  double acceleration_density = 3.0;  ///< [m^2/s^3] white acceleration of a target per axis, since the track's report
  FrameLinkConfig frame;
  OdometryDriftConfig drift;
  TrackFusionConfig fusion;

  void visit(ConfigVisitor& v) override;
};

}  // namespace swiftlet
