// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::tools {

/// Makes the choices of rooms known that are built only where their packages are installed. First thing in a program.
void plug_in_optional_rooms();

}  // namespace swiftlet::tools
