// SPDX-License-Identifier: BSD-3-Clause
#include "optional/rooms.hpp"

void swiftlet::tools::plug_in_optional_rooms() {}
