// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/shared_tracks/observer_history.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/shared_tracks/shared_tracks_config.hpp"

namespace swiftlet {

/// Finds the pose of another observer's local frame by comparing paths: tracks and own path of one observer with those
/// of the other.
///
/// A level alignment that maps one path onto another is a hypothesis that both are of one body. Straight paths are
/// ambiguous, because any two of equal speed match, and so are uncertain ones; so the curvature of a path counts in its
/// standard deviations. A hypothesis is accepted when its alignment maps further paths onto each other, because
/// coincident motion of two bodies is unlikely. A single pair is accepted when its path curves sufficiently for a long
/// time. No hypothesis is accepted while another alignment is supported as well. The accepted one is fitted to all its
/// pairs by `RelativeAlignment`.
class PathComparison {
 public:
  PathComparison(const FrameLinkConfig& config, const OdometryDriftConfig& drift)
      : config_(config), drift_config_(drift), drift_(drift) {}

  /// Lists the paths of both histories, the observers first. The histories must outlive their use.
  void list(const ObserverHistory& own, const ObserverHistory& other);
  std::span<const SampledPath* const> own() const { return own_paths_; }
  std::span<const SampledPath* const> other() const { return other_paths_; }
  /// Alignment about the anchor; nothing without sufficient evidence.
  std::optional<FrameAlignment> find(const OtherMotion& anchor) const;

 private:
  /// A pair of paths that may be of one body.
  struct Match {
    std::size_t own = 0, other = 0;  // indices of the paths; 0: the observer itself
    FrameAlignment alignment;
    double duration_s = 0.0;
    double bends = 0.0;                                      // curvature in standard deviations
    std::vector<std::pair<std::size_t, std::size_t>> pairs;  // (own, other) path pairs that fit the alignment
  };

  std::optional<Match> match(std::size_t own, std::size_t other, const OtherMotion& anchor) const;
  void find_support(Match& match, const OtherMotion& anchor) const;
  bool supports(std::size_t own, std::size_t other, const FrameAlignment& alignment, const OtherMotion& anchor) const;
  void append_pairs(std::size_t own, std::size_t other, double yaw_rad, std::vector<AlignmentPair>& pairs) const;

  FrameLinkConfig config_;
  OdometryDriftConfig drift_config_;
  OdometryDrift drift_;
  std::vector<const SampledPath*> own_paths_, other_paths_;
};

}  // namespace swiftlet
