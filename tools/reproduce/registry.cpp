// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "experiments.hpp"

namespace swiftlet::tools {

std::span<const ExperimentType> experiment_types() {
  static constexpr std::array kTypes{
      ExperimentType{"uncertainty-table",
                     "Gaussian approximation of a measured point against Monte-Carlo (000, Table I)", 150.0,
                     uncertainty_table},
      ExperimentType{"expected-error", "Expected error of a measured point over its range (000, Fig. 5)", 60.0,
                     expected_error},
      ExperimentType{"voxel-probability", "Probability that a measured point lies in the right voxel (000, Fig. 6)",
                     60.0, voxel_probability},
  };
  return kTypes;
}

}  // namespace swiftlet::tools
