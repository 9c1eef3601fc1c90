// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/view/recorder.hpp"

/// Flying-object detection against truth, as Vrba 2025 measures it: eqs. 67 to 71.
namespace swiftlet::tools {

/// One target in one scan, and what the detector or the tracker said of it.
struct Sighting {
  TimeNs t = 0;                      ///< middle of the scan
  TimeNs told = 0;                   ///< when it was judged: for a detection, when the detector was done with the scan
  int target = 0;                    ///< index among the targets
  double range_m = 0.0;              ///< true distance from sensor to target
  bool visible = false;              ///< within the vertical field of view, nothing in between
  int points = 0;                    ///< returns of the scan that lie on the target
  bool found = false;                ///< an estimate closer than 3 m: a true positive
  double error_m = 0.0;              ///< eq. (68), in the world that the observer believes in
  double drifted_error_m = 0.0;      ///< the same in the true world: with the error of its localization
  double speed_error_mps = 0.0;      ///< eq. (69), of tracks
  double direction_error_rad = 0.0;  ///< eq. (70), of tracks; NaN when the target hardly moves
  std::uint32_t track = 0;           ///< identity of the nearest track
  double in_view_s = 0.0;            ///< of tracks: for how long the target has been visible
  Vector3 p_m = Vector3::Zero();     ///< where it was, in the world that the observer believes in
  Vector3 estimate_m = Vector3::Zero();  ///< the estimate nearest to it, when found
};

/// A target is there once. So of all that is told of it the surest is right, and a second one is not.
/// @param off_m  of each from the target; from 3 m on it tells of another one, or of none
std::optional<std::size_t> surest_of(std::span<const Detection> detections, std::span<const double> off_m);

/// What one run shows, collected tick by tick: one vehicle observes, all others are targets, numbered without it. The
/// detector is judged for each scan that it worked on, by what it told of it, however late; the tracker at each new
/// scan, by the tracks of that instant.
class DetectionLog {
 public:
  /// @param fov_bottom_deg, fov_top_deg  lowest and highest beam of the observer's LiDAR
  /// @param ignored_s                    nothing is counted before: the map must first become free
  DetectionLog(const sim::Scenario& scenario, double fov_bottom_deg, double fov_top_deg, double ignored_s,
               std::size_t observer = 0);

  void add(const sim::Simulation& simulation);

  const std::vector<Sighting>& detections() const { return detections_; }  ///< by scan and target
  const std::vector<Sighting>& tracks() const { return tracks_; }          ///< by scan and target
  /// False detections are farther than 3 m from every target, false tracks never were near one.
  int num_told_detections() const { return num_told_detections_; }  ///< true ones, false ones and second ones
  int num_false_detections() const { return num_false_detections_; }
  /// The same of tracks, counted in every scan.
  int num_told_tracks() const { return num_told_tracks_; }
  int num_false_told_tracks() const { return num_false_told_tracks_; }
  int num_false_tracks() const;
  double observed_s() const { return observed_s_; }
  /// From now on what is told with less confidence counts neither as found nor as false, and all of it is in told().
  void count_from(double least_confidence) { least_confidence_ = least_confidence; }
  struct Told {
    double confidence = 0.0;
    bool is_target = false;
  };
  const std::vector<Told>& told() const { return told_; }
  /// Identities that followed one target and then another, closer than 1 m each.
  int num_cross_associations() const;

  /// All that the flight showed, and back again: FlightNotes::write and read.
  std::vector<double> numbers();
  void restore(std::span<const double> numbers);

 private:
  struct Truth {
    TimeNs t = 0;
    std::vector<Vector3> p_m, v_mps;  // by target
    Vector3 p_sensor_m;
    Matrix3 R_world_body;
    Pose T_estimate_truth;  // to the world that the observer believes in
  };
  struct SeenScan {
    TimeNs stamp = 0, middle = 0;
    std::vector<int> points;  // by target
  };
  template <class Stream>
  void exchange(Stream& stream);  // with a stream of numbers, one way or the other
  void remember(const sim::LabeledScan& labeled);
  const Truth& at(TimeNs t) const;
  const SeenScan* scan_of(TimeNs stamp) const;
  Sighting sighting_of(const SeenScan& scan, int target) const;
  double error_m(int target, TimeNs t, const Vector3& estimate_m) const;
  bool take(Sighting& sighting, TimeNs t, const Vector3& estimate_m) const;
  void find_unsure(const Action& action);
  void add_detections(const Action& action);
  void add_tracks(const Action& action);

  std::size_t observer_;
  sim::World world_;
  Vector3 p_body_lidar_m_ = Vector3(0.0, 0.0, 0.15);
  double sin_bottom_, sin_top_;
  TimeNs ignored_;
  std::vector<Truth> truth_;     // by tick
  std::vector<SeenScan> scans_;  // by time
  std::vector<Sighting> detections_, tracks_;
  double least_confidence_ = 0.0;   // 0: all counts
  std::set<std::uint32_t> unsure_;  // tracks that are told with less
  std::vector<Told> told_;
  int num_told_detections_ = 0, num_false_detections_ = 0, num_told_tracks_ = 0, num_false_told_tracks_ = 0;
  double observed_s_ = 0.0;
  std::map<std::uint32_t, std::vector<int>> targets_of_track_;  // in the order in which it followed them
  std::set<std::uint32_t> track_ids_;
  bool tracks_awaited_ = false;        // none were told since the newest scan
  std::vector<TimeNs> in_view_since_;  // by target; -1: it is not
};

/// Sightings of visible targets by true distance.
struct DistanceBin {
  double low_m = 0.0, high_m = 0.0;
  int count = 0, found = 0;
  std::vector<double> errors_m;
  double middle_m() const { return 0.5 * (low_m + high_m); }
  double recall() const;        ///< NaN without sightings
  double mean_error_m() const;  ///< of true positives; NaN without
};
/// @param least_in_view_s  only of targets that have been in view for so long
std::vector<DistanceBin> by_distance(const std::vector<const std::vector<Sighting>*>& runs, double width_m,
                                     double farthest_m, double least_in_view_s = 0.0);

}  // namespace swiftlet::tools
