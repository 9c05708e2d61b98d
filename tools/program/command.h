#pragma once
/// Subcommands of the program. Each has a file with one add_NAME(), and a line in main.cpp.
///
/// add_NAME() adds a CLI11 subcommand with its options (tools/scene_file/options.h), and sets a callback that stores the command's
/// action in `chosen`. main() parses the command line, then calls `chosen` inside run_guarded(), which turns exceptions into messages and
/// exit codes.
#include <functional>
#include <string>

#include "tools/process/process.h"

namespace CLI {
class App;
}

namespace whorl {

/// Action of the chosen subcommand; returns an ExitCode. May throw InputError (2) and EnvironmentError (1).
using Job = std::function<int()>;

void add_render(CLI::App& program, Job& chosen);
void add_live(CLI::App& program, Job& chosen);
void add_plan(CLI::App& program, Job& chosen);
void add_resume(CLI::App& program, Job& chosen);
void add_draw(CLI::App& program, Job& chosen);
void add_farm(CLI::App& program, Job& chosen);
void add_video(CLI::App& program, Job& chosen);
void add_doctor(CLI::App& program, Job& chosen);
void add_import(CLI::App& program, Job& chosen);
void add_tradeoff(CLI::App& program, Job& chosen);
void add_stability(CLI::App& program, Job& chosen);
void add_manual(CLI::App& program, Job& chosen);
void add_schema(CLI::App& program, Job& chosen);

/// Manual page whorl(1) in roff, with the macros of man.
std::string man_page(const CLI::App& program);
/// Script for bash-completion of subcommands, their options, names of shipped scenes, files.
std::string bash_completion(const CLI::App& program);

}  // namespace whorl
