// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/stages/guidances.hpp"

/// The row of the guidance `spiral`.
swiftlet::GuidanceType spiral();
