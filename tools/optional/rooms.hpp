// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::tools {

/// Registers modules of optional libraries that are built only where their packages are installed. Call it first.
void plug_in_optional_rooms();

}  // namespace swiftlet::tools
