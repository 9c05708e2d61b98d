/// whorl_solver_tables SUBCOMMAND: measurements that call a solver directly, as CSV on standard output. tools/measure.py builds this
/// program, runs it and turns its output into tables of the pages.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "engine/core/parallel.h"
#include "tools/measure/solver/subcommands.h"

int main(int count, char** arguments) try {
    whorl::wait_passively(arguments);
    whorl::set_threads(1);
    CLI::App program{"Measurements that call a solver directly, as CSV on standard output (tools/measure.py turns it into tables)."};
    program.require_subcommand(1);
    whorl::add_viscous_models(program);
    whorl::add_viscous_preconditioners(program);
    whorl::add_pressure_solves(program);
    whorl::add_curls(program);
    CLI11_PARSE(program, count, arguments);
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "whorl_solver_tables: %s\n", error.what());
    return 1;
}
