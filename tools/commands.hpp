// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "command_line.hpp"

/// The subcommands of `swiftlet`, one file each. Each adds itself to the program and sets its callback, which throws
/// InputError (exit status 2) or any other exception (exit status 1).
namespace swiftlet::tools {

void add_run(CLI::App& app);
void add_batch(CLI::App& app);
void add_report(CLI::App& app);
void add_render(CLI::App& app);
void add_replay(CLI::App& app);
void add_world(CLI::App& app);
void add_check(CLI::App& app);
void add_list(CLI::App& app);
void add_reference(CLI::App& app);
void add_bench(CLI::App& app);
void add_dataset(CLI::App& app);
void add_reproduce(CLI::App& app);
void add_uncertainty(CLI::App& app);
void add_manual(CLI::App& app);

}  // namespace swiftlet::tools
