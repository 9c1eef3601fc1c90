// SPDX-License-Identifier: BSD-3-Clause
#include "optional/rooms.hpp"
#include "swiftlet/core/pcl/clusters.hpp"

void swiftlet::tools::plug_in_optional_rooms() { plug_in_pcl(); }
