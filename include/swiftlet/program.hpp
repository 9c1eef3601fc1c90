// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The program `swiftlet` as a function, for programs with additional modules. Add rows to the registries, then call
/// it:
///
///   int main(int argc, char** argv) {
///     guidance_registry().add({{"orbit", "circles around a point", make_module_config<OrbitConfig>}, make_orbit});
///     return swiftlet::main(argc, argv);
///   }
namespace swiftlet {

/// Every subcommand of `swiftlet`, its messages and exit statuses.
int main(int argc, char** argv);

}  // namespace swiftlet
