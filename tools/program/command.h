#pragma once
/// Subcommands of the program. Each has a file with one add_NAME(), and a line in main.cpp. main() parses the command line, then calls the
/// job of the chosen subcommand inside run_guarded(), which turns exceptions into messages and exit codes.
#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>

#include "tools/process/process.h"

namespace whorl {

/// Action of the chosen subcommand; returns an ExitCode. May throw InputError (2) and EnvironmentError (1).
using Job = std::function<int()>;

template <class O>
struct Command {
    CLI::App& app;
    O& options;  ///< exist as long as the program
};

/// Adds a subcommand whose job is run(options). @param footer examples, printed by --help
template <class O>
Command<O> add_command(CLI::App& program, Job& chosen, const std::string& name, const std::string& purpose, int (*run)(const O&),
                       const std::string& footer) {
    const auto options = std::make_shared<O>();
    CLI::App* app = program.add_subcommand(name, purpose)->footer(footer);
    app->callback([options, run, &chosen] { chosen = [options, run] { return run(*options); }; });
    return {*app, *options};
}

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
