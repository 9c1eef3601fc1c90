// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "command_line.hpp"

/// The subcommands of `swiftlet`, one file each. Each adds itself to the program and sets its callback, which throws
/// InputError (exit status 2) or another exception (exit status 1).
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
void add_uncertainty(CLI::App& app);
void add_manual(CLI::App& app);

/// Parses the command line of a program with these subcommands and runs the chosen one.
/// @return the exit status: 0, 1 for a failure, 2 for wrong input, 128 + the signal for an interrupted run
int run(int argc, char** argv, const std::vector<void (*)(CLI::App&)>& subcommands);

}  // namespace swiftlet::tools
