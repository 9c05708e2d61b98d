#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "engine/core/parallel.h"
#include "engine/core/version.h"
#include "tools/command.h"

namespace {

const char* const examples =
    "Examples:\n"
    "  whorl render honey_coil                       frames, video and diagnostics in out/honey_coil\n"
    "  whorl render honey_coil --quality draft --until 1 --set fluid.viscosity=300\n"
    "  whorl render my_scene.toml --out runs/a --size 1920x1080 --export mesh\n"
    "  whorl plan my_scene.toml                      what would be modelled, why, and what it costs\n"
    "  whorl resume runs/a                           go on after an interruption\n";

/// CLI11 knows its own mistakes only; bad input of any kind ends with 2.
int end_of_parsing(CLI::App& program, const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return program.exit(e);  // --help, --version
    const CLI::App* at = &program;
    while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
    const std::string name = at == &program ? "whorl" : "whorl " + at->get_name();
    fmt::print(stderr, "{}: {}; see {} --help\n", name, e.what(), name);
    return whorl::exit_bad_input;
}

}  // namespace

int main(int argc, char** argv) {
    whorl::wait_passively(argv);
    CLI::App program("Whorl: viscous coils and micropolar vortices, from a scene file to a video", "whorl");
    program.set_version_flag("--version", std::string("whorl ") + WHORL_VERSION, "print the version");
    program.footer(examples);
    program.require_subcommand(1);

    whorl::Job chosen;
    whorl::add_schema(program, chosen);
    try {
        program.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return end_of_parsing(program, e);
    }
    return whorl::run_guarded(chosen);
}
