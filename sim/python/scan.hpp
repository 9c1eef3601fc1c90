// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>

#include <memory>

#include "swiftlet/core/base/scan.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"

namespace swiftlet::python {

/// A scan held by Python, with its truth where access is allowed.
struct HeldScan {
  std::shared_ptr<const Scan> scan;
  std::shared_ptr<const sim::LabeledScan> labeled;  ///< null: no truth
  bool has_mount = true;                            ///< false: T_body_lidar of the scan was not given

  explicit HeldScan(std::shared_ptr<const Scan> of) : scan(std::move(of)) {}
  explicit HeldScan(std::shared_ptr<const sim::LabeledScan> of) : scan(of, &of->scan), labeled(std::move(of)) {}
};

}  // namespace swiftlet::python
