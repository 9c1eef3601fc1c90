// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "experiments.hpp"

namespace swiftlet::tools {

std::span<const ExperimentType> experiment_types() {
  static constexpr std::array kTypes{
      ExperimentType{"uncertainty-table",
                     "Gaussian approximation of a measured point against Monte-Carlo [Vrba 2025, Table I]", 150.0,
                     uncertainty_table},
      ExperimentType{"occupancy-filters",
                     "Multi-state map against log-odds while an object flies through [Vrba 2025, Fig. 3]", 1.0,
                     occupancy_filters},
      ExperimentType{"expected-error", "Expected error of a measured point over its range [Vrba 2025, Fig. 5]", 60.0,
                     expected_error},
      ExperimentType{"voxel-probability",
                     "Probability that a measured point lies in the right voxel [Vrba 2025, Fig. 6]", 60.0,
                     voxel_probability},
      ExperimentType{"detection-ideal", "Detector and tracker without any noise [Vrba 2025, Table V and Fig. 11]",
                     510.0, detection_ideal},
      ExperimentType{"detection-noisy",
                     "Detector and tracker with noise, against theory [Vrba 2025, Table V and Fig. 11]", 1090.0,
                     detection_noisy},
      ExperimentType{"detection-multi", "Three targets, one behind a wall again and again [Vrba 2025, Figs. 9 and 10]",
                     4200.0, detection_multi},
      ExperimentType{"detection-real",
                     "Does reflectivity explain the lower recall of real flights? [Vrba 2025, Fig. 11]", 1200.0,
                     detection_real},
      ExperimentType{"detection-takeoff", "Take-off next to the ground, hover and landing [Vrba 2025, Fig. 4]", 300.0,
                     detection_takeoff},
      ExperimentType{"detection-timing", "What each stage of detector and tracker costs [Vrba 2025, Table VI]", 60.0,
                     detection_timing},
      ExperimentType{"detection-choices", "Each interpretation of what the document leaves open, on the same scans",
                     900.0, detection_choices},
      ExperimentType{"detection-latencies", "False detections in a forest at any latency of the detector's modules",
                     1000.0, detection_latencies},
      ExperimentType{"detection-beyond",
                     "Rolling sweeps, lost returns, another LiDAR, propellers, two observers [Vrba 2025, sec. V]",
                     1500.0, detection_beyond},
      ExperimentType{"interception",
                     "MPC, FRPN, proportional navigation and pursuit after random targets [Vrba 2025, sec. VI-B]",
                     2400.0, interception},
      ExperimentType{"rbl-circle",
                     "Five to fifteen vehicles cross a circle of 10 m, in 2D and 3D [Kamler 2025, sec. 2.4]", 600.0,
                     rbl_circle},
      ExperimentType{"rbl-circle-printed", "The same on the radius of 5 m that the text prints [Kamler 2025, sec. 2.4]",
                     500.0, rbl_circle_printed},
      ExperimentType{"rbl-sphere", "Ten and more vehicles cross a sphere [Kamler 2025, sec. 2.4]", 250.0, rbl_sphere},
      ExperimentType{"rbl-forest", "A Mid-360 through a forest on the map that it builds [Kamler 2025, sec. 3.4]",
                     800.0, rbl_forest},
      ExperimentType{"rbl-real", "The two real flights in a forest [Kamler 2025, Table 3.2]", 300.0, rbl_real},
      ExperimentType{"rbl-baselines", "PACNav and the vision-based model beside RBL [Kamler 2025, sec. 2.5]", 300.0,
                     rbl_baselines},
      ExperimentType{"rbl-limits", "More vehicles, worse neighbors, denser forests until it fails (beyond Kamler 2025)",
                     500.0, rbl_limits},
      ExperimentType{"rbl-ghosts", "A map that never clears locks the vehicle in [Kamler 2025, sec. 3.4]", 200.0,
                     rbl_ghosts},
  };
  return kTypes;
}

}  // namespace swiftlet::tools
