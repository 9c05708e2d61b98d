#pragma once
/// Subcommands of whorl_solver_tables. Each prints one table as CSV, every row as soon as it is measured.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <tuple>

namespace CLI {
class App;
}

namespace whorl {

template <class... Cells>
void print_csv(const Cells&... cells) {
    fmt::print("{}\n", fmt::join(std::tuple<const Cells&...>(cells...), ","));
    std::fflush(stdout);
}

void add_viscous_models(CLI::App& program);
void add_viscous_preconditioners(CLI::App& program);
void add_pressure_solves(CLI::App& program);
void add_curls(CLI::App& program);

}  // namespace whorl
