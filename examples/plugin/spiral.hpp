// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/stage_tables/guidances.hpp"

/// Registry row of the guidance `spiral`.
swiftlet::GuidanceType spiral();
