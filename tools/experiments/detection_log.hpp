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

/// One target in one scan, and the nearest estimate of the detector or tracker.
struct Sighting {
  TimeNs t = 0;                          ///< middle of the scan
  TimeNs told = 0;                       ///< time of evaluation: for a detection, when the detector finishes the scan
  int target = 0;                        ///< index among the targets
  double range_m = 0.0;                  ///< true distance from sensor to target
  bool visible = false;                  ///< within the vertical field of view, nothing in between
  int points = 0;                        ///< returns of the scan that lie on the target
  bool found = false;                    ///< an estimate closer than 3 m: a true positive
  double error_m = 0.0;                  ///< eq. (68), in the world that the observer believes in
  double drifted_error_m = 0.0;          ///< as error_m, in the true world: includes the observer's localization error
  double speed_error_mps = 0.0;          ///< eq. (69), tracks only
  double direction_error_rad = 0.0;      ///< eq. (70), tracks only; NaN when the target hardly moves
  std::uint32_t track = 0;               ///< identity of the nearest track
  double in_view_s = 0.0;                ///< tracks only: time since the target came into view
  Vector3 p_m = Vector3::Zero();         ///< target, in the world that the observer believes in
  Vector3 estimate_m = Vector3::Zero();  ///< nearest estimate, when found
};

/// Index of the most confident detection within 3 m of a target: the one correct report of it; others are duplicates.
/// @param off_m  distance of each detection to the target
std::optional<std::size_t> surest_of(std::span<const Detection> detections, std::span<const double> off_m);

/// Results of one run, collected tick by tick: one vehicle observes, all others are targets, numbered without it. The
/// detector is evaluated on each scan that it processes, with the detections it reports for this scan, however late;
/// the tracker at each new scan, with the tracks of that instant.
class DetectionLog {
 public:
  /// @param fov_bottom_deg, fov_top_deg  lowest and highest beam of the observer's LiDAR
  /// @param ignored_s                    nothing is counted before: the map must first become free
  DetectionLog(const sim::Scenario& scenario, double fov_bottom_deg, double fov_top_deg, double ignored_s,
               std::size_t observer = 0);

  void add(const sim::Simulation& simulation);

  const std::vector<Sighting>& detections() const { return detections_; }  ///< ordered by scan and target
  const std::vector<Sighting>& tracks() const { return tracks_; }          ///< ordered by scan and target
  /// False detections are farther than 3 m from every target; false tracks never follow one.
  int num_told_detections() const { return num_told_detections_; }  ///< true, false and duplicate ones
  int num_false_detections() const { return num_false_detections_; }
  /// Reported tracks, counted anew in every scan.
  int num_told_tracks() const { return num_told_tracks_; }
  int num_false_told_tracks() const { return num_false_told_tracks_; }
  int num_false_tracks() const;
  double observed_s() const { return observed_s_; }
  /// From now on reports with less confidence count neither as found nor as false; all of them remain listed below.
  void count_from(double least_confidence) { least_confidence_ = least_confidence; }
  struct Told {
    double confidence = 0.0;
    bool is_target = false;
  };
  const std::vector<Told>& told() const { return told_; }
  /// How often a track changes from one target to another, closer than 1 m each.
  int num_cross_associations() const;

  /// Results of the flight as numbers, and back: FlightNotes::write and read.
  std::vector<double> numbers();
  void restore(std::span<const double> numbers);

 private:
  struct Truth {
    TimeNs t = 0;
    std::vector<Vector3> p_m, v_mps;  // for each target
    Vector3 p_sensor_m;
    Matrix3 R_world_body;
    Pose T_estimate_truth;  // into the world that the observer believes in
  };
  struct SeenScan {
    TimeNs stamp = 0, middle = 0;
    std::vector<int> points;  // number on each target
  };
  template <class Stream>
  void exchange(Stream& stream);  // reads from or writes to a stream of numbers
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
  std::vector<Truth> truth_;     // one each tick
  std::vector<SeenScan> scans_;  // sorted by time
  std::vector<Sighting> detections_, tracks_;
  double least_confidence_ = 0.0;   // 0: every report counts
  std::set<std::uint32_t> unsure_;  // tracks reported with less confidence
  std::vector<Told> told_;
  int num_told_detections_ = 0, num_false_detections_ = 0, num_told_tracks_ = 0, num_false_told_tracks_ = 0;
  double observed_s_ = 0.0;
  std::map<std::uint32_t, std::vector<int>> targets_of_track_;  // in the order in which the track follows them
  std::set<std::uint32_t> track_ids_;
  bool tracks_awaited_ = false;        // no tracks reported since the newest scan
  std::vector<TimeNs> in_view_since_;  // for each target; -1: out of view
};

/// Sightings of visible targets by true distance.
struct DistanceBin {
  double low_m = 0.0, high_m = 0.0;
  int count = 0, found = 0;
  std::vector<double> errors_m;
  double middle_m() const { return 0.5 * (low_m + high_m); }
  double recall() const;        ///< NaN without sightings
  double mean_error_m() const;  ///< mean over true positives; NaN without any
};
/// @param least_in_view_s  leaves out targets that came into view more recently
std::vector<DistanceBin> by_distance(const std::vector<const std::vector<Sighting>*>& runs, double width_m,
                                     double farthest_m, double least_in_view_s = 0.0);

}  // namespace swiftlet::tools
