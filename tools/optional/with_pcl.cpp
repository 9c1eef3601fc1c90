// SPDX-License-Identifier: BSD-3-Clause
#include "core/pcl/clusters.hpp"
#include "optional/rooms.hpp"

void swiftlet::tools::plug_in_optional_rooms() { plug_in_pcl(); }
