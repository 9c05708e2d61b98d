#pragma once
/// How a subcommand joins the program: one file a subcommand, one add_NAME() in it, one line in main.cpp.
///
/// add_NAME() adds a CLI11 subcommand with its options (tools/scene_file/options.h), sets a callback that stores what to run in `chosen`,
/// and returns. main() parses, then calls `chosen` inside run_guarded(), which alone turns exceptions into messages and exit codes.
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

/// whorl(1) in roff's man macros.
std::string man_page(const CLI::App& program);
/// A script for bash-completion: subcommands, their options, names of shipped scenes, files.
std::string bash_completion(const CLI::App& program);

}  // namespace whorl
